#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fit/findings.h"
#include "fit/identifiability.h"
#include "fit/least_squares.h"

namespace haptometer::fit {

/// How dense the noise is at the resonance, against a white one of the same power.
struct ResidualDensity {
  /// Mean power density from 0.5 to 1.5 times the resonance over that of all frequencies: the
  /// factor on the fitted constants' variances. 1 for white noise; 2 or more behind a low-pass or
  /// with the correlated rounding of a record that has less noise than its converter's step.
  double ratio = 1;
  /// Whether the ratio lies above 1 by more than 2.33 of its own deviations (1 % of white records).
  bool is_coloured = false;
};

/// Reads the density off the periodogram of a fit's residuals.
///
/// A least-squares fit of an oscillation is moved only by the noise near its frequency: with a
/// density S there, its covariance is S/(s^2 dt) times the white one (two-sided S). The ratio's own
/// deviation is 1/sqrt(lines in the band); fewer than 8 lines, or a band beyond half the rate, give
/// 1.
///
/// @param residuals on a regular grid, 0 where there is no sample
/// @param step_s of the grid
/// @param resonance_hz the oscillation's frequency
[[nodiscard]] ResidualDensity DensityAt(const std::vector<double>& residuals, double step_s,
                                        double resonance_hz);

/// Residuals at some times of a regular grid on all of it, 0 where there is none. At least one.
[[nodiscard]] std::vector<double> OnGrid(std::span<const double> residuals,
                                         std::span<const double> times_s, double step_s);

/// What a sweep's residuals look like, in the order of frequency.
struct ResidualLook {
  /// Correlation of successive residuals, in deviations of that of white ones.
  double serial_correlation = 0;
  std::size_t farthest = 0;    ///< the point with the largest residual
  double farthest_spread = 0;  ///< that residual over 1.4826 times the median magnitude
};

/// Looks at residuals of several kinds, `points` of each one after the other. The median does not
/// follow a single bad point, as a standard deviation does (of 25 points none can lie more than 5
/// of their own deviations off).
[[nodiscard]] ResidualLook LookAtResiduals(const std::vector<double>& residuals,
                                           std::size_t points);

/// Adds what is doubtful: residuals that follow each other by more than 3.5 deviations (1 in 4000
/// white ones), a point that lies 8 spreads off. Nothing for residuals that are rounding (`noise`
/// below 1e-9).
void DoubtResiduals(const ResidualLook& look, double noise, double farthest_hz, Findings& findings);

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
  Identifiability seen;  ///< at the solution, as if the noises were known
  /// The same, with the covariance that includes what the noises' own uncertainty adds: type A.
  Identifiability type_a;
  /// (groups) row-major parts (columns x columns) of the covariance in `seen`, which they add up
  /// to: what each group's noise contributes.
  std::vector<std::vector<double>> parts;
  /// (groups x groups) covariance of the estimated s_g^2, each over itself.
  std::vector<double> noise_covariance;
};

/// Minimises (least_squares.h) with each group weighted by the noise that its own residuals show:
///
///     s_g^2 = sum_g r^2 / (n_g - sum_g h),   h = diagonal of J (J'J)^+ J',
///
/// repeated until no s_g changes by more than 1e-6 of itself. That is the restricted maximum of
/// likelihood (variance components as in W. Foerstner, "Ein Verfahren zur Schaetzung von Varianz-
/// und Kovarianzkomponenten", Allgemeine Vermessungs-Nachrichten 86 (1979) 446-453; here without
/// covariances). `point` becomes the solution. A group without degrees of freedom takes the first
/// round's common noise.
///
/// Weights of few residuals are uncertain: the estimate scatters more than (J'J)^+ = C states, and
/// C is too small on average, since a group that happens to fit closely weighs more. With
/// A_g = J_g' J_g, and the restricted information I of the s_g^2 (each over itself),
///
///     I_ij = (d_ij (n_i - 2 tr C A_i) + tr C A_i C A_j) / 2,   W = I^-1,   d_ij Kronecker's,
///     L = C (sum_ij W_ij c_i c_j (d_ij A_i - A_i C A_j)) C,    type A: C + 2 L
///
/// (M. G. Kenward and J. H. Roger, "Small sample inference for fixed effects from restricted
/// maximum likelihood", Biometrics 53 (1997) 983-997, with c = 1: the second order in W). For a
/// group of k degrees c^2 = 1 + 6/k, so that intervals with DegreesOf hold 93 to 97 % from the
/// fewest points on, which c = 1 misses by up to 4 % (tests/fit/residuals_test.cc). L is 0 for one
/// group.
///
/// Cost: some 5 solutions.
[[nodiscard]] GroupedSolution SolveGroups(const LeastSquares& problem, const NoiseGroups& groups,
                                          const std::vector<bool>& is_free,
                                          const std::vector<bool>& is_logarithm,
                                          std::vector<double>* point);

/// The degrees of freedom of the type A variance V of sum(weights * parameters), by Satterthwaite:
/// 2 V^2 / (v' W v), v_g being the groups' parts of V; those of all residuals for one group. From 1
/// to the sum of the groups' degrees (or 1, where that is less).
[[nodiscard]] double DegreesOf(const GroupedSolution& solution, const std::vector<double>& weights);

/// Numbers as a table holds them, which may be rounded, each in one residual.
struct TabulatedValues {
  std::vector<double> values;
  std::vector<double> slopes;      ///< of the residuals (not over their noise) by the values
  std::size_t first_residual = 0;  ///< the others follow
};

/// What the rounding of the values may move the parameters by: one response for each set of equal
/// values, in standard deviations; independent of each other.
///
/// Rounding to a step q (dsp::StepOf) errs by q/sqrt(12). Errors of different values are part of
/// the noise that the residuals show. Values that are equal have one error in common, which does
/// not average: of m ones it is
///
///     q/sqrt(12) sqrt(1 - 1/m) exp(-2 pi^2 s^2 / q^2),
///
/// less the part that is noise already, and less what noise s ahead of the rounding takes (Widrow
/// and Kollar, Quantization Noise, 2008, 5.3): nothing remains where s is a step.
[[nodiscard]] std::vector<std::vector<double>> RoundingResponses(const GroupedSolution& solution,
                                                                 const NoiseGroups& groups,
                                                                 const TabulatedValues& tabulated);

/// Covariance of sum(first * parameters) and sum(second * parameters) by independent responses.
[[nodiscard]] double CovarianceBy(const std::vector<std::vector<double>>& responses,
                                  const std::vector<double>& first,
                                  const std::vector<double>& second);

}  // namespace haptometer::fit
