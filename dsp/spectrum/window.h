#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptometer::dsp {

/// Windows for spectra, with what Heinzel, Ruediger and Schilling (Spectrum and spectral density
/// estimation by the DFT, 2002, appendices C and D) state of them: equivalent noise bandwidth in
/// bins, greatest amplitude error of a tone between two bins, highest side lobe, recommended
/// overlap.
enum class WindowShape : std::uint8_t {
  kRectangular,     ///< 1.0000, -3.92 dB, -13.3 dB, 0 %: tones of whole periods only
  kHann,            ///< 1.5000, -1.42 dB, -31.5 dB, 50 %: the usual one
  kHamming,         ///< 1.3628, -1.75 dB, -42.7 dB, 50 %
  kBlackmanHarris,  ///< 2.0044, -0.83 dB, -92.0 dB, 66.1 %: small tones beside large ones
  kFlatTop,         ///< HFT90D: 3.8832, -0.0039 dB, -90.2 dB, 76 %: a tone's amplitude
};

/// The window of `size` >= 1 values in its periodic form: a sum of cosines of 2 pi n / size.
[[nodiscard]] std::vector<double> WindowValues(WindowShape shape, std::size_t size);

/// size sum(w^2) / (sum w)^2: the width in bins of the rectangle that passes as much noise.
[[nodiscard]] double NoiseBandwidthBins(const std::vector<double>& window);

}  // namespace haptometer::dsp
