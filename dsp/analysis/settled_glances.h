#pragma once

#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// A tone that is in all of what has settled.
struct SteadyTone {
  double frequency_hz = 0;
  double amplitude_m = 0;
};

/// Tones that go on in what has settled of a signal (mains hum, a drive that is never off), the
/// strongest first, four at most: as long as the strongest tone that is left has 0.3 of its
/// amplitude or more in each eighth of it but one between the ends. One that has not is a drive
/// with a pause, and what is left of it when a sine is taken out would be in every eighth.
///
/// Of a long signal the middle is asked (used_part.h). Errors: as RowSource::Read. Cost: four fits
/// over at most 2^21 samples.
[[nodiscard]] Result<std::vector<SteadyTone>> FindSteadyTones(const BandSignal& signal,
                                                              const BandPass& band);

/// Up to 31 short windows of what has settled of a signal, evenly spread: two periods of the lower
/// corner each, or an eighth of what has settled where that is less.
///
/// What is asked of them is told by the quietest eighth, so that a drive that is on in most of what
/// has settled, or has been, does not pass for something that goes on.
class SettledGlances {
 public:
  /// At least kLeastSettled samples must have settled. Errors: as RowSource::Read.
  [[nodiscard]] static Result<SettledGlances> Read(const BandSignal& signal, const BandPass& band);

  static constexpr std::size_t kLeastSettled = 8;
  /// A tone that goes on may wander by so much of its frequency: one that is driven stays within
  /// 0.1 %, but a resonance that rings on, or a hand that loads it, moves by some per cent.
  static constexpr double kWander = 0.05;
  /// A tone with so much of its amplitude goes on there, as in dsp/analysis/drive_part.h. Measured
  /// (see brief_tone.cc): of a drive 0.02 or less in 99 of 100, of what goes on 0.49 and more.
  static constexpr double kElsewhere = 0.3;

  [[nodiscard]] double duration_s() const;  ///< of a window

  /// The amplitude of a tone, or of noise, within kWander of a frequency that all windows but the
  /// quietest eighth are above.
  [[nodiscard]] double LeastAmplitude(double frequency_hz) const;
  /// Likewise the mean square amplitude from half an octave below to half an octave above it.
  [[nodiscard]] double NoisePower(double frequency_hz) const;

  /// Takes out of each window the sines of these frequencies that are nearest to it, one by one.
  void TakeOut(std::span<const SteadyTone> tones);

 private:
  SettledGlances() = default;

  std::vector<std::vector<double>> windows_m_;  // of every n-th sample: these hold the band
  double rate_hz_ = 0;
};

}  // namespace haptometer::dsp
