#include "dsp/spectrum/phasor_blocks.h"

#include <cmath>

#include "base/error.h"

namespace haptometer::dsp {

PhasorBlocks::PhasorBlocks(double rad_per_sample) : rad_per_sample_(rad_per_sample) {
  for (std::size_t k = 0; k < kBlock; ++k) {
    cosines_[k] = std::cos(rad_per_sample * static_cast<double>(k));
    sines_[k] = std::sin(rad_per_sample * static_cast<double>(k));
  }
}

void PhasorBlocks::Fill(double first, std::span<double> cosines, std::span<double> sines) const {
  HAPTOMETER_CHECK(cosines.size() == sines.size() && sines.size() <= kBlock, "{} and {} values",
                   cosines.size(), sines.size());
  const double c = std::cos(rad_per_sample_ * first);
  const double s = std::sin(rad_per_sample_ * first);
  for (std::size_t k = 0; k < cosines.size(); ++k) {
    cosines[k] = c * cosines_[k] - s * sines_[k];
    sines[k] = s * cosines_[k] + c * sines_[k];
  }
}

}  // namespace haptometer::dsp
