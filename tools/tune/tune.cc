#include "tools/tune/tune.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "base/text.h"
#include "sim/scene/scene_file.h"
#include "sim/tuning/latency_limit.h"
#include "tools/cli/options.h"
#include "tools/document/present.h"
#include "tools/simulate/simulate_document.h"
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

// --- the question ---

// the command line: what is asked without the scene, and what is put to the scene
struct TuneWords {
  TuneQuestion asked{.name = "thesis", .problem = sim::ThesisProblem()};
  std::vector<std::string> scenes;
  std::string objective = "skin-rms";
  std::string skin = "text";
  std::string receptor_grid = "cell";
  std::optional<double> voltage_v, frequency_hz, receptors_per_mm2;
  std::optional<std::int64_t> grid;
  bool has_area = false;  // bounds of the contact's area are given
  document::Outputs outputs;
};

constexpr double kM2PerMm2 = 1e-6;
// range of scenes; beyond it results overflow
constexpr double kLeastStiffness = 1e-9, kMostStiffness = 1e9;

// an area in m2 from a number in mm2, with or without "mm2"
Result<double> ReadArea(std::string text) {
  if (text.ends_with("mm2")) text.resize(text.size() - 3);
  HAPTOMETER_LET(const auto number, ParseQuantity(text, Dimension::kNone, "--contact-area"));
  return number.value * kM2PerMm2;
}

// "LOW:HIGH", or one value as both ends
Result<void> ReadAreas(const std::string& text, sim::Range& range) {
  const std::size_t colon = text.find(':');
  HAPTOMETER_LET(range.lower, ReadArea(text.substr(0, colon)));
  HAPTOMETER_LET(range.upper, ReadArea(colon == std::string::npos ? text : text.substr(colon + 1)));
  return {};
}

// stiffnesses of available springs, in N/m, separated by commas
Result<void> ReadSprings(const std::string& text, std::vector<double>& springs_n_per_m) {
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    HAPTOMETER_LET(const auto spring, ParseQuantity(word, Dimension::kStiffness, "--springs"));
    if (!(spring.value >= kLeastStiffness && spring.value <= kMostStiffness)) {
      return Usage("--springs", fmt::format("has {}, which is not a stiffness of a spring", word),
                   "give those that can be had, such as --springs 8200,9100");
    }
    springs_n_per_m.push_back(spring.value);
  }
  if (!springs_n_per_m.empty()) return {};
  return Usage("--springs", "names no spring",
               "give those that can be had, such as --springs 8200,9100");
}

// a number without unit is refused: 25 would mean 25 s
Result<void> ReadLatency(const std::string& text, std::optional<double>& limit_s) {
  if (ParseQuantity(text, Dimension::kNone, "--latency")) {
    return Usage("--latency", fmt::format("'{}' has no unit, and a latency needs one", text),
                 fmt::format("did you mean {}ms?", text));
  }
  HAPTOMETER_LET(const auto limit, ParseQuantity(text, Dimension::kTime, "--latency"));
  if (!(limit.value > 0)) {
    return Usage("--latency", "must be above 0", "give the longest latency, such as 25ms");
  }
  limit_s = limit.value;
  return {};
}

// effects that the scene names beyond the linear motion: listed as omitted
void NoteEffects(const sim::Effects& effects, TuneQuestion& question) {
  // inductance is part of the linear model: off means L = 0
  if (effects[sim::Effect::kInductance] == sim::Wish::kOff) {
    question.problem.actuator.inductance_h = 0;
  }
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    if (k == sim::PlaceOf(sim::Effect::kInductance)) continue;
    if (effects.wishes[k] == sim::Wish::kOff) continue;
    question.left_out.emplace_back(sim::kEffectNames[k]);
  }
  // stops limit the travel in the scene, and --mover-travel does so here
  question.has_stops = effects[sim::Effect::kTravelStops] != sim::Wish::kOff;
}

// actuator, drive and, with --skin scene, the skin of the scene
Result<void> ReadScene(const TuneWords& words, TuneQuestion& question) {
  if (words.scenes.size() > 1) {
    return Usage(words.scenes[1], "is a second scene", "tune one at a time");
  }
  if (words.scenes.empty()) {
    if (words.skin != "scene") return {};
    return Usage("--skin scene", "has no scene", "give the scene.toml whose skin is meant");
  }
  HAPTOMETER_LET(const auto scene, sim::ReadSceneFile(words.scenes.front()));
  question.name = Printable(words.scenes.front());
  // the optimum is that of a free case under one sine without offset
  if (scene.grip.stiffness_n_per_m > 0 || scene.grip.damping_n_s_per_m > 0 || scene.grip.holds) {
    return CannotAnswer(words.scenes.front(), "holds the case, and tune has no held case",
                        "set [mounting] kind = \"free\"");
  }
  if (scene.drive.kind != sim::DriveKind::kSine) {
    return CannotAnswer(
        words.scenes.front(),
        fmt::format("drives with {}, and tune takes a sine alone", KindText(scene.drive.kind)),
        "set [drive] kind = \"sine\"");
  }
  if (scene.drive.offset_v != 0) {
    return CannotAnswer(words.scenes.front(), "drives with an offset, and tune has none",
                        "remove offset_v: it adds a constant to the motion");
  }
  question.problem.actuator = scene.actuator;
  // a resistance of the source is in series with the coil
  question.problem.actuator.resistance_ohm += scene.drive.source_resistance_ohm;
  question.problem.drive = scene.drive;
  NoteEffects(scene.effects, question);
  question.scene_skin = scene.skin;
  if (words.skin == "scene") question.problem.fixed_skin = scene.skin;
  return {};
}

// receptors on the pad: density x side^2, at most 1e4
Result<void> CheckReceptors(const sim::ReceptorField& field) {
  constexpr double kMostReceptors = 1e4;
  if (field.density_per_m2 * field.pad_side_m * field.pad_side_m <= kMostReceptors) return {};
  return Usage("--receptor-density", "makes more than 10 000 receptors on the pad",
               "it is a number per mm2");
}

Result<void> CheckDrive(const TuneQuestion& question) {
  const sim::SineDrive& drive = question.problem.drive;
  if (drive.amplitude_v > 0 && drive.frequency_hz > 0) return {};
  return Usage(
      question.name,
      fmt::format("{:g} V at {:g} Hz drive nothing", drive.amplitude_v, drive.frequency_hz),
      "give --voltage and --frequency above 0");
}

// options of the contact, which change nothing where the skin is the scene's
Result<void> CheckContact(const TuneWords& words, const TuneQuestion& question) {
  if (!question.problem.fixed_skin) return {};
  const sim::ReceptorField &field = question.receptors, usual;
  const bool has_receptors = field.grid != usual.grid || words.receptors_per_mm2 ||
                             field.field_radius_m != usual.field_radius_m ||
                             field.pad_side_m != usual.pad_side_m;
  return cli::CheckRules({
      {words.has_area, "--contact-area",
       "changes nothing with --skin scene: that skin is the same at every area", "leave it out"},
      {has_receptors, "--receptor-grid, --receptor-density, --field-radius, --pad",
       "change nothing with --skin scene, which has no area of contact", "leave them out"},
  });
}

// combinations of options that have no answer for an objective
Result<void> CheckObjective(const TuneWords& words, const TuneQuestion& question) {
  using enum sim::Objective;
  const sim::TuningProblem& problem = question.problem;
  const bool of_motion = question.objective == kSkinRms || question.objective == kStimulus;
  if (problem.skin_variation > 0 && !of_motion) {
    return Usage("--skin-varies", "is answered for skin-rms and stimulus only",
                 "leave it out for the other objectives");
  }
  // the stimulus depends on the contact's area through the law of the skin
  if (question.objective == kStimulus && problem.fixed_skin) {
    return Usage("--skin scene", "gives no law of the contact's area",
                 "leave it out for the objective stimulus");
  }
  if (question.latency_limit_s && question.objective != kSkinRms) {
    return Usage("--latency", "is answered for skin-rms only", "leave it out for other objectives");
  }
  if (question.objective != kRmsPerWatt) return {};
  if (!std::isinf(problem.mover_limit_m)) {
    return Usage("--mover-travel", "is not answered for rms-per-watt",
                 "leave it out, or ask for skin-rms, stimulus or skin-power");
  }
  if (!words.grid) return {};
  return Usage("--grid", "is not answered for rms-per-watt", "leave it out");
}

// options for the ranges of the adapter's numbers
void DeclareBounds(cli::Options& options, TuneWords& words) {
  sim::AdapterBounds& bounds = words.asked.problem.bounds;
  const auto declare = [&](std::string_view name, sim::Range& range, Dimension dimension,
                           cli::Bounds within, std::string_view what) {
    options.Range(name, &range.lower, &range.upper, dimension, within, what);
  };
  // wider than any adapter
  constexpr double kLeastMassKg = 1e-9, kMostMassKg = 1e6, kMostDamping = 1e9;
  declare("--motor-side-mass", bounds.motor_side_mass_kg, Dimension::kMass,
          cli::Within(0, kMostMassKg), "Mass on the motor's side");
  declare("--skin-side-mass", bounds.skin_side_mass_kg, Dimension::kMass,
          cli::Within(kLeastMassKg, kMostMassKg), "Mass on the skin's side");
  declare("--stiffness", bounds.stiffness_n_per_m, Dimension::kStiffness,
          cli::Within(kLeastStiffness, kMostStiffness), "Stiffness of the spring");
  options.Parsed(
      "--springs", "K,K,...",
      [&words](const std::string& text) { return ReadSprings(text, words.asked.springs_n_per_m); },
      "Choose from these springs, regardless of --stiffness");
  declare("--damping", bounds.damping_n_s_per_m, Dimension::kDamping, cli::Within(0, kMostDamping),
          "Damping of the damper");
  options
      .Parsed(
          "--contact-area", "LOW:HIGH",
          [&words, &bounds](const std::string& text) {
            words.has_area = true;
            return ReadAreas(text, bounds.contact_area_m2);
          },
          "Area of the contact, within 1 to 100 mm2")
      .Default(fmt::format("{:g}:{:g} mm2", bounds.contact_area_m2.lower / kM2PerMm2,
                           bounds.contact_area_m2.upper / kM2PerMm2));
}

void DeclareReceptors(cli::Options& options, TuneWords& words) {
  sim::ReceptorField& field = words.asked.receptors;
  options
      .Choice("--receptor-grid", &words.receptor_grid, {"cell", "edge"},
              "Receptors in the middle of their cells, or from edge to edge")
      .Rare();
  options
      .Number("--receptor-density", &words.receptors_per_mm2, Dimension::kNone, cli::Above(0),
              "Receptors per mm2")
      .Default(fmt::format("{:g}", field.density_per_m2 * kM2PerMm2))
      .Rare();
  options
      .Number("--field-radius", &field.field_radius_m, Dimension::kLength, cli::AtLeast(0),
              "Radius of a receptive field")
      .Rare();
  options
      .Number("--pad", &field.pad_side_m, Dimension::kLength, cli::Above(0),
              "Side of the fingerpad")
      .Rare();
}

void Declare(cli::Options& options, TuneWords& words) {
  TuneQuestion& asked = words.asked;
  // bounds of voltage in V and frequency in Hz
  constexpr cli::Bounds kDrive = cli::Within(1e-9, 1e9);
  options
      .Positionals("scene", &words.scenes,
                   "A scene.toml: its actuator and drive; without it the thesis's", 0)
      .is_repeated = false;
  options.Choice("--objective", &words.objective,
                 {"skin-rms", "stimulus", "skin-power", "rms-per-watt"}, "Quantity to maximise");
  DeclareBounds(options, words);
  options.Choice("--skin", &words.skin, {"text", "table", "scene"},
                 "The thesis's law up to 2000 (text) or 1200 N/m (table), or the scene's skin");
  options.Number("--skin-varies", &asked.problem.skin_variation, Dimension::kNone,
                 {.least = 0, .most = 1, .is_below = true},
                 "Maximise for the least favourable skin with Ks and Bs each varied by this share: "
                 "0.2 is 20 %");
  options.Number("--voltage", &words.voltage_v, Dimension::kVoltage, kDrive,
                 "Overrides the scene's amplitude");
  options.Number("--frequency", &words.frequency_hz, Dimension::kFrequency, kDrive,
                 "Overrides the scene's frequency");
  options.Number("--mover-travel", &asked.problem.mover_limit_m, Dimension::kLength, cli::Above(0),
                 "Largest permitted travel of the mover, to either side");
  options.Parsed(
      "--latency", "s",
      [&asked](const std::string& text) { return ReadLatency(text, asked.latency_limit_s); },
      "Largest permitted latency to 10 %, as simulate computes it; with its unit");
  document::DeclareOutputs(options, words.outputs,
                           {.all = "Print grid, ridge and the effect of other springs too",
                            .plot = "Draw the objective around the optimum, and the ridge",
                            .report = "Write a page with all numbers and figures"});
  options.Count("--grid", &words.grid, 1, 60, "Number of values per axis of the grid")
      .Default(fmt::format("{}", asked.grid_values));
  DeclareReceptors(options, words);
  // combinations that are refused before the scene is read
  options.Exclude("--grid", {"--springs"}, "the grid has no list of springs");
  options.Exclude("--grid", {"--mover-travel", "--latency"},
                  "the grid is without limits of travel and latency");
  options.Exclude("--latency", {"--skin-varies"}, "a latency is not answered for skins that vary");
  options.Exclude("--latency", {"--mover-travel"}, "the two are not answered together");
  options.Exclude("--mover-travel", {"--skin-varies"},
                  "a travel is not answered for skins that vary");
}

// reads the scene, if there is one; refuses what has no answer
Result<TuneQuestion> ReadQuestion(const TuneWords& words) {
  TuneQuestion question = words.asked;
  HAPTOMETER_TRY(ReadScene(words, question));
  sim::TuningProblem& problem = question.problem;
  if (words.skin == "table") problem.skin_range = sim::SkinRange::kTable;
  // options override the scene
  problem.drive.amplitude_v = words.voltage_v.value_or(problem.drive.amplitude_v);
  problem.drive.frequency_hz = words.frequency_hz.value_or(problem.drive.frequency_hz);
  // listed springs replace the range of stiffness
  if (!question.springs_n_per_m.empty()) {
    const auto [least, most] = std::ranges::minmax(question.springs_n_per_m);
    problem.bounds.stiffness_n_per_m = {.lower = least, .upper = most};
  }
  if (words.receptors_per_mm2) {
    question.receptors.density_per_m2 = *words.receptors_per_mm2 / kM2PerMm2;
  }
  if (words.receptor_grid == "edge") question.receptors.grid = sim::ReceptorGrid::kEdgeToEdge;
  if (words.grid) question.grid_values = static_cast<std::size_t>(*words.grid);
  question.objective = sim::ObjectiveOf(words.objective).value_or(sim::Objective::kSkinRms);
  if (const auto fault = sim::Fault(problem)) {
    return Usage(question.name, std::string(document::SentenceOf(*fault).text),
                 "give bounds as LOW:HIGH, such as --stiffness 2000:12000");
  }
  HAPTOMETER_TRY(CheckDrive(question));
  HAPTOMETER_TRY(CheckReceptors(question.receptors));
  HAPTOMETER_TRY(CheckObjective(words, question));
  HAPTOMETER_TRY(CheckContact(words, question));
  return question;
}

// --- the answer ---

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
  document::Outputs& outputs = words.outputs;
  Declare(options, words);
  return document::RunVerb(kVerb, options, outputs, argc, argv, [&]() -> Result<int> {
    HAPTOMETER_LET(const auto question, ReadQuestion(words));
    HAPTOMETER_LET(const auto answer, Answer(question));
    return document::Present(TuneDocument(answer, outputs.HasFigures()), outputs, argc, argv);
  });
}

}  // namespace haptometer::tools
