#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace haptometer::fit {

/// Huber's loss t^2/2 for |t| <= c and c |t| - c^2/2 beyond, t being residuals in units of their
/// scale: samples far away pull with a fixed force. With c = 1.345 it needs 1/0.95 of the samples
/// that least squares need where the noise is Gaussian (P. J. Huber, "Robust Estimation of a
/// Location Parameter", Ann. Math. Stat. 35, 1964, p. 73).
inline constexpr double kHuberBend = 1.345;

/// The scale of residuals, unmoved by up to half of them: median |r| / 0.6745, the standard
/// deviation of Gaussian ones. At least 1 residual.
[[nodiscard]] double RobustScale(std::span<const double> residuals);

/// sqrt(min(1, c/|t|)) of each: the factors by which least squares of the weighted residuals have
/// Huber's minimum for theirs.
[[nodiscard]] std::vector<double> HuberRootWeights(std::span<const double> residuals, double scale);

/// The factor on the inverse of J'WJ, W being the weights and J and t in units of the scale, that
/// makes it the estimate's covariance: mean(w) sum(psi^2)/(n - p) / mean(psi')^2, psi = w t
/// (Huber, Robust Statistics, 1981, 7.6.2). 1 for Gaussian noise and squares.
[[nodiscard]] double HuberVariance(std::span<const double> scaled_residuals,
                                   std::size_t parameters);

}  // namespace haptometer::fit
