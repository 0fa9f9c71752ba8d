// What accuracy costs in a fit: prints docs/fit_cost.csv (fixtures/generate/fit_cost.py runs and
// draws it). Seeded drops of the thesis's actuator: first by ways to fit one pair of records (open
// and 33 ohm), then by what the experiment was, each fitted by FitDropTest. Errors are relative, in
// RMS over the seeds, beside the Cramer-Rao bound and beside what experiment_plan.h predicts.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/fit_rungs.h"
#include "fit/drop_test_fit.h"
#include "fit/experiment_plan.h"
#include "fit/ring_fit.h"
#include "fit/ring_start.h"
#include "tests/fit/bound.h"
#include "tests/fit/synthetic_drop.h"

namespace haptometer::fit {
namespace {

using tests::SyntheticDrop;

constexpr double kLoadOhm = 33;
constexpr double kWrongMinimum = 0.05;  // of Kv: another oscillation than the drop's

using Errors = std::array<double, 3>;  // of Kv, Bv, Km, relative

// the parts of a row; what is not known is left empty
struct Row {
  std::string ladder;
  std::string what;
  std::string setting;
};

double MillisecondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  return taken.count();
}

double MedianOf(std::vector<double> values) {
  if (values.empty()) return 0;
  std::ranges::nth_element(values, values.begin() + std::ssize(values) / 2);
  return values[values.size() / 2];
}

// what all seeds of one row say
class Tally {
 public:
  // `solver_ms` is a part of `milliseconds`
  void Add(const std::optional<Constants>& found, double milliseconds, double solver_ms) {
    ++seeds_;
    const SyntheticDrop truth;
    const double off = found ? found->stiffness_n_per_m / truth.stiffness_n_per_m - 1 : 1;
    if (!(std::abs(off) < kWrongMinimum)) {
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

  void Print(const Row& row, const Errors& bounds, const Errors& planned) const {
    fmt::print("{},{},{},{:.3g},{:.3g},{},{},{}", row.ladder, row.what, row.setting,
               MedianOf(times_), MedianOf(solver_times_), seeds_, failures_, seeds_ - counts_[2]);
    for (std::size_t k = 0; k < counts_.size(); ++k) {
      fmt::print(",{}", Text(counts_[k] > 0 ? std::sqrt(squares_[k] / counts_[k]) : 0));
    }
    for (const double bound : bounds) fmt::print(",{}", Text(bound));
    for (const double plan : planned) fmt::print(",{}", Text(plan));
    fmt::print("\n");
    std::fflush(stdout);
  }

 private:
  void Take(std::size_t k, double error) {
    squares_[k] += error * error;
    ++counts_[k];
  }
  static std::string Text(double value) { return value > 0 ? fmt::format("{:.4g}", value) : ""; }

  std::vector<double> times_;
  std::vector<double> solver_times_;
  Errors squares_{};
  std::array<int, 3> counts_{};
  int seeds_ = 0;
  int failures_ = 0;
};

SyntheticDrop Base() {
  SyntheticDrop drop;
  drop.step_s = 2e-4;
  drop.noise_v = 5e-3 * tests::SpeedVoltage(drop);
  return drop;
}

SyntheticDrop Loaded(SyntheticDrop drop, double load_ohm) {
  drop.load_ohm = load_ohm;
  return drop;
}

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
    residuals->push_back((own[2] - std::exp(own[0]) * circuit.VoltageRatio(since_s)) / noise_v);
  }
}

// Cramer-Rao bounds of `drops` pairs
Errors BoundsOf(const SyntheticDrop& open, const SyntheticDrop& loaded, std::size_t drops) {
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

// ---- ways to fit

// answers, and says how long the solver took of it where there is one
using Fit = std::function<std::optional<Constants>(const RecordPair&, double*)>;
using Solve = std::function<bool(const JointProblem&, RingDownPoint*)>;

std::optional<Constants> ByPoles(
    const RecordPair& records,
    const std::function<std::optional<PolePair>(const ImpulseRecord&)>& poles) {
  const auto open = poles(records[0]);
  const auto loaded = poles(records[1]);
  if (!open || !loaded) return std::nullopt;
  return ConstantsOf(*open, *loaded, tests::ThesisKnowns(), kLoadOhm);
}

std::optional<PolePair> StartPoles(const ImpulseRecord& record) {
  const auto start = FindRingStart(record);
  if (!start) return std::nullopt;
  return start->poles;
}

std::optional<PolePair> FittedPoles(const ImpulseRecord& record) {
  const auto start = FindRingStart(record);
  if (!start) return std::nullopt;
  const auto samples = BlocksOf(record, start->first_sample, record.voltage_v.size(), 1);
  const RingFit fit = FitRing(samples, start->poles, {});
  if (!fit.converged) return std::nullopt;
  return fit.poles;
}

std::optional<Constants> Jointly(const RecordPair& records, const Solve& solve,
                                 bool starts_from_spectrum, double* solver_ms) {
  auto joint = MakeJointProblem(records, tests::ThesisKnowns());
  if (!joint) return std::nullopt;
  if (starts_from_spectrum) StartFromSpectrum(records, &*joint);
  RingDownPoint point = joint->start;
  bool converged = false;
  *solver_ms = MillisecondsOf([&] { converged = solve(*joint, &point); });
  if (!converged) return std::nullopt;
  return ConstantsAt(point);
}

std::optional<Constants> Whole(const std::vector<ImpulseRecord>& records,
                               const ActuatorKnowns& knowns) {
  const auto fit = FitDropTest(records, knowns);
  if (!fit || !fit->stiffness.determined || !fit->damping.determined) return std::nullopt;
  return Constants{fit->stiffness.value, fit->damping.value,
                   fit->force_constant.determined ? fit->force_constant.value : 0};
}

RecordPair Fewer(const RecordPair& records, std::size_t block,
                 ImpulseRecord (*fewer)(const ImpulseRecord&, std::size_t)) {
  return {fewer(records[0], block), fewer(records[1], block)};
}

std::vector<std::pair<std::string, Fit>> Methods() {
  constexpr double kDefaults = 1e-6;  // Ceres's own
  constexpr double kRounding = 1e-14;
  const Solve analytic = [](const JointProblem& joint, RingDownPoint* point) {
    return joint.problem.Minimise(joint.is_free, point).converged;
  };
  const auto automatic = [](double tolerance) -> Solve {
    return [tolerance](const JointProblem& joint, RingDownPoint* point) {
      return MinimiseByAutomaticDerivatives(joint, tests::ThesisKnowns(), tolerance, point);
    };
  };
  const auto poles = [](std::optional<PolePair> (*of)(const ImpulseRecord&)) -> Fit {
    return [of](const RecordPair& records, double*) { return ByPoles(records, of); };
  };
  const auto joint = [](const Solve& solve, bool from_spectrum) -> Fit {
    return [=](const RecordPair& records, double* solver_ms) {
      return Jointly(records, solve, from_spectrum, solver_ms);
    };
  };
  const auto fewer = [=](std::size_t block, auto* of) -> Fit {
    return [=](const RecordPair& records, double* solver_ms) {
      return Jointly(Fewer(records, block, of), analytic, false, solver_ms);
    };
  };
  return {{"spectrum alone", poles(PolesBySpectrum)},
          {"pencil alone", poles(PolesByPencil)},
          {"start values (pencil and fitted blocks)", poles(StartPoles)},
          {"separate fits", poles(FittedPoles)},
          {"joint: Gauss-Newton", joint(MinimiseByGaussNewton, false)},
          {"joint: Ceres automatic", joint(automatic(kRounding), false)},
          {"joint: Ceres automatic at its own tolerances", joint(automatic(kDefaults), false)},
          {"joint: Ceres analytic", joint(analytic, false)},
          {"joint: means of 4", fewer(4, Averaged)},
          {"joint: every 4th sample", fewer(4, Thinned)},
          {"from the spectrum's line: Gauss-Newton", joint(MinimiseByGaussNewton, true)},
          {"from the spectrum's line: Ceres analytic", joint(analytic, true)},
          {"all of FitDropTest", [](const RecordPair& records, double*) {
             return Whole(records, tests::ThesisKnowns());
           }}};
}

RecordPair PairOf(const SyntheticDrop& drop, std::size_t seed) {
  SyntheticDrop open = drop;
  open.seed = static_cast<unsigned>(2 * seed + 1);
  open.impact_s = 1e-7 * static_cast<double>(seed % 997);
  SyntheticDrop loaded = Loaded(open, kLoadOhm);
  loaded.seed = open.seed + 1;
  return {tests::MakeRecord(open), tests::MakeRecord(loaded)};
}

void Ways(std::size_t seeds) {
  for (const double noise : {0.002, 0.02, 0.2}) {
    SyntheticDrop drop = Base();
    drop.step_s = 1e-4;
    drop.noise_v = noise * tests::SpeedVoltage(drop);
    const auto methods = Methods();
    std::vector<Tally> tallies(methods.size());
    for (std::size_t seed = 0; seed < seeds; ++seed) {
      const RecordPair records = PairOf(drop, seed);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        std::optional<Constants> found;
        double solver_ms = 0;
        const double all_ms =
            MillisecondsOf([&] { found = methods[m].second(records, &solver_ms); });
        tallies[m].Add(found, all_ms, solver_ms);
      }
    }
    const Errors bounds = BoundsOf(drop, Loaded(drop, kLoadOhm), 1);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      tallies[m].Print({"way", methods[m].first, fmt::format("{:g}", noise)}, bounds, {});
    }
  }
}

// ---- the experiment

struct Experiment {
  SyntheticDrop drop = Base();
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
  return Whole(records, knowns);
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
  Tally tally;
  for (std::size_t seed = 0; seed < seeds; ++seed) {
    std::optional<Constants> found;
    const double all_ms = MillisecondsOf([&] { found = FitOnce(experiment, seed); });
    tally.Add(found, all_ms, 0);
  }
  tally.Print(
      {"experiment", what, setting},
      BoundsOf(experiment.drop, Loaded(experiment.drop, experiment.load_ohm), experiment.drops),
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
  return 2.5 * tests::SpeedVoltage(Base()) / std::exp2(bits);  // over 1.25 times the first peak
}

void Experiments(std::size_t seeds) {
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
}

}  // namespace
}  // namespace haptometer::fit

// fit_cost [SEEDS]
int main(int argc, char** argv) {
  const auto seeds = static_cast<std::size_t>(argc > 1 ? std::atoi(argv[1]) : 200);
  haptometer::fit::Ways(seeds / 2);
  haptometer::fit::Experiments(seeds);
}
