#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "dsp/filter/butterworth.h"
#include "dsp/spectrum/sine_fit.h"
#include "trial/record.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// A band-pass is used only on records sampled at least this often per cycle of its upper corner.
inline constexpr double kLeastRatePerUpperCorner = 2.56;

/// What is asked of a record.
struct BandQuestion {
  BandPass band;
  /// Whether a lower order may be taken where the asked one leaves too little settled.
  bool may_lower_order = true;
};

/// From `begin_s` up to and without `end_s`, on the record's time base.
struct TimeWindow {
  double begin_s = 0;
  double end_s = 0;
};

/// Motion below the band and what of it the filter lets through.
struct BelowBand {
  double frequency_hz = 0;  ///< of the strongest tone below the lower corner
  double amplitude_m = 0;   ///< before the filter
  double leaked_rms_m = 0;  ///< amplitude |H(frequency)|^2 / sqrt(2): part of the band RMS
};

/// What a record says about vibration in a band. Where `answered` is false the band's own numbers
/// are absent; everything that can be known all the same is there.
struct BandAnalysis {
  bool answered = false;
  std::vector<std::string> reasons;  ///< why not, each with what would help; empty when answered
  std::vector<std::string> remarks;  ///< what was left out, lowered or assumed

  // Known of every record with one measurement or more.
  double rate_hz = 0;              ///< of the longest stretch
  double fresh_rate_hz = 0;        ///< the same without readings handed out again
  double duration_s = 0;           ///< of all stretches together
  double observable_upper_hz = 0;  ///< fresh_rate_hz / 2.56
  double offset_m = 0;             ///< mean of all measurements
  double peak_to_peak_m = 0;       ///< of all measurements, unfiltered
  std::size_t rows = 0;
  std::size_t measured = 0;  ///< rows with a measurement
  std::size_t bridged = 0;   ///< rows interpolated
  std::size_t segments = 0;  ///< pieces filtered each on its own
  std::array<std::size_t, trial::kSampleStatusCount> by_status{};  ///< rows of each status

  // The band.
  BandPass band;                                 ///< as used: the order may have been lowered
  std::optional<TimeWindow> window;              ///< whole periods of the tone, all settled
  std::optional<double> band_rms_m;              ///< over `window`
  std::optional<double> band_rms_uncertainty_m;  ///< see AnalyzeBand
  std::optional<double> band_rms_whole_m;        ///< all filtered samples, unsettled ends too
  std::optional<double> band_peak_to_peak_m;     ///< over `window`
  std::optional<double> residual_rms_m;          ///< without the tone, over all that settled
  std::optional<double> bridged_rms_m;           ///< bound on what bridging adds; 0: none bridged
  std::optional<BelowBand> below_band;
  std::optional<SineFit> tone;                ///< corrected for the filter's gain
  std::optional<double> sensor_gain_at_tone;  ///< of its averaging; not divided out

  /// Row by row: the filtered signal (NaN where there is none) and, for the window, its rows.
  std::vector<double> filtered_m;
  std::size_t window_first_row = 0;
  std::size_t window_rows = 0;
};

/// Answers how much a record vibrates within a band.
///
/// The first displacement channel is split into segments (dsp/analysis/segments.h); each is
/// filtered with zero phase on its own. The window is the longest settled part of any segment
/// (dsp/filter/settled.h), shortened to whole periods of the strongest tone in it. Too little
/// settled (below 2 periods of the lower corner): the order is lowered as far as 2, as long as what
/// leaks from below the band changes the RMS by less than 1 %; otherwise the record is not
/// answered. The tone's amplitude is divided by |H|^2 at its frequency.
///
/// The standard uncertainty of the RMS is that of a tone of amplitude A in Gaussian noise of RMS s,
/// flat over the band of width B, observed for T seconds:
///   u^2 = (A^2 s^2 + s^4) / (4 B T RMS^2)
/// (Bendat and Piersol, Random Data, 4th ed., 8.2, for A = 0). It does not hold for other motion
/// and knows nothing of the sensor's calibration.
///
/// Not answered: fewer new readings a second than 2.56 x the upper corner; a polled
/// sensor whose times are uncertain by 0.1/upper corner or more (its readings are of unknown age;
/// a free-running one has a clock, however its arrivals scatter); too little settled. Errors: a
/// wrong band (Cause::kUsage), no displacement channel in metres, no measurement in it
/// (Cause::kCannotAnswer).
/// `threads` changes no number. Further errors: as RowSource::Read.
[[nodiscard]] Result<BandAnalysis> AnalyzeBand(const trial::RowSource& source,
                                               const BandQuestion& question, int threads = 1);
/// The same of a record in memory.
[[nodiscard]] Result<BandAnalysis> AnalyzeBand(const trial::Record& record,
                                               const BandQuestion& question);

}  // namespace haptometer::dsp
