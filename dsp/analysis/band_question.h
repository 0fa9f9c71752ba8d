#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dsp/analysis/band_noise.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/filter/butterworth.h"
#include "dsp/findings.h"

namespace haptometer::dsp {

/// From `begin_s` up to and without `end_s`, on the record's time base.
struct TimeWindow {
  double begin_s = 0;
  double end_s = 0;

  [[nodiscard]] double duration_s() const { return end_s - begin_s; }
};

/// Which part of a record the numbers are of.
enum class WindowChoice : std::uint8_t {
  kAuto,   ///< the steady part of the drive (dsp/analysis/window/window_choice.h)
  kAll,    ///< all that has settled
  kGiven,  ///< a window that was asked for, as far as it has settled
};

/// Where a noise level is from.
enum class NoiseSource : std::uint8_t {
  kFile,    ///< a drive-off trial
  kQuiet,   ///< intervals of the record without drive
  kBeside,  ///< the spectrum beside the drive, in the window itself
};

/// Noise without drive, in a band.
struct NoiseFloor {
  NoisePower power;
  double duration_s = 0;  ///< that it was measured over
  NoiseSource from = NoiseSource::kFile;
  std::string file{};               ///< of kFile
  std::vector<TimeWindow> quiet{};  ///< of kQuiet
  // the rest is of a file only
  double rate_hz = 0;
  std::optional<double> tone_hz{};  ///< its strongest tone
  double tone_amplitude_m = 0;
  bool has_drive = false;           ///< the drive was on
  std::vector<Finding> refusals{};  ///< what spoke against an answer
};

/// What is asked of a record.
struct BandQuestion {
  BandPass band;
  /// Whether a lower order may be taken where the asked one leaves too little settled.
  bool may_lower_order = true;
  WindowChoice choice = WindowChoice::kAuto;
  TimeWindow window;  ///< where `choice` is kGiven
  /// Of a drive-off trial (FloorOf); measured in the record's own quiet part where absent.
  std::optional<NoiseFloor> floor;
  /// For a record too slow for the band, and for hum at the drive's frequency; the file's metadata
  /// is asked where absent.
  std::optional<double> drive_frequency_hz;
  /// Relative standard uncertainty of the sensor's gain; the record's calibration where absent.
  std::optional<double> gain_uncertainty = {};
  bool keep_hum = false;      ///< whether hum of the mains counts as vibration
  bool keep_filtered = true;  ///< whether BandAnalysis::filtered_m is filled: 8 B a row
};

}  // namespace haptometer::dsp
