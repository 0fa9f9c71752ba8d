#include "sim/tuning/adapter_objective.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"

namespace haptometer::sim {
namespace {

struct Words {
  Objective objective;
  std::string_view name, unit;
};
constexpr auto kWords = std::to_array<Words>({{Objective::kSkinRms, "skin-rms", "m"},
                                              {Objective::kStimulus, "stimulus", "m"},
                                              {Objective::kSkinPower, "skin-power", "W"},
                                              {Objective::kRmsPerWatt, "rms-per-watt", "m/W"}});

const Words& WordsOf(Objective objective) {
  for (const Words& words : kWords) {
    if (words.objective == objective) return words;
  }
  return kWords.front();
}

// |Xs| of the matched load with the lowest dampings, |Fc| / (2 sqrt((b + e)(q + e)) - 2 e), m
double LargestSkinPeak(const MotorSource& source, double b, double e) {
  const double q = source.stiffness_n_per_m.imag();
  return Abs(source.force_n) / (2 * std::sqrt((b + e) * (q + e)) - 2 * e);
}

// RMS in m of the skin that moves least within the problem's variation
double LeastRms(const TuningProblem& problem, const MotorSource& source,
                const AdapterPoint& point) {
  double least = HUGE_VAL;
  for (const Skin& skin : HardestSkins(problem, point.contact_area_m2)) {
    least = std::min(least, Abs(MotionOf(source, point.adapter, skin).skin_m));
  }
  return least / std::numbers::sqrt2;
}

// largest RMS per watt over all loads, m/W; b = w Bs
double LargestRmsPerWatt(const MotorSource& source, double b) {
  const double q = source.stiffness_n_per_m.imag();
  const std::complex<double> g = source.power_slope_w_per_m * source.force_n / (2 * q);
  const double P1 = source.blocked_power_w + g.imag();
  return Abs(source.force_n) / std::sqrt(8 * q * b * (P1 * P1 - std::norm(g)));
}

}  // namespace

std::string_view Name(Objective objective) { return WordsOf(objective).name; }

std::string_view UnitOf(Objective objective) { return WordsOf(objective).unit; }

std::optional<Objective> ObjectiveOf(std::string_view name) {
  for (const Words& words : kWords) {
    if (words.name == name) return words.objective;
  }
  return std::nullopt;
}

double ValueOf(Objective objective, const TuningProblem& problem, const MotorSource& source,
               const ReceptorField& receptors, const AdapterPoint& point) {
  const Skin skin = SkinOf(problem, point.contact_area_m2);
  const AdapterMotion motion = MotionOf(source, point.adapter, skin);
  const double rms_m = Abs(motion.skin_m) / std::numbers::sqrt2;
  const double w = source.omega_rad_per_s;
  switch (objective) {
    case Objective::kSkinRms:
      return LeastRms(problem, source, point);
    case Objective::kStimulus:
      return LeastRms(problem, source, point) *
             StimulatedReceptors(receptors, ContactRadius(point.contact_area_m2));
    case Objective::kSkinPower:
      // mean power in the skin's damper, Bs w^2 rms^2
      return w * w * skin.damping_n_s_per_m * rms_m * rms_m;
    case Objective::kRmsPerWatt:
      return rms_m / ElectricalPower(source, motion.case_m);
  }
  return rms_m;
}

double MatchedLoadBound(Objective objective, const TuningProblem& problem,
                        const MotorSource& source, const ReceptorField& receptors) {
  const double w = source.omega_rad_per_s;
  // the lowest Bs and Ba give the largest motion
  const Skin softest = SkinOf(problem, problem.bounds.contact_area_m2.lower);
  const double b = w * softest.damping_n_s_per_m * (1 + problem.skin_variation);
  const double e = w * problem.bounds.damping_n_s_per_m.lower;
  const double allowed = 1 + source.rounding_allowance;
  const double rms_m = LargestSkinPeak(source, b, e) / std::numbers::sqrt2;
  switch (objective) {
    case Objective::kSkinRms:
      return allowed * rms_m;
    case Objective::kStimulus:
      return allowed * rms_m *
             StimulatedReceptors(receptors, ContactRadius(problem.bounds.contact_area_m2.upper));
    // available power of the source, w |Fc|^2 / (8 Im kc)
    case Objective::kSkinPower:
      return allowed * w * std::norm(source.force_n) / (8 * source.stiffness_n_per_m.imag());
    case Objective::kRmsPerWatt:
      return allowed * LargestRmsPerWatt(source, b);
  }
  return allowed * rms_m;
}

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
    // the upper end is a piece of its own: it may lie on a step
    AreaPiece piece{.problem = problem};
    // between two steps Nr is constant
    piece.problem.bounds.contact_area_m2 = {ends[k], ends[std::min(k + 1, ends.size() - 1)]};
    piece.weight = StimulatedReceptors(receptors, ContactRadius(ends[k]));
    pieces.push_back(piece);
  }
  return pieces;
}

double ValueOfCost(const AreaPiece& piece, const MotorSource& source, double cost) {
  // |Xs|^2 / 2, as the cost is |Fc / Xs|^2
  const double half_square = std::norm(source.force_n) / 2 / cost;
  return piece.objective == Objective::kSkinPower ? source.omega_rad_per_s * half_square
                                                  : piece.weight * std::sqrt(half_square);
}

double CostOfValue(const AreaPiece& piece, const MotorSource& source, double value) {
  const double half_square = piece.objective == Objective::kSkinPower
                                 ? value / source.omega_rad_per_s
                                 : std::norm(value / piece.weight);
  return std::norm(source.force_n) / 2 / half_square;
}

}  // namespace haptometer::sim
