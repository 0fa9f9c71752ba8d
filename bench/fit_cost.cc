// What accuracy costs in a fit: prints docs/fit_cost.csv (fixtures/generate/fit_cost.py runs and
// draws it). Seeded drops of the thesis's actuator: first by ways to fit one pair of records (open
// and 33 ohm), then by what the experiment was (fit_experiments.h). Errors are relative, in RMS
// over the seeds, beside the Cramer-Rao bound.
#include <fmt/core.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/fit_experiments.h"
#include "bench/fit_rungs.h"
#include "bench/fit_tally.h"
#include "fit/drop_test/ring_fit.h"
#include "fit/drop_test/ring_start.h"
#include "tests/fit/synthetic_drop.h"

namespace haptometer::fit {
namespace {

using tests::SyntheticDrop;

constexpr double kLoadOhm = 33;
constexpr double kWrongMinimum = 0.01;  // of Kv: a third of a cycle over the record

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

// where a joint fit begins; false start values are for seeing who finds back from them
enum class Begin : std::uint8_t { kPencil, kSpectrumLine, kBadGuess };
constexpr double kBadGuessHz = 400;  // of 225

std::optional<Constants> Jointly(const RecordPair& records, const Solve& solve, Begin begin,
                                 double* solver_ms) {
  auto joint = MakeJointProblem(records, tests::ThesisKnowns());
  if (!joint) return std::nullopt;
  if (begin == Begin::kSpectrumLine) StartFrom(SpectrumLine(records[0]), &*joint);
  if (begin == Begin::kBadGuess) StartFrom(kBadGuessHz, &*joint);
  RingDownPoint point = joint->start;
  bool converged = false;
  *solver_ms = MillisecondsOf([&] { converged = solve(*joint, &point); });
  if (!converged) return std::nullopt;
  return ConstantsAt(point);
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
  const auto joint = [](const Solve& solve, Begin begin) -> Fit {
    return [=](const RecordPair& records, double* solver_ms) {
      return Jointly(records, solve, begin, solver_ms);
    };
  };
  const auto fewer = [=](std::size_t block, auto* of) -> Fit {
    return [=](const RecordPair& records, double* solver_ms) {
      return Jointly(Fewer(records, block, of), analytic, Begin::kPencil, solver_ms);
    };
  };
  return {{"spectrum alone", poles(PolesBySpectrum)},
          {"pencil alone", poles(PolesByPencil)},
          {"start values (pencil and fitted blocks)", poles(StartPoles)},
          {"separate fits", poles(FittedPoles)},
          {"joint: Gauss-Newton", joint(MinimiseByGaussNewton, Begin::kPencil)},
          {"joint: Ceres automatic", joint(automatic(kRounding), Begin::kPencil)},
          {"joint: Ceres with its own tolerances", joint(automatic(kDefaults), Begin::kPencil)},
          {"joint: Ceres analytic", joint(analytic, Begin::kPencil)},
          {"joint: means of 4", fewer(4, Averaged)},
          {"joint: every 4th sample", fewer(4, Decimated)},
          {"from the spectrum's line: Gauss-Newton",
           joint(MinimiseByGaussNewton, Begin::kSpectrumLine)},
          {"from the spectrum's line: Ceres analytic", joint(analytic, Begin::kSpectrumLine)},
          {"from a guess of 400 Hz: Gauss-Newton", joint(MinimiseByGaussNewton, Begin::kBadGuess)},
          {"from a guess of 400 Hz: Ceres analytic", joint(analytic, Begin::kBadGuess)},
          {"all of FitDropTest", [](const RecordPair& records, double*) {
             return FitWhole(records, tests::ThesisKnowns());
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
    SyntheticDrop drop = BaseDrop();
    drop.step_s = 1e-4;
    drop.noise_v = noise * tests::SpeedVoltage(drop);
    const auto methods = Methods();
    std::vector<FitTally> tallies;
    tallies.reserve(methods.size());
    for (const auto& method : methods) {
      tallies.emplace_back(Row{"way", method.first, fmt::format("{:g}", noise), kWrongMinimum});
    }
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
    const Errors bounds = BoundsOf(drop, kLoadOhm, 1);
    for (const FitTally& tally : tallies) tally.Print(bounds, {});
  }
}

}  // namespace
}  // namespace haptometer::fit

// fit_cost [SEEDS]
int main(int argc, char** argv) {
  const auto seeds = static_cast<std::size_t>(argc > 1 ? std::atoi(argv[1]) : 100);
  haptometer::fit::Ways(seeds / 2);
  haptometer::fit::MeasureExperiments(seeds);
}
