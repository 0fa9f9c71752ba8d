#pragma once

#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/welch.h"

namespace haptometer::dsp {

/// Power over time and frequency.
struct Spectrogram {
  double resolution_hz = 0;                  ///< bin k lies at k times this
  double noise_bandwidth_hz = 0;             ///< of the window (ENBW)
  double start_s = 0;                        ///< middle of the first segment, from the first sample
  double step_s = 0;                         ///< between segments
  std::vector<std::vector<double>> density;  ///< (segments, bins), one-sided, unit^2/Hz
};

/// The spectrum of each segment by itself: the mean over time is WelchSpectrum's density.
///
/// Segments, scaling and errors are WelchSpectrum's; a segment longer than a change smears it.
[[nodiscard]] Result<Spectrogram> MakeSpectrogram(std::span<const double> signal,
                                                  const WelchOptions& options);

}  // namespace haptometer::dsp
