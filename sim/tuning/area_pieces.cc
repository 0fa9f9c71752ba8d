#include "sim/tuning/area_pieces.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace haptometer::sim {

namespace {

// the areas at which Nr steps up, with both ends of the bounds around them
std::vector<double> StepAreas(const Range& area_m2, const ReceptorField& receptors) {
  std::vector<double> ends{area_m2.lower};
  const std::vector<double> radii = SteppingRadii(receptors);
  ends.reserve(radii.size() + 2);
  for (const double radius_m : radii) {
    const double step_m2 = ContactArea(radius_m);
    if (step_m2 > area_m2.lower && step_m2 < area_m2.upper) ends.push_back(step_m2);
  }
  ends.push_back(area_m2.upper);
  return ends;
}

}  // namespace

bool HasSteps(Objective objective, const ReceptorField& receptors) {
  return objective == Objective::kStimulus && receptors.edge_width_m == 0;
}

std::vector<AreaPiece> PiecesOf(Objective objective, const TuningProblem& problem,
                                const ReceptorField& receptors) {
  if (!HasSteps(objective, receptors)) return {{.problem = problem, .objective = objective}};
  const std::vector<double> ends = StepAreas(problem.bounds.contact_area_m2, receptors);
  std::vector<AreaPiece> pieces;
  pieces.reserve(ends.size());
  for (std::size_t k = 0; k < ends.size(); ++k) {
    // the upper end is a stretch of its own: it may lie on a step
    AreaPiece piece{.problem = problem};
    piece.problem.bounds.contact_area_m2 = {ends[k], ends[std::min(k + 1, ends.size() - 1)]};
    piece.weight = StimulatedReceptors(receptors, ContactRadius(ends[k]));
    pieces.push_back(piece);
  }
  return pieces;
}

double ValueOfCost(const AreaPiece& piece, const MotorSource& source, double cost) {
  const double half_square = std::norm(source.force_n) / 2 / cost;
  return piece.objective == Objective::kSkinPower ? source.omega_rad_per_s * half_square
                                                  : piece.weight * std::sqrt(half_square);
}

double CostOfValue(const AreaPiece& piece, const MotorSource& source, double value) {
  const double half_square = piece.objective == Objective::kSkinPower
                                 ? value / source.omega_rad_per_s
                                 : std::pow(value / piece.weight, 2);
  return std::norm(source.force_n) / 2 / half_square;
}

}  // namespace haptometer::sim
