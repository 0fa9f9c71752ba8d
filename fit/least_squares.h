#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace haptometer::fit {

/// A linearised problem: rows of derivatives, and a residual a row.
struct LinearRows {
  std::span<const double> derivatives;  ///< (rows x columns), row-major
  std::size_t columns = 0;
  std::span<const double> residuals;  ///< (rows)
};

/// The same least-squares problem in as many rows as it has columns: a matrix T with
/// T'T = [J r]'[J r], J over the columns `used`, r last.
///
/// Rows are taken in by Householder reflections, a stretch at a time that stays in the cache, over
/// the columns alone that are not 0 there. The last columns come first, so that what each of many
/// records has for itself does not mix with the others' (T is no triangle then). As stable as a QR
/// decomposition of the whole. Cost: 2 rows x (columns touched)^2.
///
/// @returns (used + 1) x (used + 1), row-major
[[nodiscard]] std::vector<double> ReduceRows(const LinearRows& rows,
                                             const std::vector<std::size_t>& used);

/// A nonlinear least-squares problem: minimise sum r(p)^2 over p.
struct LeastSquares {
  std::size_t residuals = 0;
  std::size_t parameters = 0;
  /// Writes r(p), and dr/dp (residuals x parameters, row-major) where `jacobian` is not empty.
  /// False where r is not defined or overflows: the solver takes a shorter step.
  std::function<bool(std::span<const double> point, std::span<double> r,
                     std::span<double> jacobian)>
      evaluate;
};

/// A linearised problem: r and dr/dp at a point.
struct Jacobian {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values;     ///< (rows x columns), row-major
  std::vector<double> residuals;  ///< (rows)
};

/// How the solver ended.
struct SolverReport {
  bool converged = false;
  std::string termination;  ///< in Ceres's words
  int iterations = 0;
};

/// Levenberg-Marquardt with dense QR (Ceres) from `point`, which becomes the best point found, and
/// Gauss-Newton steps from there until rounding stops them.
///
/// Ceres runs to function tolerance 1e-14, parameter and gradient tolerance 1e-15, at most 1000
/// iterations. Its own settings stop at 1e-6 of the cost and solve 24 of NIST's 54 nonlinear
/// problems; these solve 53. A cost that no longer changes leaves half of the digits open, which
/// the last steps give back: 10 digits in the mean where NIST certifies 11
/// (tests/fit/least_squares_test.cc). Its gradient tolerance is absolute, so residuals belong in
/// units of their noise, and positive parameters are best given as logarithms.
///
/// Cost of an iteration: one evaluation with derivatives, and reflections of its rows, a stretch at
/// a time, over the columns that are not 0 there: 2 residuals x (columns touched)^2.
///
/// @param problem residuals with their derivatives
/// @param is_free one flag a parameter; the others stay where they are
/// @param point where the search begins, and the best point found
[[nodiscard]] SolverReport Minimise(const LeastSquares& problem, const std::vector<bool>& is_free,
                                    std::vector<double>* point);

/// r and dr/dp for all parameters, held or not. The problem must be defined at `point`.
[[nodiscard]] Jacobian Linearise(const LeastSquares& problem, const std::vector<double>& point);

}  // namespace haptometer::fit
