#include "fit/experiment_plan.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "base/mapped.h"
#include "fit/drop_test/ring_down_problem.h"
#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Position = Eigen::Index;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kOpen = std::numeric_limits<double>::infinity();
// white noise is as dense at fewer samples a period, if these are less noisy by the root
constexpr double kMostSamplesAPeriod = 24;
constexpr double kMostDecayTimes = 12;  // what rings on behind them is 1e-10 of the energy
constexpr double kLoadDecades = 1;      // searched on either side of R
constexpr double kNearlyBest = 1.1;     // of the least uncertainty
constexpr double kLoadPrecision = 1e-3;

double PeriodS(const PlannedDrops& drops) { return 1 / drops.natural_frequency_hz; }

// Kv = M w0^2
double Stiffness(const PlannedDrops& drops) {
  return drops.moving_mass_kg.value *
         std::pow(2 * std::numbers::pi * drops.natural_frequency_hz, 2);
}

// Bv = sqrt(Kv M)/Q
double Damping(const PlannedDrops& drops) {
  return std::sqrt(Stiffness(drops) * drops.moving_mass_kg.value) / drops.quality_factor;
}

// the recorder's noise and its rounding, step/sqrt(12)
double NoiseV(const PlannedDrops& drops) {
  return std::hypot(drops.noise_v, drops.step_v / std::sqrt(12.0));
}

void CheckActuator(const PlannedDrops& drops) {
  HAPTOMETER_CHECK(drops.moving_mass_kg.value > 0 && drops.resistance_ohm.value > 0 &&
                       drops.load_ohm.value > 0 && std::isfinite(drops.load_ohm.value),
                   "Mv = {}, R = {}, RL = {}", drops.moving_mass_kg.value,
                   drops.resistance_ohm.value, drops.load_ohm.value);
  HAPTOMETER_CHECK(drops.natural_frequency_hz > 0 && drops.quality_factor > 0.5 &&
                       drops.force_constant_n_per_a > 0 && drops.speed_m_per_s > 0,
                   "f0 = {}, Q = {}, Km = {}, v0 = {}", drops.natural_frequency_hz,
                   drops.quality_factor, drops.force_constant_n_per_a, drops.speed_m_per_s);
}

void Check(const PlannedDrops& drops) {
  CheckActuator(drops);
  HAPTOMETER_CHECK(drops.rate_hz * PeriodS(drops) >= 5 && drops.length_s >= 2 * PeriodS(drops) &&
                       NoiseV(drops) > 0 && drops.open_drops > 0 && drops.loaded_drops > 0,
                   "{} Hz, {} s, noise {} V, {} and {} drops", drops.rate_hz, drops.length_s,
                   NoiseV(drops), drops.open_drops, drops.loaded_drops);
}

// the fitted samples of one drop; voltages 0, because only their derivatives are used
RingDownSamples SamplesOf(const PlannedDrops& drops, double load_ohm) {
  const double rate_hz = std::min(drops.rate_hz, kMostSamplesAPeriod * drops.natural_frequency_hz);
  RingDownSamples samples;
  samples.step_s = 1 / rate_hz;
  samples.noise_v = NoiseV(drops) * std::sqrt(rate_hz / drops.rate_hz);
  samples.load_ohm = load_ohm;
  // the fit begins an eighth of a period behind the impact; 1/d = Q/(pi f0)
  const double first_s = PeriodS(drops) / 8;
  const double decay_time_s = drops.quality_factor * PeriodS(drops) / std::numbers::pi;
  const double last_s =
      std::min(drops.length_s, kMostDecayTimes * decay_time_s + 2 * PeriodS(drops));
  const auto count = static_cast<std::size_t>((last_s - first_s) * rate_hz);
  samples.times_s.reserve(count);
  // each sample stands for a step, half of it on either side
  for (std::size_t n = 0; n < count; ++n) {
    samples.times_s.push_back(first_s + (static_cast<double>(n) + 0.5) * samples.step_s);
  }
  samples.voltages_v.assign(count, 0.0);
  return samples;
}

// the planned constants as the solution, with the amplitude Km v0
RingDownPoint PointOf(const PlannedDrops& drops) {
  RingDownPoint point;
  const double km = drops.force_constant_n_per_a;
  point.shared[Index(Shared::kStiffness)] = std::log(Stiffness(drops));
  point.shared[Index(Shared::kDamping)] = std::log(Damping(drops));
  point.shared[Index(Shared::kForceConstantSquared)] = km * km;
  point.shared[Index(Shared::kMass)] = std::log(drops.moving_mass_kg.value);
  point.shared[Index(Shared::kResistance)] = std::log(drops.resistance_ohm.value);
  point.own.resize(1);
  point.own[0][Index(Own::kAmplitude)] = std::log(km * drops.speed_m_per_s);
  return point;
}

// the information of one drop on ln Kv, ln Bv and ln Km, its own amplitude, impact time and offset
// being unknown
Matrix3d InformationOf(const PlannedDrops& drops, double load_ohm) {
  const RingDownProblem problem({SamplesOf(drops, load_ohm)}, drops.inductance_h);
  const RingDownPoint point = PointOf(drops);
  const Jacobian jacobian = problem.Linearise(point);
  const Eigen::Map<const RowMajor> all(jacobian.values.data(), static_cast<Position>(jacobian.rows),
                                       static_cast<Position>(jacobian.columns));
  // the drop's own unknowns, as columns of unit length
  constexpr std::array kOwn{Own::kAmplitude, Own::kImpact, Own::kOffset};
  MatrixXd own(all.rows(), static_cast<Position>(kOwn.size()));
  for (std::size_t k = 0; k < kOwn.size(); ++k) {
    own.col(static_cast<Position>(k)) =
        all.col(static_cast<Position>(Column(0, kOwn[k]))).normalized();
  }
  MatrixXd shared = all.leftCols(static_cast<Position>(kConstantCount));
  // the constants are the first three columns; d(Km^2) = 2 Km^2 d(ln Km)
  shared.col(2) *= 2 * point.shared[Index(Shared::kForceConstantSquared)];
  // what the own unknowns can explain is projected out of the constants' columns
  shared -= own * own.householderQr().solve(shared);
  return shared.transpose() * shared;
}

// of both kinds of drop
struct Informations {
  Matrix3d open;
  Matrix3d loaded;
};

Informations InformationsOf(const PlannedDrops& drops) {
  Check(drops);
  return {InformationOf(drops, kOpen), InformationOf(drops, drops.load_ohm.value)};
}

// relative standard uncertainties of Kv, Bv, Km by noise: information adds over the drops
std::array<double, kConstantCount> Statistical(const Informations& of_one, std::size_t open,
                                               std::size_t loaded) {
  const Matrix3d sum =
      static_cast<double>(open) * of_one.open + static_cast<double>(loaded) * of_one.loaded;
  // unit diagonal before the inversion: Kv is known some hundred times better than the others
  const Eigen::Vector3d scale = sum.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix3d scaled = scale.asDiagonal() * sum * scale.asDiagonal();
  const Eigen::Vector3d variances = scaled.inverse().diagonal();
  std::array<double, kConstantCount> relative{};
  for (std::size_t k = 0; k < kConstantCount; ++k) {
    relative[k] = std::sqrt(variances[static_cast<Position>(k)]) * scale[static_cast<Position>(k)];
  }
  return relative;
}

double Relative(const Quantity& quantity) { return quantity.standard_uncertainty / quantity.value; }

ExpectedUncertainties Expected(const Informations& of_one, const PlannedDrops& drops) {
  // Kv ~ M/T^2, Bv ~ M/T, Km ~ sqrt(M/T): exponents of the mass and of the time scale
  constexpr std::array kMassPowers{1.0, 1.0, 0.5};
  constexpr std::array kTimePowers{2.0, 1.0, 0.5};
  const double total_ohm = drops.resistance_ohm.value + drops.load_ohm.value;
  const auto statistical = Statistical(of_one, drops.open_drops, drops.loaded_drops);
  ExpectedUncertainties expected{};
  for (std::size_t k = 0; k < kConstantCount; ++k) {
    expected[k].statistical = statistical[k];
    expected[k].from_mass = kMassPowers[k] * Relative(drops.moving_mass_kg);
    expected[k].from_time_scale = kTimePowers[k] * drops.time_scale_uncertainty;
  }
  auto& km = expected[static_cast<std::size_t>(Constant::kForceConstant)];
  // Km^2 is in proportion to R + RL
  km.from_resistance = drops.resistance_ohm.standard_uncertainty / (2 * total_ohm);
  km.from_load = drops.load_ohm.standard_uncertainty / (2 * total_ohm);
  return expected;
}

// the drops with another load that is known as well in proportion
PlannedDrops WithLoad(PlannedDrops drops, double load_ohm) {
  drops.load_ohm = {load_ohm, load_ohm * Relative(drops.load_ohm)};
  return drops;
}

// combined, of Km, with one load or another
class LoadedForceConstant {
 public:
  explicit LoadedForceConstant(const PlannedDrops& drops)
      : drops_(drops), open_(InformationOf(drops, kOpen)) {}

  [[nodiscard]] double operator()(double load_ohm) const {
    const PlannedDrops drops = WithLoad(drops_, load_ohm);
    const auto expected = Expected({open_, InformationOf(drops, load_ohm)}, drops);
    return expected[static_cast<std::size_t>(Constant::kForceConstant)].combined();
  }

 private:
  PlannedDrops drops_;
  Matrix3d open_;
};

// the load of least uncertainty between two, by golden section over the logarithm
double BestLoad(const LoadedForceConstant& uncertainty, double least_ohm, double most_ohm) {
  const double golden = std::numbers::phi - 1;
  double lower = std::log(least_ohm);
  double upper = std::log(most_ohm);
  double left = upper - golden * (upper - lower);
  double right = lower + golden * (upper - lower);
  double at_left = uncertainty(std::exp(left));
  double at_right = uncertainty(std::exp(right));
  while (upper - lower > kLoadPrecision) {
    const bool is_left = at_left < at_right;
    (is_left ? upper : lower) = is_left ? right : left;
    (is_left ? right : left) = is_left ? left : right;
    (is_left ? at_right : at_left) = is_left ? at_left : at_right;
    const double next =
        is_left ? upper - golden * (upper - lower) : lower + golden * (upper - lower);
    (is_left ? left : right) = next;
    (is_left ? at_left : at_right) = uncertainty(std::exp(next));
  }
  return std::exp((lower + upper) / 2);
}

// the resistors of the E12 row from `least_ohm` to `most_ohm`
std::vector<double> Resistors(double least_ohm, double most_ohm) {
  constexpr std::array kE12{1.0, 1.2, 1.5, 1.8, 2.2, 2.7, 3.3, 3.9, 4.7, 5.6, 6.8, 8.2};
  std::vector<double> resistors;
  resistors.reserve(kE12.size() * 3);
  const int first = static_cast<int>(std::floor(std::log10(least_ohm)));
  const int last = static_cast<int>(std::floor(std::log10(most_ohm)));
  for (int power = first; power <= last; ++power) {
    for (const double digits : kE12) {
      const double ohm = digits * std::pow(10.0, power);
      if (ohm >= least_ohm && ohm <= most_ohm) resistors.push_back(ohm);
    }
  }
  return resistors;
}

// a given number's part in an uncertainty, and the limit that it makes
struct Part {
  double uncertainty = 0;
  PlanLimit limit = PlanLimit::kNone;
};

Part LargestGiven(const ExpectedUncertainty& expected) {
  const std::array<Part, 4> parts{{{expected.from_mass, PlanLimit::kMass},
                                   {expected.from_resistance, PlanLimit::kResistance},
                                   {expected.from_load, PlanLimit::kLoad},
                                   {expected.from_time_scale, PlanLimit::kTimeScale}}};
  return *std::ranges::max_element(parts, {}, &Part::uncertainty);
}

// to which share `part` must be reduced to meet the requirement with the others; 0: impossible
double TolerableShare(double part, double others_squared, double wish) {
  if (!(part > 0)) return 0;
  return std::sqrt(std::max(0.0, wish * wish - others_squared)) / part;
}

// what limits when `most` drops of each kind are not enough: what could be better by the most
DropCount LimitOf(const PlannedDrops& drops, const ExpectedUncertainty& expected, double wish) {
  const Part given = LargestGiven(expected);
  const double combined = expected.combined() * expected.combined();
  // a given number limits if it exceeds the noise's part
  DropCount count;
  if (given.uncertainty > expected.statistical) {
    count.limit = given.limit;
    count.tolerable_share =
        TolerableShare(given.uncertainty, combined - given.uncertainty * given.uncertainty, wish);
    return count;
  }
  // the converter's part of the noise limits if its steps exceed the recorder's own noise
  const double step_part = drops.step_v / std::sqrt(12.0) / NoiseV(drops) * expected.statistical;
  const double by_bits = TolerableShare(step_part, combined - step_part * step_part, wish);
  const bool is_converter = drops.step_v / std::sqrt(12.0) > drops.noise_v && by_bits > 0;
  count.limit = is_converter ? PlanLimit::kConverter : PlanLimit::kNoise;
  count.tolerable_share =
      is_converter ? by_bits
                   : TolerableShare(expected.statistical,
                                    combined - expected.statistical * expected.statistical, wish);
  return count;
}

}  // namespace

double ExpectedUncertainty::given() const {
  return std::hypot(std::hypot(from_mass, from_resistance), std::hypot(from_load, from_time_scale));
}

double ExpectedUncertainty::combined() const { return std::hypot(statistical, given()); }

ExpectedUncertainties ExpectUncertainties(const PlannedDrops& drops) {
  return Expected(InformationsOf(drops), drops);
}

ExpectedRinging ExpectRinging(const PlannedDrops& drops) {
  CheckActuator(drops);
  const double km = drops.force_constant_n_per_a;
  const auto decay = [&](double load_ohm) {
    const sim::RingDown<double> ringing({.stiffness_n_per_m = Stiffness(drops),
                                         .damping_n_s_per_m = Damping(drops),
                                         .force_constant_squared_n2_per_a2 = km * km,
                                         .mass_kg = drops.moving_mass_kg.value,
                                         .coil_resistance_ohm = drops.resistance_ohm.value,
                                         .inductance_h = drops.inductance_h,
                                         .load_ohm = load_ohm});
    return ringing.decay_per_s();
  };
  // terminal voltage Km v0, under a load divided by coil and load
  const double open_v = km * drops.speed_m_per_s;
  const double load = drops.load_ohm.value;
  return {decay(kOpen), decay(load), open_v, open_v * load / (load + drops.resistance_ohm.value)};
}

LoadChoice ChooseLoad(const PlannedDrops& drops) {
  Check(drops);
  const double span = std::pow(10.0, kLoadDecades);
  const double least_ohm = drops.resistance_ohm.value / span;
  const double most_ohm = drops.resistance_ohm.value * span;
  const LoadedForceConstant uncertainty(drops);
  LoadChoice choice;
  choice.best_ohm = BestLoad(uncertainty, least_ohm, most_ohm);

  // the E12 resistor of least uncertainty, and the range of those nearly as good
  const auto resistors = Resistors(least_ohm, most_ohm);
  const auto uncertainties = Mapped(resistors, uncertainty);
  const auto best = std::ranges::min_element(uncertainties) - uncertainties.begin();
  choice.resistor_ohm = resistors[static_cast<std::size_t>(best)];
  for (std::size_t k = 0; k < resistors.size(); ++k) {
    if (uncertainties[k] > kNearlyBest * uncertainties[static_cast<std::size_t>(best)]) continue;
    if (choice.least_ohm == 0) choice.least_ohm = resistors[k];
    choice.most_ohm = resistors[k];
  }
  return choice;
}

DropCount CountDrops(const PlannedDrops& drops, const AccuracyWish& wish, std::size_t most) {
  HAPTOMETER_CHECK(wish.relative_uncertainty > 0 && most > 0, "wish {}, most {}",
                   wish.relative_uncertainty, most);
  const Informations of_one = InformationsOf(drops);
  const auto which = static_cast<std::size_t>(wish.constant);
  const auto reaches = [&](std::size_t open, std::size_t loaded) {
    PlannedDrops counted = drops;
    counted.open_drops = open;
    counted.loaded_drops = loaded;
    return Expected(of_one, counted)[which].combined() <= wish.relative_uncertainty;
  };
  // not even `most` drops of each kind
  if (!reaches(most, most)) {
    PlannedDrops counted = drops;
    counted.open_drops = counted.loaded_drops = most;
    return LimitOf(drops, Expected(of_one, counted)[which], wish.relative_uncertainty);
  }
  // for each sum the split that is nearest to even comes first
  for (std::size_t sum = 2; sum <= 2 * most; ++sum) {
    for (std::size_t fewer = sum / 2; fewer >= 1 && sum - fewer <= most; --fewer) {
      if (reaches(fewer, sum - fewer)) return {.open = fewer, .loaded = sum - fewer};
      if (reaches(sum - fewer, fewer)) return {.open = sum - fewer, .loaded = fewer};
    }
  }
  return {.open = most, .loaded = most};
}

}  // namespace haptometer::fit
