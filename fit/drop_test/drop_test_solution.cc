#include "fit/drop_test/drop_test_solution.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

namespace haptometer::fit {
namespace {

using Kind = DropTestInput::Kind;

constexpr std::ptrdiff_t kLeastLeft = 32;  // samples of a record
constexpr double kMostLogarithmicUncertainty =
    0.25;  // beyond it a value is not determined (uncertainty.md)

double Dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

// all shared parameters and amplitudes are logarithms, except Km^2, which noise may carry through 0
std::vector<bool> LogarithmColumns(std::size_t records) {
  std::vector<bool> logarithm(kSharedCount + kOwnCount * records, false);
  std::fill_n(logarithm.begin(), kSharedCount, true);
  logarithm[Index(Shared::kForceConstantSquared)] = false;
  for (std::size_t r = 0; r < records; ++r) logarithm[Column(r, Own::kAmplitude)] = true;
  return logarithm;
}

// holds as many of mass, resistance and Km^2 as the records do not determine together
std::vector<bool> FindFreedom(const DropTestRoad& road, std::vector<bool> is_free) {
  const std::size_t records = road.problem.records().size();
  const auto logarithm = LogarithmColumns(records);
  std::size_t nullity = FindIdentifiability(road.jacobian, is_free, logarithm).nullity;
  for (const Shared parameter :
       {Shared::kMass, Shared::kResistance, Shared::kForceConstantSquared}) {
    if (nullity == 0 || !is_free[Index(parameter)]) continue;
    auto fewer = is_free;
    // a parameter is held only if that removes an undetermined direction
    fewer[Index(parameter)] = false;
    const std::size_t left = FindIdentifiability(road.jacobian, fewer, logarithm).nullity;
    if (left >= nullity) continue;
    is_free = fewer;
    nullity = left;
  }
  return is_free;
}

// excludes samples before the fitted impact; a record keeps at least kLeastLeft
void LeaveOutSilence(DropTestRoad& road) {
  for (std::size_t r = 0; r < road.point.own.size(); ++r) {
    RingDownSamples& record = road.problem.records()[r];
    const auto behind =
        std::ranges::lower_bound(record.times_s, road.point.own[r][Index(Own::kImpact)]);
    const auto silent = behind - record.times_s.begin();
    if (std::ssize(record.times_s) - silent < kLeastLeft) continue;
    record.times_s.erase(record.times_s.begin(), behind);
    record.voltages_v.erase(record.voltages_v.begin(), record.voltages_v.begin() + silent);
  }
}

// undamped resonance of a record with its own mass, Hz
double ResonanceHz(const RingDownSamples& record, const RingDownPoint& point) {
  const double mass_kg = RingingMass(record, std::exp(point.shared[Index(Shared::kMass)]));
  return std::sqrt(std::exp(point.shared[Index(Shared::kStiffness)]) / mass_kg) /
         (2 * std::numbers::pi);
}

double RootMeanSquare(std::span<const double> residuals) {
  double square = 0;
  for (const double residual : residuals) square += residual * residual;
  return std::sqrt(square / static_cast<double>(residuals.size()));
}

// residuals limited to three times their scale, so that a few outlying ones do not mask the
// spectrum of the others
std::vector<double> DrawnIn(std::span<const double> residuals, double scale) {
  std::vector<double> drawn(residuals.begin(), residuals.end());
  for (double& residual : drawn) residual = std::clamp(residual, -3 * scale, 3 * scale);
  return drawn;
}

// each record's noise becomes its residuals' scale, or that of a white noise that is as dense at
// the resonance; with Huber's loss, each sample its weight
void Reweight(Loss loss, DropTestRoad& road) {
  // residuals without weights, in units of the present noise
  for (auto& record : road.problem.records()) record.root_weights.clear();
  const auto residuals = road.problem.Residuals(road.point);
  std::span<const double> rest(residuals);
  road.densities.clear();
  road.scales.clear();
  road.deviations_v.clear();
  for (auto& record : road.problem.records()) {
    const auto own = rest.first(record.times_s.size());
    rest = rest.subspan(own.size());
    const bool is_robust = loss == Loss::kHuber;
    const double deviation = RootMeanSquare(own);
    const double scale = is_robust ? RobustScale(own) : deviation;
    const auto drawn = is_robust ? DrawnIn(own, scale) : std::vector(own.begin(), own.end());
    // noise density at the record's resonance over that of white noise of the same power
    const auto grid = OnGrid(drawn, record.times_s, record.step_s);
    const auto density = DensityAt(grid, record.step_s, ResonanceHz(record, road.point));
    if (is_robust) record.root_weights = HuberRootWeights(own, scale);
    // a record without noise keeps finite weights: at least 1e-14 of its peak
    double peak = 0;
    for (const double v : record.voltages_v) peak = std::max(peak, std::abs(v));
    road.scales.push_back(record.noise_v * scale);
    // of rounding alone, whose median is not a Gaussian's, or without outlying samples
    road.deviations_v.push_back(record.noise_v * std::min(scale, deviation));
    record.noise_v = std::max(
        road.scales.back() * (density.is_coloured ? std::sqrt(density.ratio) : 1), 1e-14 * peak);
    road.densities.push_back(density);
  }
}

// the solution's derivative by one input per share of its Base: central difference of the
// residuals, with a step small enough for fifty cycles' phase to stay linear
std::vector<double> ChangeByInput(const DropTestRoad& road, const DropTestModel& model,
                                  std::size_t which) {
  constexpr double kShare = 1e-6;
  std::vector<std::vector<double>> residuals;
  std::vector<std::vector<double>> points;
  for (const double share : {kShare, -kShare}) {
    auto inputs = model.inputs;
    inputs[which].quantity.value += share * InputBase(inputs[which]);
    RingDownProblem problem = road.problem;
    RingDownPoint point = road.point;
    ApplyInputs(inputs, model, road.uses_heights, &problem, &point);
    residuals.push_back(problem.Residuals(point));
    points.push_back(ToColumns(point));
  }
  for (std::size_t n = 0; n < residuals[0].size(); ++n) {
    residuals[0][n] = (residuals[0][n] - residuals[1][n]) / (2 * kShare);
  }
  // given parameters move by themselves, the others follow
  auto change = Response(road.seen, road.problem.Products(road.point, residuals[0]));
  for (std::size_t k = 0; k < change.size(); ++k) {
    change[k] += (points[0][k] - points[1][k]) / (2 * kShare);
  }
  return change;
}

// weights whose statistical variance is as much larger as friction and a motion that is not linear
// leave open
std::vector<double> Widened(const DropTestRoad& road, std::vector<double> weights) {
  weights[Index(Shared::kStiffness)] *= road.consistency.frequency_widening;
  weights[Index(Shared::kDamping)] *= road.consistency.decay_widening;
  weights[Index(Shared::kForceConstantSquared)] *= road.consistency.decay_widening;
  return weights;
}

// what the given numbers' uncertainties and the converters' rounding make of two weighted sums
double TypeBCovariance(const DropTestRoad& road, const DropTestModel& model,
                       const std::vector<double>& first, const std::vector<double>& second) {
  double sum = CovarianceBy(road.rounding_changes, first, second);
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const DropTestInput& input = model.inputs[k];
    if (!DependsOn(road, input)) continue;
    const double share = input.quantity.standard_uncertainty / InputBase(input);
    sum += share * share * Dot(first, road.input_changes[k]) * Dot(second, road.input_changes[k]);
  }
  return sum;
}

}  // namespace

double InputBase(const DropTestInput& input) {
  return input.kind == Kind::kRebound ? 1 + input.quantity.value : input.quantity.value;
}

bool DependsOn(const DropTestRoad& road, const DropTestInput& input) {
  if (input.kind == Kind::kVoltageScale) {
    // a scale of volts matters only where amplitudes are converted to Km
    return std::ranges::any_of(input.records, [&road](std::size_t r) {
      const RingDownSamples& record = road.problem.records()[r];
      return record.speed_m_per_s > 0 || record.release_current_a > 0;
    });
  }
  if (input.kind == Kind::kHeight || input.kind == Kind::kRebound || input.kind == Kind::kContact) {
    return road.uses_heights;
  }
  return std::isfinite(input.quantity.value) && input.quantity.value > 0;
}

std::vector<double> Weights(const DropTestRoad& road, std::initializer_list<PowerOf> powers) {
  std::vector<double> weights(road.jacobian.columns, 0.0);
  for (const auto& [parameter, power] : powers) {
    const bool is_logarithm = parameter != Shared::kForceConstantSquared;
    weights[Index(parameter)] = is_logarithm ? power : power / road.point.shared[Index(parameter)];
  }
  return weights;
}

double ProductAt(const DropTestRoad& road, std::initializer_list<PowerOf> powers) {
  double logarithm = 0;
  for (const auto& [parameter, power] : powers) {
    const double value = road.point.shared[Index(parameter)];
    logarithm += power * (parameter == Shared::kForceConstantSquared ? std::log(value) : value);
  }
  return std::exp(logarithm);
}

bool IsSeen(const DropTestRoad& road, const std::vector<double>& weights) {
  return Blur(road.seen, weights) < kMostBlur;
}

namespace {

// each record beside what the start values make of it, for consistency.h
std::vector<ComparedDrop> Compared(const DropTestModel& model, const RingDownProblem& problem,
                                   const RingDownPoint& start) {
  const double mass_kg = std::exp(start.shared[Index(Shared::kMass)]);
  const double stiffness = std::exp(start.shared[Index(Shared::kStiffness)]);
  std::vector<ComparedDrop> drops;
  drops.reserve(model.records.size());
  for (std::size_t r = 0; r < model.records.size(); ++r) {
    const RingDownSamples& record = problem.records()[r];
    const double own_kg = RingingMass(record, mass_kg);
    const RecordPoles at = problem.Poles(start, r);
    const double scale = record.time_scale;  // shown over true seconds, of which the poles are
    drops.push_back(
        {.prepared = &model.records[r],
         .load_ohm = record.load_ohm,
         .mass_ratio = own_kg / mass_kg,
         .added_mass_kg = model.knows_mass ? 0 : record.added_mass_kg,
         .expected = {at.poles.decay_per_s / scale, at.poles.stiffness_per_s2 / (scale * scale)},
         .damping_share = at.decay_slopes[Index(Shared::kDamping)] / at.poles.decay_per_s,
         .coil_share = std::log(at.poles.stiffness_per_s2 * own_kg / stiffness)});
  }
  return drops;
}

// the scatter between drops, of which one of another actuator says nothing
void SetScatter(const Consistency& consistency, double DropScatter::* deviation,
                RingDownProblem& problem) {
  constexpr double kUnrelated = 10;  // of a logarithm
  for (std::size_t r = 0; r < problem.records().size(); ++r) {
    const bool is_unrelated = consistency.drops[r].is_of_another;
    RingDownSamples& record = problem.records()[r];
    record.stiffness_scatter = is_unrelated ? kUnrelated : consistency.frequency.*deviation;
    record.damping_scatter = is_unrelated ? kUnrelated : consistency.decay.*deviation;
  }
}

// begins with each drop's own constants where these are fitted
void BeginWithOwn(const Consistency& consistency, const RingDownProblem& problem,
                  RingDownPoint& point) {
  for (std::size_t r = 0; r < point.own.size(); ++r) {
    const RingDownSamples& record = problem.records()[r];
    const OwnConstants& own = consistency.drops[r];
    if (record.stiffness_scatter > 0) point.own[r][Index(Own::kStiffness)] = own.stiffness;
    if (record.damping_scatter > 0) point.own[r][Index(Own::kDamping)] = own.damping;
  }
}

// rank and covariance with the scatter that the intervals hold
Identifiability FindHeld(const DropTestModel& model, DropTestRoad& road) {
  SetScatter(road.consistency, &DropScatter::student_deviation, road.problem);
  if (road.problem.ScatterRows() == 0) return road.seen;
  const auto held =
      FindIdentifiability(road.problem.Condense(road.point), UnknownColumns(model, road.problem),
                          LogarithmColumns(model.records.size()));
  SetScatter(road.consistency, &DropScatter::deviation, road.problem);
  return held;
}

// Huber's minimum: least squares whose weights follow the residuals until they no longer change
void SettleWeights(const std::vector<bool>& is_free, DropTestRoad& road) {
  constexpr int kMostRounds = 50;
  constexpr double kSettled = 1e-6;
  for (int round = 0; round < kMostRounds; ++round) {
    const auto before = road.problem.records();
    Reweight(Loss::kHuber, road);
    double change = 0;
    for (std::size_t r = 0; r < before.size(); ++r) {
      const auto& now = road.problem.records()[r].root_weights;
      for (std::size_t n = 0; n < now.size(); ++n) {
        change = std::max(change, std::abs(now[n] - before[r].root_weights[n]));
      }
    }
    if (change < kSettled) return;
    const SolverReport again = road.problem.Minimise(is_free, &road.point);
    road.solver.converged = again.converged;
    road.solver.iterations += again.iterations;
  }
  road.solver.converged = false;
}

// the residuals without their weights, in units of their record's scale
std::vector<double> ScaledResiduals(const DropTestRoad& road) {
  auto residuals = road.problem.Residuals(road.point);
  std::size_t row = 0;
  for (std::size_t r = 0; r < road.scales.size(); ++r) {
    const RingDownSamples& record = road.problem.records()[r];
    for (const double root : record.root_weights) {
      residuals[row++] *= record.noise_v / (root * std::max(road.scales[r], 1e-300));
    }
  }
  residuals.resize(row);
  return residuals;
}

}  // namespace

DropTestRoad Travel(const DropTestModel& model, bool uses_heights) {
  DropTestRoad road(MakeProblem(model), uses_heights);
  // each drop alone; Km by the loads, which are what the drops show of it
  const RingDownPoint by_loads = StartPoint(model, false, &road.problem);
  const auto drops = Compared(model, road.problem, by_loads);
  road.consistency = CheckConsistency(drops);
  road.point = StartPoint(model, uses_heights, &road.problem);
  SetScatter(road.consistency, &DropScatter::deviation, road.problem);
  BeginWithOwn(road.consistency, road.problem, road.point);

  // hold what the records do not determine; solve, weight by the residuals, solve again
  const auto unknown = UnknownColumns(model, road.problem);
  road.jacobian = road.problem.Condense(road.point);
  const SolverReport first = road.problem.Minimise(FindFreedom(road, unknown), &road.point);
  LeaveOutSilence(road);
  Reweight(model.loss, road);
  road.jacobian = road.problem.Condense(road.point);
  const auto is_free = FindFreedom(road, unknown);
  road.solver = road.problem.Minimise(is_free, &road.point, &road.jacobian);
  // weights and minimum in turns, then the Jacobian with the final weights
  if (model.loss == Loss::kHuber) {
    SettleWeights(is_free, road);
    road.jacobian = road.problem.Condense(road.point);
  }
  road.solver.iterations += first.iterations;

  // rank with all unknowns free, those held before too
  road.seen = FindIdentifiability(road.jacobian, unknown, LogarithmColumns(model.records.size()));
  road.held = FindHeld(model, road);
  // what a drop has for itself is given by the scatter, a residual for each
  const std::size_t fitted =
      static_cast<std::size_t>(std::count(unknown.begin(), unknown.end(), true)) -
      road.seen.nullity - road.problem.ScatterRows();
  double samples = 0;
  for (const auto& record : road.problem.records()) {
    samples += static_cast<double>(record.times_s.size());
  }
  const double degrees = samples - static_cast<double>(fitted);
  // each record's noise is its residuals' RMS over all samples: n/(n - p) makes it a variance
  road.variance = model.loss == Loss::kHuber ? HuberVariance(ScaledResiduals(road), fitted)
                                             : samples / std::max(degrees, 1.0);
  std::vector<double> noises_v;
  for (const auto& record : road.problem.records()) noises_v.push_back(record.noise_v);
  DoubtStatements(drops, noises_v, road.consistency);
  // type B: the solution's change per share of each given number
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const bool counts = DependsOn(road, model.inputs[k]);
    road.input_changes.push_back(counts ? ChangeByInput(road, model, k)
                                        : std::vector<double>(road.jacobian.columns, 0.0));
  }
  for (std::size_t r = 0; r < model.records.size(); ++r) {
    const PreparedRecord& prepared = model.records[r];
    const double noise_v =
        prepared.averaged_noise_v > 0 ? prepared.averaged_noise_v : road.deviations_v[r];
    std::ranges::move(
        RoundingChanges(road.problem, road.point, road.seen, r, prepared.step_v, noise_v),
        std::back_inserter(road.rounding_changes));
  }
  return road;
}

double CovarianceOf(const DropTestRoad& road, const DropTestModel& model,
                    const std::vector<double>& first, const std::vector<double>& second) {
  return road.variance * Covariance(road.seen, Widened(road, first), Widened(road, second)) +
         TypeBCovariance(road, model, first, second);
}

Spread SpreadOf(const DropTestRoad& road, const DropTestModel& model,
                const std::vector<double>& weights) {
  Spread spread;
  spread.blur = Blur(road.seen, weights);
  spread.statistical = std::sqrt(road.variance * Variance(road.seen, Widened(road, weights)));
  spread.type_b = std::sqrt(TypeBCovariance(road, model, weights, weights));
  spread.combined = std::hypot(spread.statistical, spread.type_b, spread.blur);
  // Student's factor is in the scatter that the interval holds
  const double held = std::sqrt(road.variance * Variance(road.held, Widened(road, weights)));
  if (spread.combined > 0) {
    spread.coverage *= std::hypot(held, spread.type_b, spread.blur) / spread.combined;
  }
  return spread;
}

UncertainPole PoleOf(const DropTestRoad& road, const DropTestModel& model, std::size_t record) {
  // of the actuator, without what this drop has for itself
  RingDownPoint point = road.point;
  point.own[record][Index(Own::kStiffness)] = 0;
  point.own[record][Index(Own::kDamping)] = 0;
  const RecordPoles at = road.problem.Poles(point, record);
  const double decay = at.poles.decay_per_s;
  const double square = at.poles.stiffness_per_s2 - decay * decay;
  UncertainPole pole;
  pole.decay_per_s = decay;
  if (!(square > 0)) return pole;
  pole.frequency_hz = std::sqrt(square) / (2 * std::numbers::pi);
  if (!(decay > 0)) return pole;  // noise has made Km^2 negative

  // of the logarithms, as everywhere: f^2 ~ q - d^2
  std::array<std::vector<double>, 2> weights;
  weights.fill(std::vector<double>(road.jacobian.columns, 0.0));
  // d ln f = (dq/2 - d dd)/(q - d^2)
  for (std::size_t k = 0; k < kSharedCount; ++k) {
    weights[0][k] = (0.5 * at.stiffness_slopes[k] - decay * at.decay_slopes[k]) / square;
    weights[1][k] = at.decay_slopes[k] / decay;
  }
  const std::array scale{pole.frequency_hz, decay};
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      pole.covariance[i][j] =
          scale[i] * scale[j] * CovarianceOf(road, model, weights[i], weights[j]);
    }
  }
  pole.determined = road.solver.converged && IsSeen(road, weights[0]) && IsSeen(road, weights[1]);
  return pole;
}

void TakeRelative(const Spread& spread, FittedValue& value) {
  value.standard_uncertainty = value.value * spread.statistical;
  value.combined_standard_uncertainty = value.value * spread.combined;
  value.lower = value.value * std::exp(-spread.coverage * spread.combined);
  value.upper = value.value * std::exp(spread.coverage * spread.combined);
}

FittedValue Evaluate(const DropTestRoad& road, const DropTestModel& model,
                     std::initializer_list<PowerOf> powers, double factor, std::string unit) {
  const Spread spread = SpreadOf(road, model, Weights(road, powers));
  FittedValue value;
  value.unit = std::move(unit);
  if (!road.solver.converged || spread.blur >= kMostBlur) return value;
  const double product = factor * ProductAt(road, powers);
  const double reach = spread.coverage * spread.combined;
  // power of Bv in the product: the records depend on it in proportion, not by its logarithm
  const auto damping = std::ranges::find(powers, Shared::kDamping, &PowerOf::first);
  const double power = damping == powers.end() ? 0 : damping->second;
  // determined: below 25 %, or with Bv an interval that excludes 0
  value.determined = power == 0 ? spread.statistical < kMostLogarithmicUncertainty : reach < 1;
  if (!value.determined) {
    if (power > 0) value.at_most = product * (1 + reach);
    return value;
  }
  value.value = product;
  TakeRelative(spread, value);
  // linear in Bv; a quality factor has the reciprocal's interval
  if (power == 0) return value;
  value.lower = product * (power > 0 ? 1 - reach : 1 / (1 + reach));
  value.upper = product * (power > 0 ? 1 + reach : 1 / (1 - reach));
  return value;
}

namespace {

constexpr std::size_t kColumn = Index(Shared::kForceConstantSquared);
constexpr double kGaussian = 0.05;  // relative uncertainty of Km up to which its square is

double SquareSum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return sum;
}

std::vector<double> SquareAlone(const DropTestRoad& road) {
  std::vector<double> weights(road.jacobian.columns, 0.0);
  weights[kColumn] = 1;
  return weights;
}

// half the interval of Km^2 on one side, type B included
double HalfWidth(const DropTestRoad& road, const DropTestModel& model, const Spread& spread,
                 int side) {
  const double square = road.point.shared[kColumn];
  // Gaussian up to 5 % of Km, which is 10 % of Km^2
  const bool is_gaussian = spread.statistical < 2 * kGaussian * square;
  const double statistical = is_gaussian ? spread.coverage * spread.statistical
                                         : road.consistency.decay_widening *
                                               ProfileWidth(road, model, side, spread.coverage);
  return std::hypot(statistical, spread.coverage * spread.type_b, spread.coverage * spread.blur);
}

}  // namespace

double ProfileWidth(const DropTestRoad& road, const DropTestModel& model, int side,
                    double coverage) {
  constexpr int kMostFits = 12;
  constexpr double kNear = 0.01;
  std::vector<bool> is_free = UnknownColumns(model, road.problem);
  is_free[kColumn] = false;
  const double deviation = SpreadOf(road, model, SquareAlone(road)).statistical;
  const double least = SquareSum(road.problem.Residuals(road.point));
  // begins with the Gaussian width, then scaled until chi^2 has grown by coverage^2
  double width = coverage * deviation;
  RingDownPoint point = road.point;
  for (int k = 0; k < kMostFits; ++k) {
    // Km^2 held at the trial, all others fitted
    point.shared[kColumn] = road.point.shared[kColumn] + side * width;
    (void)road.problem.Minimise(is_free, &point);
    const double rise = SquareSum(road.problem.Residuals(point)) - least;
    // the root of the rise is nearly in proportion to the width
    const double reached = std::sqrt(std::max(rise, 0.0) / road.variance);
    if (std::abs(reached - coverage) < kNear * coverage) break;
    width *= std::clamp(coverage / std::max(reached, 1e-3), 0.5, 2.0);
  }
  return width;
}

FittedValue EvaluateForceConstant(const DropTestRoad& road, const DropTestModel& model) {
  const double square = road.point.shared[kColumn];
  const Spread spread = SpreadOf(road, model, SquareAlone(road));
  FittedValue value;
  value.unit = "N/A";
  // near Km = 0 the deviation of Km^2 is the scale
  const double scale = std::max(std::abs(square), spread.statistical);
  if (!road.solver.converged || spread.blur >= kMostBlur * scale) return value;
  const double below = HalfWidth(road, model, spread, -1);
  // by the loads, Km is determined where the interval of Km^2 excludes 0
  value.determined = square > 0 && (road.uses_heights || square > below);
  if (!value.determined) {
    const double above = HalfWidth(road, model, spread, 1);
    value.at_most = std::sqrt(std::max(square, 0.0) + above);
    return value;
  }
  value.value = std::sqrt(square);
  // d ln Km = d Km^2 / (2 Km^2)
  TakeRelative({.blur = spread.blur / (2 * square),
                .statistical = spread.statistical / (2 * square),
                .type_b = spread.type_b / (2 * square),
                .combined = spread.combined / (2 * square),
                .coverage = spread.coverage},
               value);
  // by the heights it is the logarithm's interval; by the loads, roots of the limits of Km^2
  if (road.uses_heights) return value;
  value.lower = std::sqrt(square - below);
  value.upper = std::sqrt(square + HalfWidth(road, model, spread, 1));
  return value;
}

}  // namespace haptometer::fit
