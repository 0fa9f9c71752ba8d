#include "fit/impedance/impedance_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "dsp/statistics/distributions.h"
#include "fit/uncertainty.h"

namespace haptometer::fit {

/// Adds to a finished fit the mass it refers to, what its sweep does not determine and what would,
/// and what about it is unlike an actuator, with the mistake that usually stands behind it.
///
/// Doubted are: a resonance outside of 20-2000 Hz (kHz or rad/s read as Hz) or outside of the
/// sweep, Q outside of 0.5-300, a coil outside of 0.1 ohm-10 kohm (kohm read as ohm), Km outside of
/// 1 mN/A-100 N/A, masses outside of 10 mg-100 g (case 1 kg; g read as kg), what
/// DoubtResiduals finds, and a fitted resistance that is neither within 1 % (2.6 K of copper) nor
/// within 3 combined standard uncertainties of the stated one.
///
/// @param fits_resistance whether R was fitted, not taken as stated
void AddImpedanceFindings(const ActuatorKnowns& knowns, CaseCondition condition,
                          bool fits_resistance, ImpedanceFit* fit);

namespace {

using Complex = std::complex<double>;
using P = ImpedanceParameter;
using Weights = std::vector<double>;

constexpr std::size_t kLeastPoints = 6;
// of the residual's mean square; a resonance's four shapes of noise alone stay below
constexpr double kLeastGain = 30;
// standard uncertainty of ln R beyond which a stated R replaces the sweep's own
constexpr double kMostResistanceShare = 0.05;
// see Blur (fit/identifiability.h)
constexpr double kMostBlur = 1e-3;
// points nearest to the resonance that are left out one at a time, and by how many standard
// uncertainties of the rest a constant may move then (Student's with few degrees of freedom)
constexpr std::size_t kLeftOut = 6;
constexpr double kMostMoved = 5;

// a stated number that the fit uses
struct Input {
  std::string name;
  std::string unit;
  Quantity quantity;
  Weights response;       // of the parameters, per share of the input
  double mass_power = 0;  // of M
};

struct Solved {
  std::vector<ImpedancePoint> points;
  std::vector<double> parameters;
  std::vector<bool> is_free;
  GroupedSolution solution;
  std::vector<Input> inputs;
  std::vector<std::vector<double>> rounding;  // responses (fit/residuals.h)
  bool follows_one_point = false;
};

// finite points by frequency; equal frequencies in an order that does not depend on the table's
std::vector<ImpedancePoint> Measured(const std::vector<ImpedancePoint>& points) {
  std::vector<ImpedancePoint> measured;
  measured.reserve(points.size());
  for (const auto& point : points) {
    if (std::isfinite(point.frequency_hz) && std::isfinite(std::abs(point.ohm))) {
      measured.push_back(point);
    }
  }
  std::ranges::sort(measured, {}, [](const ImpedancePoint& point) {
    return std::tuple(point.frequency_hz, point.ohm.real(), point.ohm.imag());
  });
  return measured;
}

Result<void> CheckPoints(const std::vector<ImpedancePoint>& points, const std::string& name) {
  if (points.size() < kLeastPoints) {
    return CannotAnswer(name, fmt::format("holds only {} impedances", points.size()),
                        "at least six are needed; 20 around the resonance are good");
  }
  for (const auto& point : points) {
    if (point.frequency_hz > 0 && std::abs(point.ohm) > 0) continue;
    return CannotAnswer(
        name,
        fmt::format("has a point of {:g} ohm at {:g} Hz", std::abs(point.ohm), point.frequency_hz),
        "frequencies and magnitudes are positive");
  }
  std::size_t different = 1;
  for (std::size_t n = 1; n < points.size(); ++n) {
    different += points[n].frequency_hz > points[n - 1].frequency_hz ? 1 : 0;
  }
  if (different >= 3) return {};
  return CannotAnswer(name, fmt::format("has {} different frequencies", different),
                      "sweep through the resonance in steps of a quarter of its width f0/Q");
}

// mean square per degree of freedom; a point has two residuals
double MeanSquare(const ImpedanceStart& start, std::size_t points) {
  return start.cost / static_cast<double>(2 * points - kImpedanceParameters);
}

// the same points with other phases
template <typename F>
std::vector<ImpedancePoint> WithPhases(std::vector<ImpedancePoint> points, F phase) {
  for (auto& point : points) {
    point.ohm = std::polar(std::abs(point.ohm), phase(std::arg(point.ohm)));
  }
  return points;
}

// whether another reading of the phases fits far better than the given one, which fits poorly
Result<void> CheckPhases(const std::vector<ImpedancePoint>& points,
                         const std::optional<ImpedanceStart>& start, const std::string& name) {
  constexpr double kBadly = 0.02;  // RMS of |Zmodel/Z - 1|
  constexpr double kFarBetter = 0.2;
  if (start && std::sqrt(MeanSquare(*start, points.size())) < kBadly) return {};
  const auto is_better = [&](const std::vector<ImpedancePoint>& other) {
    const auto fit = StartImpedance(other);
    // reference: the fit of the given phases; without one, the coil without a resonance
    const double given = start ? start->cost : fit ? fit->plain_cost : 0;
    const bool stands_out =
        fit && fit->plain_cost - fit->cost > kLeastGain * MeanSquare(*fit, other.size());
    return stands_out && fit->cost < kFarBetter * given;
  };
  if (is_better(WithPhases(points, [](double phase) { return -phase; }))) {
    return CannotAnswer(name, "its phases fit a resonance only with the other sign",
                        "give the phase of voltage against current: positive for a coil");
  }
  const auto to_degrees = [](double phase) { return phase * 180 / std::numbers::pi; };
  if (is_better(WithPhases(points, to_degrees))) {
    return CannotAnswer(name, "its phases fit a resonance only as radians",
                        "give degrees in the column phase_deg");
  }
  return {};
}

// a resonance counts if it reduces the cost of a coil alone by kLeastGain mean squares
Result<void> CheckResonance(const std::vector<ImpedancePoint>& points,
                            const std::optional<ImpedanceStart>& start, const std::string& name) {
  const bool stands_out =
      start && start->plain_cost - start->cost > kLeastGain * MeanSquare(*start, points.size());
  if (stands_out) return {};
  return CannotAnswer(name,
                      fmt::format("shows no resonance between {:g} and {:g} Hz",
                                  points.front().frequency_hz, points.back().frequency_hz),
                      "sweep through it, 50 to 500 Hz for an LRA, with the mover free to swing");
}

// standard deviation of a parameter from the sweep's noise
double Deviation(const Solved& solved, P parameter) {
  return std::sqrt(solved.solution.type_a
                       .covariance[Index(parameter) * kImpedanceParameters + Index(parameter)]);
}

// holds a parameter at what was stated; its response to that input follows from the residuals'
void Hold(P parameter, const Quantity& stated, bool is_logarithm, Solved* solved) {
  solved->is_free[Index(parameter)] = false;
  solved->parameters[Index(parameter)] = is_logarithm ? std::log(stated.value) : stated.value;
}

void Solve(Solved* solved) {
  static const std::vector<bool> kLogarithms{true, true, true, true, false};
  // weighted by the noises of magnitudes and phases, which are estimated together
  solved->solution =
      SolveGroups(ImpedanceProblem(solved->points), ImpedanceGroups(solved->points.size()),
                  solved->is_free, kLogarithms, &solved->parameters);
}

// the same without point n, from a start of its own
std::optional<Solved> Without(std::size_t n, const Solved& solved) {
  Solved rest = solved;
  rest.points.erase(rest.points.begin() + static_cast<std::ptrdiff_t>(n));
  const auto start = StartImpedance(rest.points);
  if (!start) return {};
  rest.parameters = start->parameters;
  for (std::size_t k = 0; k < kImpedanceParameters; ++k) {
    if (!rest.is_free[k]) rest.parameters[k] = solved.parameters[k];
  }
  Solve(&rest);
  return rest;
}

// the weights of one parameter's power in a product
Weights Power(P parameter, double power) {
  Weights weights(kImpedanceParameters, 0.0);
  weights[Index(parameter)] = power;
  return weights;
}

// what one point may decide
constexpr std::array kResonance{P::kAngular, P::kDamping, P::kCoupling};
// relative standard uncertainty of a resonance that is known at all
constexpr double kMostUncertain = 0.25;

// whether the sweep determines its resonance
bool TellsResonance(const Solved& solved) {
  return std::ranges::all_of(kResonance, [&](P parameter) {
    return Deviation(solved, parameter) < kMostUncertain &&
           Blur(solved.solution.seen, Power(parameter, 1)) < kMostBlur;
  });
}

// by how many of the rest's standard uncertainties the resonance moves without a point, at most
double MovedBy(const Solved& solved, const Solved& rest) {
  double most = 0;
  for (const P parameter : kResonance) {
    const double degrees = DegreesOf(rest.solution, Power(parameter, 1));
    const double student = dsp::StudentCritical(degrees) / kCoverage95;
    const double moved =
        std::abs(rest.parameters[Index(parameter)] - solved.parameters[Index(parameter)]);
    most = std::max(most, moved / (student * Deviation(rest, parameter)));
  }
  return most;
}

// Whether the constants follow one point near the resonance, which the others contradict: a point
// that is far off may pull the fit so close to itself that its own residual is small.
std::optional<Finding> FollowsOnePoint(const Solved& solved) {
  if (solved.points.size() <= kLeastPoints || !TellsResonance(solved)) return {};
  // by the distance from the resonance
  const double f0 = std::exp(solved.parameters[Index(P::kAngular)]) / (2 * std::numbers::pi);
  std::vector<std::size_t> places(solved.points.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  std::ranges::sort(places, {}, [&](std::size_t n) {
    return std::abs(std::log(solved.points[n].frequency_hz / f0));
  });
  places.resize(std::min(places.size(), kLeftOut));
  for (const std::size_t n : places) {
    const auto rest = Without(n, solved);
    if (!rest || !TellsResonance(*rest) || !(MovedBy(solved, *rest) > kMostMoved)) continue;
    const auto ratio = [&](P parameter) {
      return std::exp(rest->parameters[Index(parameter)] - solved.parameters[Index(parameter)]);
    };
    return Finding{.severity = Severity::kDoubt,
                   .kind = FindingKind::kFollowsOnePoint,
                   .numbers = {{"frequency_hz", solved.points[n].frequency_hz},
                               {"stiffness_ratio", std::pow(ratio(P::kAngular), 2)},
                               {"damping_ratio", ratio(P::kDamping)},
                               {"force_constant_ratio", std::sqrt(ratio(P::kCoupling))}}};
  }
  return {};
}

// of a held parameter: its own column is the residuals' change per unit of it
void AddHeldInput(P parameter, std::string name, std::string unit, const Quantity& stated,
                  double per_share, Solved* solved) {
  const Jacobian& jacobian = solved->solution.jacobian;
  std::vector<double> change(jacobian.rows);
  for (std::size_t n = 0; n < jacobian.rows; ++n) {
    change[n] = per_share * jacobian.values[n * jacobian.columns + Index(parameter)];
  }
  Input input{std::move(name), std::move(unit), stated,
              Response(solved->solution.seen, jacobian, change)};
  // the held parameter moves with the stated value, the others by their response
  input.response[Index(parameter)] += per_share;
  solved->inputs.push_back(std::move(input));
}

// what the table's rounding may move the parameters by
void AddRounding(Solved* solved) {
  const std::size_t count = solved->points.size();
  // residuals ln(|Zmodel|/|Z|), then arg Zmodel - arg Z
  TabulatedValues magnitudes{{}, {}, 0};
  TabulatedValues phases{{}, std::vector<double>(count, -1.0), count};
  for (const auto& point : solved->points) {
    magnitudes.values.push_back(std::abs(point.ohm));
    magnitudes.slopes.push_back(-1 / std::abs(point.ohm));
    phases.values.push_back(std::arg(point.ohm));
  }
  for (const auto* tabulated : {&magnitudes, &phases}) {
    auto responses = RoundingResponses(solved->solution, ImpedanceGroups(count), *tabulated);
    std::ranges::move(responses, std::back_inserter(solved->rounding));
  }
}

// the mass M and its inputs; nothing where it is not known
std::optional<double> TakeMass(const ActuatorKnowns& knowns, CaseCondition condition,
                               Solved* solved) {
  if (!knowns.moving_mass_kg) return {};
  const Weights none(kImpedanceParameters, 0.0);
  const double mover = knowns.moving_mass_kg->value;
  if (condition == CaseCondition::kHeld) {
    solved->inputs.push_back({"moving mass", "kg", *knowns.moving_mass_kg, none, 1});
    return mover;
  }
  if (!knowns.case_mass_kg) return {};
  const double case_mass = knowns.case_mass_kg->value;
  // M = Mv Mc/(Mv + Mc): d ln M = (Mc d ln Mv + Mv d ln Mc)/(Mv + Mc)
  const double whole = mover + case_mass;
  solved->inputs.push_back({"moving mass", "kg", *knowns.moving_mass_kg, none, case_mass / whole});
  solved->inputs.push_back({"case mass", "kg", *knowns.case_mass_kg, none, mover / whole});
  return mover * case_mass / whole;
}

// factor M^mass_power times the product of powers of the parameters
struct Product {
  Weights weights;
  double mass_power = 0;
  double factor = 1;
  std::string unit;
};

// relative change of the product per relative change of the input
double Share(const Input& input, const Product& product) {
  double share = input.mass_power * product.mass_power;
  for (std::size_t k = 0; k < product.weights.size(); ++k) {
    share += input.response[k] * product.weights[k];
  }
  return share;
}

double RelativeUncertainty(const Input& input) {
  return input.quantity.value == 0 ? 0 : input.quantity.standard_uncertainty / input.quantity.value;
}

FittedValue Evaluate(const Solved& solved, const std::optional<double>& mass_kg,
                     const Product& product) {
  if (product.mass_power != 0 && !mass_kg) return {.at_most = {}, .unit = product.unit};
  // the logarithm of a product of powers is linear in the parameters
  double logarithm = std::log(product.factor);
  if (product.mass_power != 0) logarithm += product.mass_power * std::log(*mass_kg);
  for (std::size_t k = 0; k < product.weights.size(); ++k) {
    logarithm += product.weights[k] * solved.parameters[k];
  }
  // type B: uncorrelated inputs add in squares (GUM 5.1.2)
  double input_variance = 0;
  for (const auto& input : solved.inputs) {
    input_variance += std::pow(Share(input, product) * RelativeUncertainty(input), 2);
  }
  input_variance += CovarianceBy(solved.rounding, product.weights, product.weights);
  const double variance = Variance(solved.solution.type_a, product.weights);
  FittedValue value = FromLogarithm(logarithm, variance, input_variance, product.unit);
  SetIntervals(ScatterCoverage(variance + input_variance, variance,
                               DegreesOf(solved.solution, product.weights)),
               {&value});
  value.determined = value.determined && solved.solution.solver.converged &&
                     !solved.follows_one_point &&
                     Blur(solved.solution.seen, product.weights) < kMostBlur;
  return value;
}

// Kv = M w0^2, Bv = M g, Km = sqrt(M Km^2/M)
std::array<Product, 3> Constants() {
  return {Product{Power(P::kAngular, 2), 1, 1, "N/m"},
          Product{Power(P::kDamping, 1), 1, 1, "N s/m"},
          Product{Power(P::kCoupling, 0.5), 0.5, 1, "N/A"}};
}

void Conclude(const Solved& solved, const std::optional<double>& mass_kg, ImpedanceFit* fit) {
  const auto constants = Constants();
  fit->stiffness = Evaluate(solved, mass_kg, constants[0]);
  fit->damping = Evaluate(solved, mass_kg, constants[1]);
  fit->force_constant = Evaluate(solved, mass_kg, constants[2]);
  // without M: what the sweep determines by itself
  const auto alone = [&](Weights weights, double factor, std::string unit) {
    return Evaluate(solved, mass_kg, {std::move(weights), 0, factor, std::move(unit)});
  };
  fit->stiffness_over_mass = alone(Power(P::kAngular, 2), 1, "1/s^2");
  fit->damping_over_mass = alone(Power(P::kDamping, 1), 1, "1/s");
  fit->coupling_over_mass = alone(Power(P::kCoupling, 1), 1, "N^2/(A^2 kg)");
  fit->natural_frequency = alone(Power(P::kAngular, 1), 0.5 / std::numbers::pi, "Hz");
  // Q = w0/g
  Weights quality = Power(P::kAngular, 1);
  quality[Index(P::kDamping)] = -1;
  fit->quality_factor = alone(quality, 1, "");
  fit->resistance = alone(Power(P::kResistance, 1), 1, "ohm");
  for (const auto& input : solved.inputs) {
    InputInfluence influence{.input = input.name,
                             .value = input.quantity.value,
                             .standard_uncertainty = input.quantity.standard_uncertainty,
                             .relative_standard_uncertainty = RelativeUncertainty(input),
                             .unit = input.unit};
    for (std::size_t k = 0; k < 3; ++k)
      influence.percent_per_percent[k] = Share(input, constants[k]);
    fit->influences.push_back(std::move(influence));
  }
}

// L is fitted itself: below three standard deviations it has an upper limit of 95 %
void ConcludeInductance(const Solved& solved, const ActuatorKnowns& knowns, ImpedanceFit* fit) {
  const double value = solved.parameters[Index(P::kInductance)];
  const bool stated = !solved.is_free[Index(P::kInductance)];
  const double own = stated ? 0 : Deviation(solved, P::kInductance);
  // what is stated of the others moves it, too: R that is held
  double variance = own * own;
  for (const auto& input : stated ? std::vector<Input>{} : solved.inputs) {
    const double share = Share(input, {Power(P::kInductance, 1), 0, 1, "H"});
    variance += std::pow(share * RelativeUncertainty(input), 2);
  }
  const Weights weights = Power(P::kInductance, 1);
  variance += CovarianceBy(solved.rounding, weights, weights);
  const double combined = stated ? knowns.inductance_h->standard_uncertainty : std::sqrt(variance);
  fit->inductance = {.value = value,
                     .standard_uncertainty = own,
                     .combined_standard_uncertainty = combined,
                     .at_most = {},
                     .unit = "H",
                     .determined = stated || value > 3 * combined};
  const double coverage =
      stated ? kCoverage95
             : ScatterCoverage(variance, own * own, DegreesOf(solved.solution, weights));
  SetIntervals(coverage, {&fit->inductance});
  if (fit->inductance.determined) return;
  fit->inductance.at_most = std::max(value, 0.0) + coverage * combined;
  fit->findings.Note(FindingKind::kInductanceBelow, {{"at_most_h", *fit->inductance.at_most}});
}

// of the logarithms of Kv, Bv, Km, R and L, where determined
void ConcludeCovariance(const Solved& solved, ImpedanceFit* fit) {
  const auto constants = Constants();
  // L is no logarithm: d ln L = dL/L
  Weights of_inductance = Power(P::kInductance, 1);
  of_inductance[Index(P::kInductance)] /= fit->inductance.value;
  const std::array<std::pair<const FittedValue*, Product>, 5> rows{
      {{&fit->stiffness, constants[0]},
       {&fit->damping, constants[1]},
       {&fit->force_constant, constants[2]},
       {&fit->resistance, {Power(P::kResistance, 1), 0, 1, "ohm"}},
       {&fit->inductance, {of_inductance, 0, 1, "H"}}}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const auto& [one, of_one] = rows[i];
      const auto& [other, of_other] = rows[j];
      if (!one->determined || !other->determined) continue;
      // type A by the solution's covariance, type B by the inputs that both share
      double sum = Covariance(solved.solution.type_a, of_one.weights, of_other.weights) +
                   CovarianceBy(solved.rounding, of_one.weights, of_other.weights);
      for (const auto& input : solved.inputs) {
        const double relative = RelativeUncertainty(input);
        sum += Share(input, of_one) * Share(input, of_other) * relative * relative;
      }
      fit->relative_covariance[i][j] = sum;
    }
  }
}

void Describe(const Solved& solved, ImpedanceFit* fit) {
  const auto& solution = solved.solution;
  fit->points = solved.points.size();
  fit->lowest_hz = solved.points.front().frequency_hz;
  fit->highest_hz = solved.points.back().frequency_hz;
  fit->magnitude_noise = solution.noise[0];
  fit->phase_noise_rad = solution.noise[1];
  fit->degrees_of_freedom = solution.degrees[0] + solution.degrees[1];
  for (const P parameter : kResonance) {
    fit->coverage_95 =
        std::max(fit->coverage_95, dsp::StudentCritical(DegreesOf(solution, Power(parameter, 1))));
  }
  fit->residuals = LookAtResiduals(solution.jacobian.residuals, fit->points);
  fit->farthest_hz = solved.points[fit->residuals.farthest].frequency_hz;
  fit->singular_values = solution.seen.singular_values;
  fit->parameters = solved.parameters;
  fit->converged = solution.solver.converged;
  fit->iterations = solution.solver.iterations;
  fit->correlation = Correlations(solution.type_a);
  // half width at half of the motion's largest amplitude: sqrt(3)/2 f0/Q
  const double half_width_hz =
      std::numbers::sqrt3 / 2 * fit->natural_frequency.value / fit->quality_factor.value;
  fit->measured = solved.points;
  for (const auto& point : solved.points) {
    fit->model.push_back(ImpedanceAt(solved.parameters, point.frequency_hz));
    const double off_hz = std::abs(point.frequency_hz - fit->natural_frequency.value);
    fit->points_near_resonance += off_hz <= half_width_hz ? 1 : 0;
  }
}

}  // namespace

Result<ImpedanceFit> FitImpedance(const std::vector<ImpedancePoint>& points,
                                  const ActuatorKnowns& knowns, CaseCondition condition,
                                  const std::string& name) {
  Solved solved;
  ImpedanceFit fit;
  solved.points = Measured(points);
  if (const std::size_t copies = TakeOutCopies(&solved.points)) {
    fit.findings.Note(FindingKind::kPointsWrittenTwice,
                      {{"copies", copies}, {"points", copies + solved.points.size()}});
  }
  HAPTOMETER_TRY(CheckPoints(solved.points, name));
  const auto start = StartImpedance(solved.points);
  HAPTOMETER_TRY(CheckPhases(solved.points, start, name));
  HAPTOMETER_TRY(CheckResonance(solved.points, start, name));

  // R is the sweep's own unless the sweep does not determine it
  solved.parameters = start->parameters;
  solved.is_free.assign(kImpedanceParameters, true);
  if (knowns.inductance_h) Hold(P::kInductance, *knowns.inductance_h, false, &solved);
  Solve(&solved);
  const bool lacks_resistance = Deviation(solved, P::kResistance) > kMostResistanceShare ||
                                Blur(solved.solution.seen, Power(P::kResistance, 1)) > kMostBlur;
  if (knowns.resistance_ohm && lacks_resistance) {
    Hold(P::kResistance, *knowns.resistance_ohm, true, &solved);
    Solve(&solved);
    AddHeldInput(P::kResistance, "resistance", "ohm", *knowns.resistance_ohm, 1, &solved);
    fit.findings.Note(FindingKind::kResistanceAsStated);
  }
  if (knowns.inductance_h) {
    AddHeldInput(P::kInductance, "inductance", "H", *knowns.inductance_h,
                 knowns.inductance_h->value, &solved);
  }
  if (const auto found = FollowsOnePoint(solved)) {
    solved.follows_one_point = true;
    fit.findings.Add(*found);
  }
  AddRounding(&solved);
  const auto mass_kg = TakeMass(knowns, condition, &solved);
  Conclude(solved, mass_kg, &fit);
  Describe(solved, &fit);
  ConcludeInductance(solved, knowns, &fit);
  ConcludeCovariance(solved, &fit);
  AddImpedanceFindings(knowns, condition, solved.is_free[Index(P::kResistance)], &fit);
  return fit;
}

namespace {

void ExplainMass(const ActuatorKnowns& knowns, CaseCondition condition, ImpedanceFit* fit) {
  const bool held = condition == CaseCondition::kHeld;
  fit->mass_symbol = held ? "Mv" : "Mv Mc/(Mv+Mc)";
  const bool known = knowns.moving_mass_kg && (held || knowns.case_mass_kg);
  if (known) return;
  fit->findings.Note(held ? FindingKind::kMassMissing : FindingKind::kMassesMissing);
}

void ExplainSweep(ImpedanceFit& fit) {
  const std::pair<const char*, const FittedValue*> kValues[]{{"f0", &fit.natural_frequency},
                                                             {"Bv/M", &fit.damping_over_mass},
                                                             {"Km^2/M", &fit.coupling_over_mass},
                                                             {"R", &fit.resistance}};
  std::string names;
  for (const auto& [name, value] : kValues) {
    if (!value->determined) names += fmt::format("{}{}", names.empty() ? "" : ", ", name);
  }
  if (names.empty() || fit.findings.Has(FindingKind::kFollowsOnePoint)) return;
  fit.findings.Note(FindingKind::kSweepTooCoarse,
                    {{"constants", names},
                     {"near", fit.points_near_resonance},
                     {"points", fit.points},
                     {"step_hz", fit.natural_frequency.value / fit.quality_factor.value / 5}});
}

void AddDoubts(const ActuatorKnowns& knowns, bool fits_resistance, ImpedanceFit* fit) {
  using enum FindingKind;
  Findings& findings = fit->findings;
  const double f0 = fit->natural_frequency.value;
  DoubtUnusual(kUnusualFrequency, "natural_frequency_hz", fit->natural_frequency,
               sim::kPlausibleResonanceHz, findings);
  DoubtUnusual(kUnusualQuality, "quality_factor", fit->quality_factor, {0.5, 300}, findings);
  DoubtUnusual(kUnusualResistance, "resistance_ohm", fit->resistance, sim::kPlausibleResistanceOhm,
               findings);
  DoubtUnusual(kUnusualForceConstant, "force_constant_n_per_a", fit->force_constant,
               sim::kPlausibleForceConstantNPerA, findings);
  DoubtUnusual(kUnusualMovingMass, "moving_mass_kg", knowns.moving_mass_kg,
               sim::kPlausibleMovingMassKg, findings);
  DoubtUnusual(kUnusualCaseMass, "case_mass_kg", knowns.case_mass_kg, sim::kPlausibleCaseMassKg,
               findings);
  DoubtUnusual(kResonanceOutside, "natural_frequency_hz", f0, {fit->lowest_hz, fit->highest_hz},
               findings);
  DoubtResiduals(fit->residuals, fit->magnitude_noise, fit->farthest_hz, findings);
  if (!knowns.resistance_ohm || !fits_resistance) return;
  // a doubt beyond 3 standard uncertainties and 1 % of the stated resistance
  const double stated = knowns.resistance_ohm->value;
  const double apart = std::abs(fit->resistance.value - stated);
  const double uncertainty = std::hypot(fit->resistance.combined_standard_uncertainty,
                                        knowns.resistance_ohm->standard_uncertainty);
  if (apart > 3 * uncertainty && apart > 0.01 * stated) {
    findings.Doubt(kResistanceDiffers,
                   {{"fitted_ohm", fit->resistance.value}, {"stated_ohm", stated}});
  }
}

}  // namespace

void AddImpedanceFindings(const ActuatorKnowns& knowns, CaseCondition condition,
                          bool fits_resistance, ImpedanceFit* fit) {
  ExplainMass(knowns, condition, fit);
  ExplainSweep(*fit);
  AddDoubts(knowns, fits_resistance, fit);
}

}  // namespace haptometer::fit
