#include "fit/drop_test_fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "fit/drop_test_model.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

using Kind = DropTestInput::Kind;

// a combination that moves by less than this while an unseen one passes through a factor e counts as
// determined; the motion is added to its uncertainty
constexpr double kMostBlur = 1e-3;
// beyond this relative standard uncertainty a logarithm's interval says nothing
constexpr double kMostRelativeUncertainty = 0.25;
// from here on the interval of Km is noticeably lopsided: the data speak of its square
constexpr double kLopsidedUncertainty = 0.05;

// one road through the data: with or without the drop heights
struct Road {
  Road(RingDownProblem of, bool heights) : uses_heights(heights), problem(std::move(of)) {}

  bool uses_heights;
  RingDownProblem problem;
  RingDownPoint point;
  SolverReport solver;
  Jacobian jacobian;
  Identifiability seen;
  double variance = 1;  // of the weighted residuals
  // derivatives of every parameter by each input, relative to the input's Base
  std::vector<std::vector<double>> input_changes;
};

// weights of a logarithmic combination over the Jacobian's columns
std::vector<double> Weights(const Road& road, std::initializer_list<std::pair<Shared, double>> of) {
  std::vector<double> weights(road.jacobian.columns, 0.0);
  for (const auto& [parameter, weight] : of) weights[Index(parameter)] = weight;
  return weights;
}

double Dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

std::vector<double> Flat(const RingDownPoint& point) {
  std::vector<double> flat(point.shared.begin(), point.shared.end());
  for (const auto& own : point.own) flat.insert(flat.end(), own.begin(), own.end());
  return flat;
}

std::vector<bool> LogarithmColumns(std::size_t records) {
  std::vector<bool> logarithm(kSharedCount + kOwnCount * records, false);
  std::fill_n(logarithm.begin(), kSharedCount, true);
  for (std::size_t r = 0; r < records; ++r) logarithm[Column(r, Own::kSpeed)] = true;
  return logarithm;
}

// holds as many of the unknowns as the records cannot tell apart: mass, resistance, Km
RingDownFreedom FindFreedom(const Road& road, std::vector<bool> is_free) {
  const std::size_t records = road.problem.records().size();
  const auto logarithm = LogarithmColumns(records);
  std::size_t nullity = FindIdentifiability(road.jacobian, is_free, logarithm).nullity;
  for (const Shared parameter : {Shared::kMass, Shared::kResistance, Shared::kForceConstant}) {
    if (nullity == 0 || !is_free[Index(parameter)]) continue;
    auto fewer = is_free;
    fewer[Index(parameter)] = false;
    const std::size_t left = FindIdentifiability(road.jacobian, fewer, logarithm).nullity;
    if (left >= nullity) continue;
    is_free = fewer;
    nullity = left;
  }
  RingDownFreedom freedom;
  std::copy_n(is_free.begin(), kSharedCount, freedom.shared.begin());
  for (std::size_t r = 0; r < records; ++r) {
    freedom.speed.push_back(is_free[Column(r, Own::kSpeed)]);
  }
  return freedom;
}

// each record's noise becomes the root mean square of its residuals
void Reweight(RingDownProblem& problem, const RingDownPoint& point) {
  const auto residuals = problem.Residuals(point);
  std::size_t row = 0;
  for (std::size_t r = 0; r < problem.records().size(); ++r) {
    auto& record = problem.records()[r];
    double square = 0;
    for (std::size_t n = 0; n < record.times_s.size(); ++n, ++row) {
      square += residuals[row] * residuals[row];
    }
    const double rms = record.noise_v * std::sqrt(square / static_cast<double>(record.times_s.size()));
    double peak = 0;
    for (const double v : record.voltages_v) peak = std::max(peak, std::abs(v));
    record.noise_v = std::max(rms, 1e-14 * peak);
  }
}

// what an input is counted in: its value, 1 + e for a rebound
double Base(const DropTestInput& input) {
  return input.kind == Kind::kRebound ? 1 + input.quantity.value : input.quantity.value;
}

// whether the road depends on the input
bool Counts(const DropTestInput& input, bool uses_heights) {
  if (input.kind == Kind::kHeight || input.kind == Kind::kRebound) return uses_heights;
  return std::isfinite(input.quantity.value) && input.quantity.value > 0;
}

// the solution's derivative by one input per share of its Base: central difference of the residuals,
// with a step small enough for fifty cycles' phase to stay linear
std::vector<double> ChangeByInput(const Road& road, const DropTestModel& model, std::size_t which) {
  constexpr double kShare = 1e-6;
  std::vector<std::vector<double>> residuals;
  std::vector<std::vector<double>> points;
  for (const double share : {kShare, -kShare}) {
    auto inputs = model.inputs;
    inputs[which].quantity.value += share * Base(inputs[which]);
    RingDownProblem problem = road.problem;
    RingDownPoint point = road.point;
    ApplyInputs(inputs, model, road.uses_heights, &problem, &point);
    residuals.push_back(problem.Residuals(point));
    points.push_back(Flat(point));
  }
  for (std::size_t n = 0; n < residuals[0].size(); ++n) {
    residuals[0][n] = (residuals[0][n] - residuals[1][n]) / (2 * kShare);
  }
  // given parameters move by themselves, the others follow
  auto change = Response(road.seen, road.jacobian, residuals[0]);
  for (std::size_t k = 0; k < change.size(); ++k) {
    change[k] += (points[0][k] - points[1][k]) / (2 * kShare);
  }
  return change;
}

Road Travel(const std::vector<ImpulseRecord>& records, const DropTestModel& model,
            bool uses_heights) {
  Road road(MakeProblem(records, model), uses_heights);
  road.point = StartPoint(model, uses_heights, &road.problem);

  // what can be told from where we stand; then solve, weigh by the residuals, solve again
  const auto unknown = UnknownColumns(model, uses_heights, road.problem);
  road.jacobian = road.problem.Linearise(road.point);
  const auto freedom = FindFreedom(road, unknown);
  const SolverReport first = road.problem.Minimise(freedom, &road.point);
  Reweight(road.problem, road.point);
  road.solver = road.problem.Minimise(freedom, &road.point);
  road.solver.iterations += first.iterations;

  road.jacobian = road.problem.Linearise(road.point);
  road.seen = FindIdentifiability(road.jacobian, unknown, LogarithmColumns(records.size()));
  const auto unknowns = static_cast<double>(std::count(unknown.begin(), unknown.end(), true));
  const double degrees = static_cast<double>(road.jacobian.rows + road.seen.nullity) - unknowns;
  road.variance = Dot(road.jacobian.residuals, road.jacobian.residuals) / std::max(degrees, 1.0);
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const bool counts = Counts(model.inputs[k], uses_heights);
    road.input_changes.push_back(counts ? ChangeByInput(road, model, k)
                                        : std::vector<double>(road.jacobian.columns, 0.0));
  }
  return road;
}

// a product of powers of the shared parameters with its uncertainties
FittedValue Evaluate(const Road& road, const DropTestModel& model,
                     std::initializer_list<std::pair<Shared, double>> of, double factor,
                     std::string unit) {
  const auto weights = Weights(road, of);
  FittedValue value;
  value.unit = std::move(unit);
  const double blur = Blur(road.seen, weights);
  const double statistical = std::sqrt(road.variance * Variance(road.seen, weights));
  value.determined = road.solver.converged && blur < kMostBlur &&
                     statistical < kMostRelativeUncertainty;
  if (!value.determined) return value;

  double square = statistical * statistical + blur * blur;
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const auto& input = model.inputs[k];
    if (!Counts(input, road.uses_heights)) continue;
    const double change =
        Dot(weights, road.input_changes[k]) * input.quantity.standard_uncertainty / Base(input);
    square += change * change;
  }
  value.value = factor * std::exp(Dot(weights, Flat(road.point)));
  value.standard_uncertainty = value.value * statistical;
  value.combined_standard_uncertainty = value.value * std::sqrt(square);
  return value;
}

FittedValue ForceConstant(const Road& road, const DropTestModel& model) {
  return Evaluate(road, model, {{Shared::kForceConstant, 1}}, 1, "N/A");
}

// the better of the two roads to Km
Road Choose(std::optional<Road> by_heights, Road by_loads, const DropTestModel& model,
            std::vector<std::string>& assumptions) {
  if (!by_heights) return by_loads;
  const auto heights = ForceConstant(*by_heights, model);
  const auto loads = ForceConstant(by_loads, model);
  const bool prefer_loads =
      loads.determined &&
      (!heights.determined ||
       loads.combined_standard_uncertainty < heights.combined_standard_uncertainty);
  if (prefer_loads) {
    assumptions.push_back(fmt::format(
        "Km rests on the loads' damping; with the drop height it would be {:.4g} +- {:.2g} N/A",
        heights.value, heights.combined_standard_uncertainty));
    return by_loads;
  }
  if (loads.determined) {
    assumptions.push_back(fmt::format(
        "Km rests on the drop height and the loads; by the loads alone it is {:.4g} +- {:.2g} N/A",
        loads.value, loads.combined_standard_uncertainty));
  }
  return std::move(*by_heights);
}

void DescribeHeights(const DropTestModel& model, std::vector<std::string>& assumptions) {
  for (const auto& input : model.inputs) {
    if (input.kind != Kind::kRebound) continue;
    assumptions.push_back(
        input.quantity.exact()
            ? fmt::format("impact speed (1 + e) sqrt(2 g h) with rebound e = {:g} and g = {} m/s2",
                          input.quantity.value, kGravityMPerS2)
            : fmt::format("impact speed (1 + e) sqrt(2 g h) with g = {} m/s2 and rebound e = {:g}"
                          " +- {:.2g}{}",
                          kGravityMPerS2, input.quantity.value, input.quantity.standard_uncertainty,
                          input.name == "rebound" ? "" : " (not stated: 0 to 0.3)"));
  }
  assumptions.emplace_back("the recorder's voltage scale is exact: 1 % of it moves Km by 1 %");
}

// what is not determined, what is instead, and what would help
void DescribeUndetermined(const Road& road, const DropTestModel& model, DropTestFit& fit) {
  if (!fit.stiffness.determined && fit.stiffness_over_mass.determined && !model.knows_mass) {
    fit.undetermined.push_back(fmt::format(
        "Kv and Bv are determined per kilogram only: state the {}",
        model.all_free ? "moving mass and the case mass" : "moving mass"));
  }
  const bool some_loaded = std::any_of(fit.records.begin(), fit.records.end(),
                                       [](const auto& r) { return std::isfinite(r.load_ohm); });
  if (some_loaded && !fit.damping_over_mass.determined) {
    std::string missing = model.knows_resistance ? "" : " or state the coil's resistance";
    if (!model.knows_heights) missing = " or state the drop height and the coil's resistance";
    fit.undetermined.push_back(fmt::format(
        "Bv and Km: only (Bv + Km^2/(R+RL))/M = {:.6g} 1/s is determined ({}); record an open circuit"
        " too{}",
        2 * fit.records[0].decay_per_s, fit.records[0].name, missing));
  }
  if (fit.force_constant.determined) return;
  auto product = Weights(road, {{Shared::kForceConstant, 1}});
  product[Column(0, Own::kSpeed)] = 1;
  if (!some_loaded && Blur(road.seen, product) < kMostBlur) {
    fit.undetermined.push_back(fmt::format(
        "Km: an open circuit shows only Km x impact speed = {:.6g} V ({}); state the drop height, or"
        " record again with 27 to 50 ohm across the terminals",
        std::exp(Dot(product, Flat(road.point))), fit.records[0].name));
  } else if (fit.damping_over_mass.determined) {
    fit.undetermined.emplace_back(
        "Km: what these loads change in the damping is lost in its uncertainty, or lacks the mass or"
        " the coil's resistance; state those, or record with 27 to 50 ohm across the terminals");
  }
}

FittedRecord DescribeRecord(const ImpulseRecord& record, const RingStart& start, const Road& road,
                            std::size_t r) {
  const auto& samples = road.problem.records()[r];
  const auto& own = road.point.own[r];
  const auto& shared = road.point.shared;
  const sim::RingDown<double> circuit(
      {.stiffness_n_per_m = std::exp(shared[Index(Shared::kStiffness)]),
       .damping_n_s_per_m = std::exp(shared[Index(Shared::kDamping)]),
       .force_constant_n_per_a = std::exp(shared[Index(Shared::kForceConstant)]),
       .mass_kg = samples.mass_ratio * std::exp(shared[Index(Shared::kMass)]),
       .coil_resistance_ohm = std::exp(shared[Index(Shared::kResistance)]),
       .inductance_h = road.problem.inductance_h(),
       .load_ohm = samples.load_ohm});

  FittedRecord fitted;
  fitted.name = record.name;
  fitted.load_ohm = samples.load_ohm;
  fitted.impact_s = own[Index(Own::kImpact)];
  fitted.offset_v = own[Index(Own::kOffset)];
  fitted.decay_per_s = circuit.decay_per_s();
  const double square = circuit.stiffness_per_s2() - fitted.decay_per_s * fitted.decay_per_s;
  fitted.damped_frequency_hz = square > 0 ? std::sqrt(square) / (2 * std::numbers::pi) : 0;
  fitted.quiet_noise_v = start.quiet_noise_v;
  fitted.first_sample = start.first_sample;
  fitted.samples = samples.times_s.size();

  std::vector<double> speed(road.jacobian.columns, 0.0);
  speed[Column(r, Own::kSpeed)] = 1;
  fitted.speed_determined = Blur(road.seen, speed) < kMostBlur;
  fitted.impact_speed_m_per_s = std::exp(own[Index(Own::kSpeed)]);

  // the model at every sample, measured or not; the residual at the measured ones
  std::vector<double> times;
  for (std::size_t n = start.first_sample; n < record.voltage_v.size(); ++n) {
    times.push_back(record.start_s + static_cast<double>(n) * record.step_s);
  }
  fitted.model_v = road.problem.Voltages(road.point, r, times);
  double square_sum = 0;
  for (std::size_t n = 0; n < times.size(); ++n) {
    const double sample = record.voltage_v[start.first_sample + n];
    if (!std::isfinite(sample)) continue;
    square_sum += (sample - fitted.model_v[n]) * (sample - fitted.model_v[n]);
    fitted.peak_v = std::max(fitted.peak_v, std::abs(sample - fitted.offset_v));
  }
  fitted.residual_rms_v = std::sqrt(square_sum / static_cast<double>(fitted.samples));
  return fitted;
}

void DescribeInfluences(const Road& road, const DropTestModel& model, DropTestFit& fit) {
  constexpr std::array kOf{Shared::kStiffness, Shared::kDamping, Shared::kForceConstant};
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const auto& input = model.inputs[k];
    if (!Counts(input, road.uses_heights)) continue;
    InputInfluence influence{.input = input.name,
                             .value = input.quantity.value,
                             .standard_uncertainty = input.quantity.standard_uncertainty,
                             .unit = input.unit};
    for (std::size_t p = 0; p < kOf.size(); ++p) {
      influence.percent_per_percent[p] = road.input_changes[k][Index(kOf[p])];
    }
    fit.influences.push_back(influence);
  }
}

// pooled over the records with a quiet stretch: residual power over noise power
double ChiSquare(const std::vector<FittedRecord>& records) {
  double sum = 0;
  double samples = 0;
  for (const auto& record : records) {
    if (record.quiet_noise_v <= 0) continue;
    const double ratio = record.residual_rms_v / record.quiet_noise_v;
    sum += ratio * ratio * static_cast<double>(record.samples);
    samples += static_cast<double>(record.samples);
  }
  return samples > 0 ? sum / samples : 0;
}

}  // namespace

Result<DropTestFit> FitDropTest(const std::vector<ImpulseRecord>& records,
                                const ActuatorKnowns& knowns) {
  auto model = MakeDropTestModel(records, knowns);
  if (!model) return std::unexpected(model.error());
  DropTestFit fit;
  fit.assumptions = model->assumptions;
  std::optional<Road> by_heights;
  if (model->knows_heights) by_heights = Travel(records, *model, true);
  const Road road =
      Choose(std::move(by_heights), Travel(records, *model, false), *model, fit.assumptions);
  if (road.uses_heights) DescribeHeights(*model, fit.assumptions);

  fit.mass_symbol = model->all_free ? "Mv Mc/(Mv+Mc)" : "Mv";
  fit.stiffness = Evaluate(road, *model, {{Shared::kStiffness, 1}}, 1, "N/m");
  fit.damping = Evaluate(road, *model, {{Shared::kDamping, 1}}, 1, "N s/m");
  fit.force_constant = ForceConstant(road, *model);
  fit.stiffness_over_mass =
      Evaluate(road, *model, {{Shared::kStiffness, 1}, {Shared::kMass, -1}}, 1, "1/s^2");
  fit.damping_over_mass =
      Evaluate(road, *model, {{Shared::kDamping, 1}, {Shared::kMass, -1}}, 1, "1/s");
  fit.natural_frequency = Evaluate(road, *model, {{Shared::kStiffness, 0.5}, {Shared::kMass, -0.5}},
                                   0.5 / std::numbers::pi, "Hz");
  fit.quality_factor = Evaluate(
      road, *model, {{Shared::kStiffness, 0.5}, {Shared::kMass, 0.5}, {Shared::kDamping, -1}}, 1, "");
  for (std::size_t r = 0; r < records.size(); ++r) {
    fit.records.push_back(DescribeRecord(records[r], model->starts[r], road, r));
  }
  DescribeInfluences(road, *model, fit);
  DescribeUndetermined(road, *model, fit);
  if (fit.force_constant.determined &&
      fit.force_constant.standard_uncertainty > kLopsidedUncertainty * fit.force_constant.value) {
    fit.assumptions.emplace_back(
        "Km is uncertain by more than 5 %: its interval is lopsided, because the data speak of Km^2");
  }
  fit.converged = road.solver.converged;
  fit.termination = road.solver.termination;
  fit.iterations = road.solver.iterations;
  fit.chi_square_per_degree = ChiSquare(fit.records);
  return fit;
}

}  // namespace haptometer::fit
