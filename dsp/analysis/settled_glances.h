#pragma once

#include <vector>

#include "base/result.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

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

  [[nodiscard]] double duration_s() const;  ///< of a window

  /// The amplitude of a tone, or of noise, within kWander of a frequency that all windows but the
  /// quietest eighth are above.
  [[nodiscard]] double LeastAmplitude(double frequency_hz) const;
  /// Likewise the mean square amplitude from half an octave below to half an octave above it.
  [[nodiscard]] double NoisePower(double frequency_hz) const;

  /// Takes out of each window the sine of this frequency that is nearest to it.
  void TakeOutTone(double frequency_hz);

 private:
  SettledGlances() = default;

  std::vector<std::vector<double>> windows_m_;  // of every n-th sample: these hold the band
  double rate_hz_ = 0;
};

}  // namespace haptometer::dsp
