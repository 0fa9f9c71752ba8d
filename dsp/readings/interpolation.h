#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

/// Missing samples from their neighbourhood.
namespace haptometer::dsp {

/// Samples on either side of a hole that its interpolation is made from.
inline constexpr std::size_t kInterpolationReach = 512;

/// The most coefficients of the model. Of 64 rather than 32 the error of a hole of 20 ms at 10 kHz
/// falls from 2.9 um to 0.4 um (20 um at 225 Hz, noise 0.2 um), and half of the cost of a hole is
/// theirs.
inline constexpr std::size_t kModelOrder = 64;

/// One interpolated sample.
struct Interpolated {
  double value = 0;
  double error_square = 0;  ///< expected square of its error
  /// Sum of the absolute covariances of its error with those of all missing samples, its own square
  /// included: error_square where errors are independent, as of white noise.
  double covariance_sum = 0;
};

/// Samples [begin, end) of `samples`, where they are missing (NaN): an autoregressive model of the
/// neighbourhood is fitted to the runs without a hole, and the missing samples are those that make
/// the sum of its squared innovations least (Janssen, Veldhuis and Vries, IEEE Trans. ASSP 34,
/// 1986). The expected error is that of this least-squares problem, with the innovations' variance
/// or, where that is larger, the squares beside the hole.
///
/// The order is kModelOrder, or the first half of it, quarter ... that has three samples a
/// coefficient. One entry for each missing sample in [begin, end), in order; nothing where two
/// coefficients are too many, or where a number overflows. Missing samples outside of [begin, end)
/// are no obstacle. Cost: samples x order + order^3 / 6 + (missing samples)^3 / 2 flops.
[[nodiscard]] std::optional<std::vector<Interpolated>> Interpolate(std::span<const double> samples,
                                                                   std::size_t begin,
                                                                   std::size_t end);

}  // namespace haptometer::dsp
