#include "tools/tune/tune.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/tuning/latency_limit.h"
#include "tools/cli/terminal.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "tune";
// points of the ridge that --all prints
constexpr std::size_t kRidgePoints = 6;
// relative deviation of a built spring from the best one
constexpr double kSpringError = 0.05;

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Find the adapter that moves the skin most, with a proved upper bound.",
    .examples = {"haptometer tune", "haptometer tune scene.toml --stiffness 5000:9000 --json",
                 "haptometer tune --objective stimulus --skin table"}};

// a weight for each area of the grid, by which the grid's RMS is the objective: Nr for the stimulus
// (S = Nr RMS), sqrt(Bs) for the power (Bs v^2)
std::vector<double> GridWeights(const TuneQuestion& question) {
  std::vector<double> weights;
  if (question.objective == sim::Objective::kSkinRms || question.problem.fixed_skin) return weights;
  weights.reserve(question.grid_values);
  for (const double area_m2 :
       sim::EqualSteps(question.problem.bounds.contact_area_m2, question.grid_values)) {
    weights.push_back(
        question.objective == sim::Objective::kStimulus
            ? sim::StimulatedReceptors(question.receptors, sim::ContactRadius(area_m2))
            : std::sqrt(sim::SkinOf(question.problem, area_m2).damping_n_s_per_m));
  }
  return weights;
}

// The best adapter of the problem, which is the question's or that with one spring. With a latency
// limit the bound is that without the limit; the numbers of the search are added to the answer's.
sim::AdapterOptimum OptimumOf(const sim::TuningProblem& problem, TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  sim::AdapterOptimum best =
      sim::FindAdapterOptimum(question.objective, problem, question.receptors);
  if (!question.latency_limit_s) return best;
  // a search over simulated runs, from the optimum without the limit
  const sim::PromptBest prompt =
      sim::BestWithinLatency(problem, *question.latency_limit_s, best.point);
  LatencySearch search = answer.latency.value_or(LatencySearch{});
  search.runs += prompt.runs;
  search.least_limit_s = std::max(search.least_limit_s, prompt.least_limit_s);
  // of several springs the best one without the limit decides whether the answer is proved
  if (!answer.latency || best.value > search.unlimited.value) {
    search.unlimited = {.point = best.point, .value = best.value};
    search.proved = prompt.is_unlimited;
  }
  answer.latency = search;
  // the answer is the best within the limit, below the bound
  best.point = prompt.point;
  best.value = prompt.value;
  return best;
}

// The best with each listed spring; the bound is the largest of theirs, which may belong to another
// spring than the best one.
sim::AdapterOptimum ChooseSpring(TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  sim::AdapterOptimum best;
  for (const double spring_n_per_m : question.springs_n_per_m) {
    sim::TuningProblem held = question.problem;
    // a range of one value holds the spring
    held.bounds.stiffness_n_per_m = {.lower = spring_n_per_m, .upper = spring_n_per_m};
    const sim::AdapterOptimum found = OptimumOf(held, answer);
    answer.listed.push_back({.point = found.point, .value = found.value});
    best.boxes += found.boxes;
    if (found.upper_bound > best.upper_bound) {
      best.upper_bound = found.upper_bound;
      best.proof = found.proof;
    }
    if (!(found.value > best.value)) continue;
    best.point = found.point;
    best.value = found.value;
  }
  return best;
}

// grid and ridge over the bounds; not for a list of springs
void AddGridAndRidge(TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  if (!question.springs_n_per_m.empty()) return;
  // the grid includes neither input power nor a limit of the travel
  if (question.objective != sim::Objective::kRmsPerWatt &&
      std::isinf(question.problem.mover_limit_m)) {
    answer.grid = sim::BestOnGrid(question.problem, question.grid_values, GridWeights(question));
  }
  const sim::Range& mass_kg = question.problem.bounds.motor_side_mass_kg;
  if (mass_kg.lower < mass_kg.upper) {
    answer.ridge =
        sim::RidgeOf(question.objective, question.problem, question.receptors, kRidgePoints);
  }
}

sim::SteadyState SteadyOf(const sim::TuningProblem& problem, const sim::AdapterPoint& point) {
  const sim::Skin skin = sim::SkinOf(problem, point.contact_area_m2);
  return sim::SolveSteadyState(sim::AssembleModel(problem.actuator, point.adapter, skin),
                               problem.drive, skin);
}

// objective and travel with a spring that deviates from the best
void AddWrongSprings(TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  for (const double factor : {1 - kSpringError, 1 + kSpringError}) {
    const sim::AdapterPoint& best = answer.optimum.point;
    sim::AdapterPoint built = best;
    built.adapter.stiffness_n_per_m *= factor;
    answer.springs.push_back({.cost = sim::CostOfSpring(question.objective, question.problem,
                                                        question.receptors, best, factor),
                              .mover_peak_m = SteadyOf(question.problem, built).mover_peak_m});
  }
}

// rounds up to three significant digits
double RoundedUp(double value) {
  const double step = std::pow(10, std::floor(std::log10(value)) - 2);
  return std::ceil(value / step) * step;
}

// why no adapter keeps to the latency: no rise, a limit below the uncertainty, or none found
std::unexpected<Error> NothingPrompt(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  const double least_ms = answer.latency->least_limit_s * 1e3;
  const double limit_ms = *question.latency_limit_s * 1e3;
  const double frequency_hz = question.problem.drive.frequency_hz;
  if (least_ms == 0) {
    return CannotAnswer(
        question.name,
        fmt::format("at {:g} Hz {}", frequency_hz,
                    NoLatencyText(question.problem, answer.latency->unlimited.point)),
        "leave out --latency");
  }
  if (limit_ms < least_ms) {
    return CannotAnswer(question.name,
                        fmt::format("a --latency of {:g} ms cannot be decided: at {:g} Hz the "
                                    "standard uncertainty of a latency is {:.3g} ms",
                                    limit_ms, frequency_hz, least_ms),
                        fmt::format("allow at least {:g} ms", RoundedUp(least_ms)));
  }
  return CannotAnswer(
      question.name,
      fmt::format("no adapter found within the bounds reaches 10 % within {:g} ms, uncertainty of "
                  "{:.3g} ms added (searched in {} runs, not proved)",
                  limit_ms, least_ms, answer.latency->runs),
      "allow more --latency, or wider bounds");
}

std::unexpected<Error> NothingFound(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  if (answer.latency) return NothingPrompt(answer);
  if (std::isinf(question.problem.mover_limit_m)) {
    return CannotAnswer(question.name, "no adapter found within the bounds moves the skin",
                        "allow wider bounds, or more --voltage");
  }
  return CannotAnswer(
      question.name,
      fmt::format("no adapter found within the bounds keeps the mover within {:g} mm",
                  question.problem.mover_limit_m * 1e3),
      "allow more --mover-travel, wider bounds, or less --voltage");
}

Result<TuneAnswer> Answer(const TuneQuestion& question) {
  const sim::TuningProblem& problem = question.problem;
  TuneAnswer answer;
  answer.question = question;
  answer.optimum =
      question.springs_n_per_m.empty() ? OptimumOf(problem, answer) : ChooseSpring(answer);
  // matched load: no adapter exceeds it (docs/explanation/notation.md)
  answer.matched_load_bound =
      sim::MatchedLoadBound(question.objective, problem,
                            sim::SourceOf(problem.actuator, problem.drive), question.receptors);

  if (!(answer.optimum.value > 0)) return NothingFound(answer);

  // the numbers that simulate gives, from the model with seven states
  const sim::AdapterPoint& best = answer.optimum.point;
  const sim::Skin skin = sim::SkinOf(problem, best.contact_area_m2);
  answer.steady = SteadyOf(problem, best);
  // power into the skin: Bs v^2, v RMS
  const double velocity_rms =
      2 * std::numbers::pi * problem.drive.frequency_hz * answer.steady.skin_rms_m;
  answer.skin_power_w = skin.damping_n_s_per_m * velocity_rms * velocity_rms;
  if (!problem.fixed_skin) {
    answer.stimulus_m = sim::SkinStimulus(
        question.receptors, sim::ContactRadius(best.contact_area_m2), answer.steady.skin_rms_m);
  }
  answer.rise = sim::RiseWith(problem, best);
  // grid, ridge and other springs have no latency
  if (question.latency_limit_s) return answer;
  AddGridAndRidge(answer);
  AddWrongSprings(answer);
  return answer;
}

}  // namespace

int RunTune(int argc, const char* const* argv) {
  cli::Options options(kText);
  TuneWords words;
  Declare(options, words);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto question = ReadQuestion(words);
  if (!question) return cli::ReportError(kVerb, question.error());
  if (auto good = document::CheckOutputs(words.outputs); !good) {
    return cli::ReportError(kVerb, good.error());
  }
  const auto answer = Answer(*question);
  if (!answer) return cli::ReportError(kVerb, answer.error());
  words.outputs.json = options.json();
  return document::Present(TuneDocument(*answer, words.outputs.HasFigures()), words.outputs, argc,
                           argv);
}

}  // namespace haptometer::tools
