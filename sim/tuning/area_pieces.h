#pragma once

#include <vector>

#include "sim/receptors.h"
#include "sim/tuning/adapter_bounds.h"
#include "sim/tuning/adapter_objective.h"
#include "sim/tuning/motor_source.h"

namespace haptometer::sim {

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

/// The objective kSkinRms or kSkinPower that a cost (sim/tuning/adapter_box.h) means, and back.
[[nodiscard]] double ValueOfCost(const AreaPiece& piece, const MotorSource& source, double cost);
[[nodiscard]] double CostOfValue(const AreaPiece& piece, const MotorSource& source, double value);

}  // namespace haptometer::sim
