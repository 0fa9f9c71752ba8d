#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace haptometer::dsp {

/// cos(w t) and sin(w t) over blocks of evenly spaced t, for the sums of sine fits and of
/// demodulation.
///
/// Each block begins with the library's own sine and cosine and is turned from there by a table, so
/// that an error never grows with the record: below 3e-16 beyond the rounding of w t itself.
class PhasorBlocks {
 public:
  /// The most samples of a block.
  static constexpr std::size_t kBlock = 256;

  /// `rad_per_sample` is w times the samples' spacing.
  explicit PhasorBlocks(double rad_per_sample);

  /// cos(w t), sin(w t) for t = first, first + 1, ... samples; both spans have one size, at most
  /// kBlock.
  void Fill(double first, std::span<double> cosines, std::span<double> sines) const;

 private:
  double rad_per_sample_ = 0;
  std::array<double, kBlock> cosines_{};
  std::array<double, kBlock> sines_{};
};

}  // namespace haptometer::dsp
