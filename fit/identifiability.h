#pragma once

#include <cstddef>
#include <vector>

#include "fit/least_squares.h"

namespace haptometer::fit {

/// What a linearised least-squares problem can tell of its parameters, over all of the Jacobian's
/// columns; columns that are not free count as known.
struct Identifiability {
  std::size_t columns = 0;
  std::vector<double> singular_values;  ///< of the column-scaled Jacobian, largest first
  std::size_t nullity = 0;              ///< free directions that the residuals do not see
  /// (columns x columns), row-major: the pseudo-inverse of J'J on the free columns. Times the
  /// residual variance it is the covariance of every determined combination.
  std::vector<double> covariance;
  /// (nullity x columns), row-major: directions that no record sees, orthonormal in their
  /// logarithms; those without any, of unit length.
  std::vector<double> null_directions;
};

/// Reads rank, covariance and null space off the singular values of the column-scaled Jacobian.
///
/// Each free column is divided by its length first, so units play no part. A direction is unseen
/// when its singular value is below 1e-9 of the largest (automatic derivatives are good to 1e-13),
/// or when one standard deviation along it, the residuals being in units of the noise, is more than
/// a factor e of one of the parameters that `is_logarithm` marks.
///
/// Cost: one QR of the Jacobian; memory as much as the Jacobian.
[[nodiscard]] Identifiability FindIdentifiability(const Jacobian& jacobian,
                                                  const std::vector<bool>& is_free,
                                                  const std::vector<bool>& is_logarithm);

/// How far sum(weights * parameters) moves, at most, along the directions that no record sees, when
/// these are passed through by a factor e: 0 for a determined combination, up to the weights'
/// length.
[[nodiscard]] double Blur(const Identifiability& identifiability,
                          const std::vector<double>& weights);

/// Covariance of sum(first * parameters) and sum(second * parameters) per unit of residual
/// variance; holds where Blur is 0 for both.
[[nodiscard]] double Covariance(const Identifiability& identifiability,
                                const std::vector<double>& first,
                                const std::vector<double>& second);

/// The same of one sum with itself.
[[nodiscard]] double Variance(const Identifiability& identifiability,
                              const std::vector<double>& weights);

/// The covariance over the roots of its diagonal (columns x columns), 0 where one of these is 0.
[[nodiscard]] std::vector<double> Correlations(const Identifiability& identifiability);

/// First-order response of the solution to a change of the residuals: -(J'J)^+ J' change, per
/// column.
[[nodiscard]] std::vector<double> Response(const Identifiability& identifiability,
                                           const Jacobian& jacobian,
                                           const std::vector<double>& residual_change);

/// The same of the products J' change.
[[nodiscard]] std::vector<double> Response(const Identifiability& identifiability,
                                           const std::vector<double>& products);

}  // namespace haptometer::fit
