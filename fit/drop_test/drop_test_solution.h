#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "fit/drop_test/consistency.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/drop_test_model.h"
#include "fit/drop_test/ring_down_problem.h"
#include "fit/identifiability.h"
#include "fit/poles.h"
#include "fit/residuals.h"

namespace haptometer::fit {

/// One way through the data to the constants, with or without the drop heights: the solution, what
/// it could see there, and how it answers to every given number.
struct DropTestRoad {
  DropTestRoad(RingDownProblem of, bool heights) : uses_heights(heights), problem(std::move(of)) {}

  bool uses_heights;
  RingDownProblem problem;
  RingDownPoint point;  ///< the solution
  SolverReport solver;
  Jacobian jacobian;     ///< at the solution, condensed
  Identifiability seen;  ///< at the solution, all unknowns free
  /// The same with the scatter between drops that the intervals hold
  /// (DropScatter::student_deviation).
  Identifiability held;
  double variance = 1;                     ///< of the weighted residuals, per degree of freedom
  Consistency consistency;                 ///< of the drops with each other
  std::vector<ResidualDensity> densities;  ///< of each record's residuals at its resonance
  std::vector<double> scales;              ///< of each record's residuals, in V
  std::vector<double> deviations_v;        ///< the scales, or their RMS where that is less
  /// (inputs x columns): derivative of every parameter by each input, per share of its InputBase;
  /// zeros where the road does not depend on it.
  std::vector<std::vector<double>> input_changes;
  std::vector<std::vector<double>> rounding_changes;  ///< of all records (ring_down_problem.h)
};

/// Solves: looks at each drop alone (consistency.h), and gives each its own Kv and Bv about those
/// of all as these scatter; holds what the records cannot tell apart (mass, resistance, Km, in this
/// order), minimises, leaves out samples that lie before the impact then, weighs every record by
/// the noise that its residuals show (fit/residuals.h), minimises again, linearises. With Huber's
/// loss (fit/residuals.h) weights and minimum follow each other until they stay, 50 times at most.
[[nodiscard]] DropTestRoad Travel(const DropTestModel& model, bool uses_heights);

/// What an input's relative changes refer to: its value; 1 + e for a rebound.
[[nodiscard]] double InputBase(const DropTestInput& input);

/// Whether the road's result depends on the input.
[[nodiscard]] bool DependsOn(const DropTestRoad& road, const DropTestInput& input);

/// A shared quantity and its power in a product.
using PowerOf = std::pair<Shared, double>;

/// Weights over the Jacobian's columns that make the logarithm of a product of powers of the shared
/// quantities (Kv, Bv, Km^2, M, R) move as it does at the solution.
[[nodiscard]] std::vector<double> Weights(const DropTestRoad& road,
                                          std::initializer_list<PowerOf> powers);

/// That product at the solution.
[[nodiscard]] double ProductAt(const DropTestRoad& road, std::initializer_list<PowerOf> powers);

/// Whether the records see the product: it moves by less than 1e-3 while an unseen combination
/// passes through a factor e.
[[nodiscard]] bool IsSeen(const DropTestRoad& road, const std::vector<double>& weights);

/// Standard deviations of a weighted sum of the Jacobian's columns' parameters.
struct Spread {
  double blur = 0;         ///< see Blur
  double statistical = 0;  ///< from the records' noise and the scatter between drops
  double type_b = 0;       ///< from the given numbers and the converters' rounding
  double combined = 0;     ///< all three
  /// Standard uncertainties in half the 95 % interval: with Student's factor where drops scatter.
  double coverage = kCoverage95;
};
[[nodiscard]] Spread SpreadOf(const DropTestRoad& road, const DropTestModel& model,
                              const std::vector<double>& weights);

/// Covariance of two weighted sums, as Spread::combined without blur.
[[nodiscard]] double CovarianceOf(const DropTestRoad& road, const DropTestModel& model,
                                  const std::vector<double>& first,
                                  const std::vector<double>& second);

/// A record's pole with the covariance of CovarianceOf. Determined: converged, it oscillates, and
/// both numbers are seen (see IsSeen).
[[nodiscard]] UncertainPole PoleOf(const DropTestRoad& road, const DropTestModel& model,
                                   std::size_t record);

/// A blur below which a combination counts as seen, and how an unseen one's e-fold would move it.
inline constexpr double kMostBlur = 1e-3;

/// Writes the uncertainties and the interval of `value.value`, of whose logarithm `spread` is.
void TakeRelative(const Spread& spread, FittedValue& value);

/// `factor` times the product, without Km^2, with its uncertainties. An unseen combination's last
/// influence (see IsSeen) is added to the combined uncertainty.
///
/// Where the damping is no part of it, the interval is that of its logarithm; determined:
/// converged, seen, and the statistical standard uncertainty below 25 %. A damping's interval is
/// its own, to which the records answer in proportion, and a quality factor's that of its
/// reciprocal; determined: the interval excludes 0. Else a damping has an upper limit.
[[nodiscard]] FittedValue Evaluate(const DropTestRoad& road, const DropTestModel& model,
                                   std::initializer_list<PowerOf> powers, double factor,
                                   std::string unit);

/// |Km| at the end of a road.
///
/// By the heights its interval is that of its logarithm. By the loads, which show Km^2 in
/// proportion, it is that of Km^2: Km is determined where this excludes 0 (statistically, 97.5 % on
/// that side); else it has an upper limit, where the records see Km at all. Beyond 5 % of
/// uncertainty the interval is the profile likelihood's (ProfileWidth), the share of type B
/// added in squares on either side.
[[nodiscard]] FittedValue EvaluateForceConstant(const DropTestRoad& road,
                                                const DropTestModel& model);

/// How far from its best value Km^2 is carried, upwards (`side` 1) or downwards (-1), by the chi^2,
/// everything else fitted, growing by `coverage`^2 of the residuals' variance: `coverage` standard
/// deviations where Km^2 is Gaussian. In N^2/A^2, to 1 %. Cost: some ten fits.
[[nodiscard]] double ProfileWidth(const DropTestRoad& road, const DropTestModel& model, int side,
                                  double coverage);

}  // namespace haptometer::fit
