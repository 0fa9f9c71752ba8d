#include "bench/fit_experiments.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bench/fit_tally.h"
#include "fit/experiment_plan.h"
#include "tests/fit/synthetic_drop.h"

namespace haptometer::fit {
namespace {

using tests::SyntheticDrop;

constexpr double kLoadOhm = 33;
constexpr double kWrong = 0.5;

struct Experiment {
  SyntheticDrop drop = BaseDrop();
  double load_ohm = kLoadOhm;
  std::size_t drops = 1;        // of each kind
  double mass_uncertainty = 0;  // relative
  double resistance_uncertainty = 0;
};

Quantity Misstated(double value, double uncertainty, double error) {
  return {value * (1 + uncertainty * error), value * uncertainty};
}

std::optional<Constants> FitOnce(const Experiment& experiment, std::size_t seed) {
  std::vector<ImpulseRecord> records;
  records.reserve(2 * experiment.drops);
  for (std::size_t k = 0; k < 2 * experiment.drops; ++k) {
    SyntheticDrop drop = experiment.drop;
    drop.seed = static_cast<unsigned>(1000 * seed + k + 1);
    drop.impact_s = 1e-7 * static_cast<double>(drop.seed % 997);
    if (k % 2 == 1) drop.load_ohm = experiment.load_ohm;
    records.push_back(tests::MakeRecord(drop));
  }
  std::mt19937_64 engine(seed + 1);
  std::normal_distribution<double> error;
  ActuatorKnowns knowns = tests::ThesisKnowns();
  knowns.moving_mass_kg =
      Misstated(experiment.drop.moving_mass_kg, experiment.mass_uncertainty, error(engine));
  knowns.resistance_ohm =
      Misstated(experiment.drop.resistance_ohm, experiment.resistance_uncertainty, error(engine));
  return FitWhole(records, knowns);
}

Errors PlannedFor(const Experiment& experiment) {
  const SyntheticDrop& drop = experiment.drop;
  const double mass = drop.moving_mass_kg;
  PlannedDrops plan;
  plan.moving_mass_kg = {mass, mass * experiment.mass_uncertainty};
  plan.resistance_ohm = {drop.resistance_ohm,
                         drop.resistance_ohm * experiment.resistance_uncertainty};
  plan.load_ohm = {experiment.load_ohm, 0};
  plan.inductance_h = drop.inductance_h;
  plan.natural_frequency_hz = std::sqrt(drop.stiffness_n_per_m / mass) / (2 * std::numbers::pi);
  plan.quality_factor = std::sqrt(drop.stiffness_n_per_m * mass) / drop.damping_n_s_per_m;
  plan.force_constant_n_per_a = drop.force_constant_n_per_a;
  plan.speed_m_per_s = tests::ImpactSpeed(drop);
  plan.rate_hz = 1 / drop.step_s;
  plan.length_s = drop.length_s;
  plan.noise_v = drop.noise_v;
  plan.step_v = drop.step_v;
  plan.open_drops = plan.loaded_drops = experiment.drops;
  Errors planned{};
  const auto expected = ExpectUncertainties(plan);
  std::ranges::transform(expected, planned.begin(), &ExpectedUncertainty::combined);
  return planned;
}

void Try(const std::string& what, const std::string& setting, const Experiment& experiment,
         std::size_t seeds) {
  FitTally tally({"experiment", what, setting, kWrong});
  for (std::size_t seed = 0; seed < seeds; ++seed) {
    std::optional<Constants> found;
    const double all_ms = MillisecondsOf([&] { found = FitOnce(experiment, seed); });
    tally.Add(found, all_ms, 0);
  }
  tally.Print(BoundsOf(experiment.drop, experiment.load_ohm, experiment.drops),
              PlannedFor(experiment));
}

// `change` lays a setting into an experiment
void Vary(const std::string& what, const std::vector<double>& settings, std::size_t seeds,
          const std::function<void(double, Experiment*)>& change) {
  for (const double setting : settings) {
    Experiment experiment;
    change(setting, &experiment);
    Try(what, fmt::format("{:g}", setting), experiment, seeds);
  }
}

double StepOfBits(double bits) {
  return 2.5 * tests::SpeedVoltage(BaseDrop()) / std::exp2(bits);  // over 1.25 times the first peak
}

// What goes wrong with the fall of one open drop of 10 mm: how well the height is known, and what
// the case rebounds with, stated as `rebound`. Km is as uncertain as half the height.
struct Fall {
  std::string what;
  std::string setting;
  double height_uncertainty_m = 0;
  double most_rebound = 0;  // of what happens, from 0 on
  std::optional<Quantity> rebound = Quantity{0, 0};
  double planned = 0;  // of Km
};

void TryFall(const Fall& fall, std::size_t seeds) {
  FitTally tally({"experiment", fall.what, fall.setting, kWrong});
  for (std::size_t seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 engine(seed + 1);
    std::normal_distribution<double> error;
    SyntheticDrop drop = BaseDrop();
    drop.seed = static_cast<unsigned>(seed + 1);
    drop.rebound = std::uniform_real_distribution<double>(0, 1)(engine) * fall.most_rebound;
    auto record = tests::MakeRecord(drop);
    record.drop_height_m = Quantity{drop.height_m + fall.height_uncertainty_m * error(engine),
                                    fall.height_uncertainty_m};
    record.rebound = fall.rebound;
    std::optional<Constants> found;
    const double all_ms =
        MillisecondsOf([&] { found = FitWhole({record}, tests::ThesisKnowns()); });
    tally.Add(found, all_ms, 0);
  }
  tally.Print({}, {0, 0, fall.planned});
}

void Falls(std::size_t seeds) {
  const double height_m = SyntheticDrop().height_m;
  for (const double uncertainty_m : {1e-5, 1e-4, 5e-4, 1e-3}) {
    TryFall({.what = "height uncertainty of one open drop in m",
             .setting = fmt::format("{:g}", uncertainty_m),
             .height_uncertainty_m = uncertainty_m,
             .planned = uncertainty_m / (2 * height_m)},
            seeds);
  }
  constexpr double kMostRebound = 0.3;
  TryFall({.what = "rebound of 0-0.3 of one open drop",
           .setting = "taken as 0",
           .most_rebound = kMostRebound},
          seeds);
  TryFall({.what = "rebound of 0-0.3 of one open drop",
           .setting = "not stated",
           .most_rebound = kMostRebound,
           .rebound = std::nullopt,
           .planned = kMostRebound / std::sqrt(3.0)},
          seeds);
}

}  // namespace

void MeasureExperiments(std::size_t seeds) {
  Vary("record length in s", {0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.4, 0.8}, seeds,
       [](double length_s, Experiment* e) { e->drop.length_s = length_s; });
  Vary("noise of the first peak", {5e-4, 2e-3, 5e-3, 0.02, 0.05, 0.1, 0.2, 0.5, 1}, seeds,
       [](double noise, Experiment* e) { e->drop.noise_v = noise * tests::SpeedVoltage(e->drop); });
  Vary("bits without noise", {4, 5, 6, 7, 8, 10, 12, 16}, seeds, [](double bits, Experiment* e) {
    e->drop.step_v = StepOfBits(bits);
    e->drop.noise_v = 0;
  });
  Vary("bits with noise of 0.3 steps", {4, 5, 6, 7, 8, 10, 12, 16}, seeds,
       [](double bits, Experiment* e) {
         e->drop.step_v = StepOfBits(bits);
         e->drop.noise_v = 0.3 * e->drop.step_v;
       });
  Vary("sampling rate in Hz", {1200, 2500, 5000, 10e3, 20e3, 50e3}, seeds,
       [](double rate_hz, Experiment* e) { e->drop.step_s = 1 / rate_hz; });
  Vary("drops of each kind", {1, 2, 4, 8, 16}, seeds / 2,
       [](double drops, Experiment* e) { e->drops = static_cast<std::size_t>(drops); });
  Vary("load in ohm", {1, 3.3, 10, 27, 33, 47, 100, 330, 1000, 3300}, seeds,
       [](double load_ohm, Experiment* e) { e->load_ohm = load_ohm; });
  Vary("mass uncertainty", {1e-5, 1e-4, 1e-3, 5e-3, 0.02, 0.05}, seeds,
       [](double uncertainty, Experiment* e) { e->mass_uncertainty = uncertainty; });
  Vary("resistance uncertainty", {1e-4, 1e-3, 5e-3, 0.02, 0.05}, seeds,
       [](double uncertainty, Experiment* e) { e->resistance_uncertainty = uncertainty; });
  Falls(seeds);
}

}  // namespace haptometer::fit
