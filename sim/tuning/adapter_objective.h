#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/linear/motor_source.h"
#include "sim/skin/skin.h"
#include "sim/tuning/tuning_problem.h"

namespace haptometer::sim {

/// What is made as large as it can be.
enum class Objective : std::uint8_t {
  kSkinRms,     ///< RMS of the skin, m
  kStimulus,    ///< S = Nr x RMS, m (sim/skin/skin.h)
  kSkinPower,   ///< mean power that the skin dissipates, (w^2 Bs |Xs|^2) / 2, W
  kRmsPerWatt,  ///< RMS of the skin over mean electrical power, m/W
};

/// "skin-rms", "stimulus", "skin-power", "rms-per-watt"; its unit.
[[nodiscard]] std::string_view Name(Objective objective);
[[nodiscard]] std::string_view UnitOf(Objective objective);
/// The objective of that name, or nothing.
[[nodiscard]] std::optional<Objective> ObjectiveOf(std::string_view name);

/// The objective at one point; RMS and stimulus are the least over the skins that the problem's
/// skin_variation knows, power and RMS per watt those of the nominal skin. For a point within the
/// bounds, whatever the bounds.
[[nodiscard]] double ValueOf(Objective objective, const TuningProblem& problem,
                             const MotorSource& source, const ReceptorField& receptors,
                             const AdapterPoint& point);

/// What no adapter of any size can exceed with damping Ba at least and skin damping Bs at least the
/// lowest that the bounds allow; of kStimulus with every receptor reached.
///
/// With b = w Bs, e = w Ba, q = Im kc, t = |D1 + ka| / |ka| (sim/linear/motor_source.h) and Ma2
/// where it serves best,
///
///   |Xs| = |Fc| / (b t + q / t + e |D1|^2 / (|ka|^2 t)),
///
/// and |D1| >= | |D1 + ka| - |ka| |, so that the bracket is at least (b + e) t + (q + e) / t - 2 e:
///
///   |Xs| <= |Fc| / (2 sqrt((b + e)(q + e)) - 2 e),        met at t^2 = (q + e) / (b + e).
///
/// With e = 0 this is the available power |Fc|^2 w / (8 q), and any Ma1 has a Ka that gives the t
/// it takes: three reactances match two numbers. That is why the ridge is flat.
/// kSkinPower: the available power. kRmsPerWatt: with lossless matching the case's phasor is
/// Fc (z - j) / (2 q), |z| <= 1, b |Xs|^2 = |Fc|^2 (1 - |z|^2) / (4 q) and P = P1 + Re(g z), so
///
///   RMS / P <= |Fc| / (sqrt(8 q b) sqrt(P1^2 - |g|^2)),   g = beta Fc / (2 q), P1 = P0 + Im g.
///
/// No upper bound where the skin's damping is 0. A stated rounding allowance is added.
[[nodiscard]] double MatchedLoadBound(Objective objective, const TuningProblem& problem,
                                      const MotorSource& source, const ReceptorField& receptors);

/// A stretch of areas on which the weight of the RMS is constant.
struct AreaPiece {
  TuningProblem problem;  ///< with the stretch as its areas
  Objective objective = Objective::kSkinRms;
  double weight = 1;
};

/// A stretch's end may be rounded to the other side of a step, which moves an RMS by less than
/// this.
inline constexpr double kStepAllowance = 1e-9;

/// Whether Nr steps: a stimulus with sharp field edges.
[[nodiscard]] bool HasSteps(Objective objective, const ReceptorField& receptors);

/// The problem's stretches: of a stimulus with steps an RMS each, weighed by the Nr of its lower
/// end, else the problem itself.
[[nodiscard]] std::vector<AreaPiece> PiecesOf(Objective objective, const TuningProblem& problem,
                                              const ReceptorField& receptors);

/// The objective kSkinRms or kSkinPower that a cost (sim/tuning/adapter_cost.h) means, and back.
[[nodiscard]] double ValueOfCost(const AreaPiece& piece, const MotorSource& source, double cost);
[[nodiscard]] double CostOfValue(const AreaPiece& piece, const MotorSource& source, double value);

}  // namespace haptometer::sim
