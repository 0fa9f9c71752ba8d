#include "bench/fit_tally.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>

#include "base/median.h"
#include "fit/drop_test/drop_test_fit.h"
#include "sim/ring_down.h"
#include "tests/fit/bound.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/sim/ring_ratios.h"

namespace haptometer::fit {
namespace {

using tests::SyntheticDrop;

std::string Text(double value) { return value > 0 ? fmt::format("{:.4g}", value) : ""; }

double EighthOfAPeriod(const SyntheticDrop& drop) {
  return std::numbers::pi / 4 * std::sqrt(tests::EffectiveMass(drop) / drop.stiffness_n_per_m);
}

// one record's voltages in units of its noise, by ln Kv, ln Bv, Km^2 and its own ln amplitude,
// impact and offset
void AddResiduals(const SyntheticDrop& drop, const double* shared, const double* own,
                  std::vector<double>* residuals) {
  const sim::RingDown<double> circuit({.stiffness_n_per_m = std::exp(shared[0]),
                                       .damping_n_s_per_m = std::exp(shared[1]),
                                       .force_constant_squared_n2_per_a2 = shared[2],
                                       .mass_kg = tests::EffectiveMass(drop),
                                       .coil_resistance_ohm = drop.resistance_ohm,
                                       .inductance_h = drop.inductance_h,
                                       .load_ohm = drop.load_ohm});
  const double noise_v = std::hypot(drop.noise_v, drop.step_v / std::sqrt(12.0));
  const double first_s = EighthOfAPeriod(drop);
  const auto count = static_cast<std::size_t>((drop.length_s - first_s) / drop.step_s);
  for (std::size_t n = 0; n < count; ++n) {
    const double since_s = first_s + (static_cast<double>(n) + 0.5) * drop.step_s - own[1];
    residuals->push_back((own[2] - std::exp(own[0]) * VoltageRatio(circuit, since_s)) / noise_v);
  }
}

}  // namespace

double MillisecondsOf(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

void FitTally::Add(const std::optional<Constants>& found, double milliseconds, double solver_ms) {
  ++seeds_;
  const SyntheticDrop truth;
  const double off = found ? found->stiffness_n_per_m / truth.stiffness_n_per_m - 1 : 1;
  if (!(std::abs(off) < row_.least_wrong)) {
    ++failures_;
    return;
  }
  Take(0, off);
  Take(1, found->damping_n_s_per_m / truth.damping_n_s_per_m - 1);
  if (found->force_constant_n_per_a > 0) {
    Take(2, found->force_constant_n_per_a / truth.force_constant_n_per_a - 1);
  }
  times_.push_back(milliseconds);
  solver_times_.push_back(solver_ms);
}

void FitTally::Take(std::size_t k, double error) {
  squares_[k] += error * error;
  ++counts_[k];
}

void FitTally::Print(const Errors& bounds, const Errors& planned) const {
  std::string line = fmt::format("{},{},{},{:.3g},{:.3g},{},{},{}", row_.ladder, row_.what,
                                 row_.setting, UpperMedian(times_), UpperMedian(solver_times_),
                                 seeds_, failures_, seeds_ - counts_[2]);
  for (std::size_t k = 0; k < counts_.size(); ++k) {
    line += "," + Text(counts_[k] > 0 ? std::sqrt(squares_[k] / counts_[k]) : 0);
  }
  for (const double bound : bounds) line += "," + Text(bound);
  for (const double plan : planned) line += "," + Text(plan);
  fmt::print("{}\n", line);
}

tests::SyntheticDrop BaseDrop() {
  SyntheticDrop drop;
  drop.step_s = 2e-4;
  drop.noise_v = 5e-3 * tests::SpeedVoltage(drop);
  return drop;
}

tests::SyntheticDrop Loaded(tests::SyntheticDrop drop, double load_ohm) {
  drop.load_ohm = load_ohm;
  return drop;
}

Errors BoundsOf(const SyntheticDrop& open, double load_ohm, std::size_t drops) {
  const SyntheticDrop loaded = Loaded(open, load_ohm);
  const double amplitude = std::log(tests::SpeedVoltage(open));
  const double km = open.force_constant_n_per_a;
  const std::vector<double> at{std::log(open.stiffness_n_per_m),
                               std::log(open.damping_n_s_per_m),
                               km * km,
                               amplitude,
                               0,
                               0,
                               amplitude,
                               0,
                               0};
  const std::vector<double> steps{1e-6, 1e-3, 1e-3, 1e-3, 1e-7, 1e-3, 1e-3, 1e-7, 1e-3};
  const auto residuals = [&](const std::vector<double>& p) {
    std::vector<double> all;
    AddResiduals(open, p.data(), p.data() + 3, &all);
    AddResiduals(loaded, p.data(), p.data() + 6, &all);
    return all;
  };
  const auto deviations = tests::CramerRaoDeviations(residuals, at, steps);
  const double root = std::sqrt(static_cast<double>(drops));
  return {deviations[0] / root, deviations[1] / root, deviations[2] / (2 * km * km * root)};
}

std::optional<Constants> FitWhole(const std::vector<ImpulseRecord>& records,
                                  const ActuatorKnowns& knowns) {
  const auto fit = FitDropTest(records, knowns);
  if (!fit || !fit->stiffness.determined || !fit->damping.determined) return std::nullopt;
  return Constants{fit->stiffness.value, fit->damping.value,
                   fit->force_constant.determined ? fit->force_constant.value : 0};
}

}  // namespace haptometer::fit
