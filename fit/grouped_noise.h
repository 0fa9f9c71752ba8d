#pragma once

#include <cstddef>
#include <vector>

#include "fit/least_squares.h"
#include "fit/rank.h"

namespace haptometer::fit {

/// Which residuals share one noise, and what is known of it.
struct NoiseGroups {
  std::vector<std::size_t> group_of;  ///< (residuals) 0 to least_noise.size() - 1
  /// (groups) the noise's standard deviation is at least this, in units of the residuals: 1 where
  /// these are in units of stated uncertainties, 0 where nothing is known.
  std::vector<double> least_noise;
};

/// A least-squares solution with the noise that its residuals show.
struct GroupedSolution {
  std::vector<double> noise;    ///< (groups) standard deviation
  std::vector<double> degrees;  ///< (groups) residuals less the parameters that they pay for
  SolverReport solver;
  Jacobian jacobian;     ///< at the solution, in units of the noise
  Identifiability seen;  ///< at the solution
};

/// Minimises (least_squares.h) with each group weighted by the noise that its own residuals show:
///
///     s_g^2 = sum_g r^2 / (n_g - sum_g h),   h = diagonal of J (J'J)^+ J',
///
/// repeated until no s_g changes by more than 1e-6 of itself (variance components as in W.
/// Foerstner, "Ein Verfahren zur Schaetzung von Varianz- und Kovarianzkomponenten", Allgemeine
/// Vermessungs-Nachrichten 86 (1979) 446-453; here without covariances). `point` becomes the
/// solution. A group without degrees of freedom takes the first round's common noise.
///
/// Cost: some 5 solutions.
[[nodiscard]] GroupedSolution SolveGroups(const LeastSquares& problem, const NoiseGroups& groups,
                                          const std::vector<bool>& is_free,
                                          const std::vector<bool>& is_logarithm,
                                          std::vector<double>* point);

}  // namespace haptometer::fit
