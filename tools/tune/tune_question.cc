#include "tools/tune/tune_question.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/text.h"
#include "sim/scene/scene_file.h"
#include "tools/simulate/simulate_document.h"

namespace haptometer::tools {
namespace {

constexpr double kM2PerMm2 = 1e-6;

// "LOW:HIGH" or one number for both
template <typename Read>
Result<sim::Range> ReadEnds(const std::string& text, const Read& read) {
  const std::size_t colon = text.find(':');
  const auto lower = read(text.substr(0, colon));
  if (!lower) return std::unexpected(lower.error());
  if (colon == std::string::npos) return sim::Range{.lower = *lower, .upper = *lower};
  const auto upper = read(text.substr(colon + 1));
  if (!upper) return std::unexpected(upper.error());
  return sim::Range{.lower = *lower, .upper = *upper};
}

struct BoundWord {
  const char* option;
  const std::string& text;
  Dimension dimension;
  sim::Range& range;
};

// the range of a scene's numbers, beyond which the answers are no numbers any more
Result<void> CheckReal(const std::string& option, double value) {
  constexpr double kSmallest = 1e-9, kLargest = 1e9;
  const double size = std::abs(value);
  if (size == 0 || (size >= kSmallest && size <= kLargest)) return {};
  return Usage(
      option,
      fmt::format("{:g} is outside {:g} to {:g}, where all scenes lie", value, kSmallest, kLargest),
      "check its unit");
}

Result<void> ReadBound(const BoundWord& word) {
  if (word.text.empty()) return {};
  const auto range = ReadEnds(word.text, [&](const std::string& end) -> Result<double> {
    const auto quantity = ParseQuantity(end, word.dimension, word.option);
    if (!quantity) return std::unexpected(quantity.error());
    if (auto real = CheckReal(word.option, quantity->value); !real) {
      return std::unexpected(real.error());
    }
    return quantity->value;
  });
  if (!range) return std::unexpected(range.error());
  word.range = *range;
  return {};
}

// the stiffnesses that can be had; the bounds become their range
Result<void> ReadSprings(const std::string& text, TuneQuestion& question) {
  if (text.empty()) return {};
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto spring = ParseQuantity(word, Dimension::kStiffness, "--springs");
    if (!spring) return std::unexpected(spring.error());
    if (!(spring->value > 0)) {
      return Usage("--springs", fmt::format("has {}, and a stiffness must be above 0", word),
                   "give those that can be had, such as --springs 8200,9100");
    }
    if (auto real = CheckReal("--springs", spring->value); !real) return real;
    question.springs_n_per_m.push_back(spring->value);
  }
  const auto [least, most] = std::ranges::minmax(question.springs_n_per_m);
  question.problem.bounds.stiffness_n_per_m = {.lower = least, .upper = most};
  return {};
}

// areas are the one quantity in mm2
Result<void> ReadAreas(const std::string& text, sim::Range& range) {
  if (text.empty()) return {};
  const auto read = ReadEnds(text, [](std::string end) -> Result<double> {
    if (end.ends_with("mm2")) end.resize(end.size() - 3);
    const auto number = ParseQuantity(end, Dimension::kNone, "--contact-area");
    if (!number) return std::unexpected(number.error());
    return number->value * kM2PerMm2;
  });
  if (!read) return std::unexpected(read.error());
  range = *read;
  return {};
}

Result<void> ReadBounds(const TuneWords& words, sim::AdapterBounds& bounds) {
  for (const BoundWord& word :
       {BoundWord{"--motor-side-mass", words.motor_side_mass, Dimension::kMass,
                  bounds.motor_side_mass_kg},
        BoundWord{"--skin-side-mass", words.skin_side_mass, Dimension::kMass,
                  bounds.skin_side_mass_kg},
        BoundWord{"--stiffness", words.stiffness, Dimension::kStiffness, bounds.stiffness_n_per_m},
        BoundWord{"--damping", words.damping, Dimension::kDamping, bounds.damping_n_s_per_m}}) {
    if (auto read = ReadBound(word); !read) return read;
  }
  return ReadAreas(words.contact_area, bounds.contact_area_m2);
}

// what the scene names beyond the linear motion under its drive
void NoteEffects(const sim::Effects& effects, TuneQuestion& question) {
  if (effects[sim::Effect::kInductance] == sim::Wish::kOff) {
    question.problem.actuator.inductance_h = 0;
  }
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    if (k == sim::PlaceOf(sim::Effect::kInductance)) continue;
    if (effects.wishes[k] == sim::Wish::kOff) continue;
    question.left_out.emplace_back(sim::kEffectNames[k]);
  }
  question.has_stops = effects[sim::Effect::kTravelStops] != sim::Wish::kOff;
}

// actuator, drive and, where it is asked for, the skin of the scene
Result<void> ReadScene(const TuneWords& words, TuneQuestion& question) {
  if (words.scenes.size() > 1) {
    return Usage(words.scenes[1], "is a second scene", "tune one at a time");
  }
  if (words.scenes.empty()) {
    if (words.skin != "scene") return {};
    return Usage("--skin scene", "has no scene", "give the scene.toml whose skin is meant");
  }
  const auto scene = sim::ReadSceneFile(words.scenes.front());
  if (!scene) return std::unexpected(scene.error());
  question.name = Printable(words.scenes.front());
  if (scene->grip.stiffness_n_per_m > 0 || scene->grip.damping_n_s_per_m > 0 || scene->grip.holds) {
    return CannotAnswer(words.scenes.front(), "holds the case, which tune does not know",
                        "set [mounting] kind = \"free\"");
  }
  if (scene->drive.kind != sim::DriveKind::kSine) {
    return CannotAnswer(
        words.scenes.front(),
        fmt::format("drives with {}, and tune knows a sine alone", KindText(scene->drive.kind)),
        "set [drive] kind = \"sine\"");
  }
  if (scene->drive.offset_v != 0) {
    return CannotAnswer(words.scenes.front(), "drives with an offset, which tune does not know",
                        "remove offset_v: it adds a constant to the motion");
  }
  question.problem.actuator = scene->actuator;
  question.problem.actuator.resistance_ohm += scene->drive.source_resistance_ohm;
  question.problem.drive = scene->drive;
  NoteEffects(scene->effects, question);
  if (words.skin == "scene") question.problem.fixed_skin = scene->skin;
  return {};
}

Result<void> ReadReceptors(const TuneWords& words, sim::ReceptorField& field) {
  field.grid = words.receptor_grid == "edge" ? sim::ReceptorGrid::kEdgeToEdge
                                             : sim::ReceptorGrid::kCellCentred;
  if (words.receptor_density) field.density_per_m2 = words.receptor_density->value / kM2PerMm2;
  if (words.field_radius) field.field_radius_m = words.field_radius->value;
  if (words.pad_side) field.pad_side_m = words.pad_side->value;
  if (!(field.density_per_m2 > 0 && field.pad_side_m > 0 && field.field_radius_m >= 0)) {
    return Usage("--receptor-density, --field-radius, --pad", "must be above 0",
                 "the thesis has 0.22 (per mm2), 5.7mm and 15mm");
  }
  constexpr double kMostReceptors = 1e4;
  if (field.density_per_m2 * field.pad_side_m * field.pad_side_m > kMostReceptors) {
    return Usage("--receptor-density", "makes more than 10 000 receptors on the pad",
                 "it is a number per mm2");
  }
  return {};
}

// A bare number is refused, which a time elsewhere may be: 25 would be 25 s.
Result<void> ReadLatency(const std::string& text, TuneQuestion& question) {
  if (text.empty()) return {};
  if (ParseQuantity(text, Dimension::kNone, "--latency")) {
    return Usage("--latency", fmt::format("'{}' has no unit, and a latency needs one", text),
                 fmt::format("did you mean {}ms?", text));
  }
  const auto limit = ParseQuantity(text, Dimension::kTime, "--latency");
  if (!limit) return std::unexpected(limit.error());
  question.latency_limit_s = limit->value;
  return {};
}

Result<void> CheckDrive(const TuneQuestion& question) {
  const sim::SineDrive& drive = question.problem.drive;
  if (!(drive.amplitude_v > 0 && drive.frequency_hz > 0)) {
    return Usage(
        question.name,
        fmt::format("{:g} V at {:g} Hz drive nothing", drive.amplitude_v, drive.frequency_hz),
        "give --voltage and --frequency above 0");
  }
  if (auto real = CheckReal("--voltage", drive.amplitude_v); !real) return real;
  return CheckReal("--frequency", drive.frequency_hz);
}

Result<void> CheckVariation(double part) {
  if (part >= 0 && part < 1) return {};
  return Usage("--skin-varies", "the skin's variation must be from 0 to below 1",
               "give a part of one: 0.2 is 20 %");
}

// the grid is of the thesis's bounds and objectives, without limits
Result<void> ReadGrid(const TuneWords& words, TuneQuestion& question) {
  if (!words.grid) return {};
  if (question.latency_limit_s || std::isfinite(question.problem.mover_limit_m)) {
    return Usage("--grid", "knows neither travel nor latency",
                 "leave it out beside --mover-travel and --latency");
  }
  if (!question.springs_n_per_m.empty()) {
    return Usage("--grid", "knows no list of springs", "leave it out beside --springs");
  }
  if (question.objective == sim::Objective::kRmsPerWatt) {
    return Usage("--grid", "does not know the power", "leave it out for rms-per-watt");
  }
  question.grid_values = static_cast<std::size_t>(*words.grid);
  return {};
}

// the latency is a number of a run of one adapter on one skin
Result<void> CheckLatency(const TuneQuestion& question) {
  if (!question.latency_limit_s) return {};
  if (!(*question.latency_limit_s > 0)) {
    return Usage("--latency", "must be above 0", "give the longest latency, such as 25ms");
  }
  if (question.objective != sim::Objective::kSkinRms) {
    return Usage("--latency", "is answered for skin-rms only", "leave it out for other objectives");
  }
  if (question.problem.skin_variation > 0) {
    return Usage("--latency", "is not answered for skins that vary",
                 "leave out one of --latency and --skin-varies");
  }
  if (!std::isinf(question.problem.mover_limit_m)) {
    return Usage("--latency", "is not answered together with --mover-travel",
                 "ask for one, and look at the other's number in the answer");
  }
  return {};
}

// what is answered for some objectives only
Result<void> CheckObjective(const TuneQuestion& question) {
  using enum sim::Objective;
  const sim::TuningProblem& problem = question.problem;
  const bool of_motion = question.objective == kSkinRms || question.objective == kStimulus;
  if (problem.skin_variation > 0 && !of_motion) {
    return Usage("--skin-varies", "is answered for skin-rms and stimulus only",
                 "leave it out for the other objectives");
  }
  if (question.objective == kStimulus && problem.fixed_skin) {
    return Usage("--skin scene", "does not know what the contact's area does to the skin",
                 "leave it out for the objective stimulus");
  }
  if (std::isinf(problem.mover_limit_m)) return {};
  if (question.objective == kRmsPerWatt) {
    return Usage("--mover-travel", "is not answered for rms-per-watt",
                 "leave it out, or ask for skin-rms, stimulus or skin-power");
  }
  if (problem.skin_variation > 0) {
    return Usage("--mover-travel", "is not answered for skins that vary",
                 "leave out one of --mover-travel and --skin-varies");
  }
  return {};
}

}  // namespace

void Declare(cli::Options& options, TuneWords& words) {
  using cli::Shown;
  options.Positionals("scene", &words.scenes,
                      "A scene.toml: its actuator and drive; without it the thesis's", 0);
  options.Choice("--objective", &words.objective,
                 {"skin-rms", "stimulus", "skin-power", "rms-per-watt"}, "What is made largest");
  options.Text("--motor-side-mass", &words.motor_side_mass, "LOW:HIGH", "Bounds; 0.25g:10g");
  options.Text("--skin-side-mass", &words.skin_side_mass, "LOW:HIGH", "Bounds; 0.25g:10g");
  options.Text("--stiffness", &words.stiffness, "LOW:HIGH", "Bounds; 2000:12000 N/m");
  options.Text("--springs", &words.springs, "K,K,...", "Choose from these; overrides --stiffness");
  options.Text("--damping", &words.damping, "LOW:HIGH", "Bounds; 0.01:0.1 N s/m");
  options.Text("--contact-area", &words.contact_area, "LOW:HIGH", "Bounds; 1:100 mm2");
  options.Choice("--skin", &words.skin, {"text", "table", "scene"},
                 "The thesis's law up to 2000 (text) or 1200 N/m (table), or the scene's skin");
  options.Number("--skin-varies", &words.skin_varies, Dimension::kNone,
                 "Best for the worst of skins, Ks and Bs each by this part: 0.2 is 20 %");
  options.Number("--voltage", &words.voltage, Dimension::kVoltage,
                 "Overrides the scene's amplitude");
  options.Number("--frequency", &words.frequency, Dimension::kFrequency,
                 "Overrides the scene's frequency");
  options.Number("--mover-travel", &words.mover_travel, Dimension::kLength,
                 "Only adapters with which the mover travels no further, to either side");
  options.Text("--latency", &words.latency, "s",
               "Only adapters whose latency to 10 % (as of simulate) is no longer");
  options.Flag("--all", &words.outputs.all, "Grid, ridge and wrong springs too");
  options.Output("--plot", &words.outputs.plot, "FILE",
                 "Draw the objective around the optimum, and the ridge");
  options.Output("--report", &words.outputs.report, "FILE.html",
                 "Write a page with all numbers and figures");
  options.Count("--grid", &words.grid, 1, 60, "Values an axis of the grid beside; 20");
  options.Choice("--receptor-grid", &words.receptor_grid, {"cell", "edge"},
                 "Receptors in the middle of their cells, or from edge to edge", Shown::kHelpAll);
  options.Number("--receptor-density", &words.receptor_density, Dimension::kNone,
                 "Receptors per mm2; 0.22", Shown::kHelpAll);
  options.Number("--field-radius", &words.field_radius, Dimension::kLength,
                 "Of a receptive field; 5.7mm", Shown::kHelpAll);
  options.Number("--pad", &words.pad_side, Dimension::kLength, "Side of the fingerpad; 15mm",
                 Shown::kHelpAll);
}

Result<TuneQuestion> ReadQuestion(const TuneWords& words) {
  TuneQuestion question;
  question.name = "thesis";
  question.problem = sim::ThesisProblem();
  if (auto read = ReadScene(words, question); !read) return std::unexpected(read.error());
  sim::TuningProblem& problem = question.problem;
  if (words.skin == "table") problem.skin_range = sim::SkinRange::kTable;
  if (words.mover_travel) problem.mover_limit_m = words.mover_travel->value;
  if (!(problem.mover_limit_m > 0)) {
    return Usage("--mover-travel", "must be above 0",
                 "give the longest travel to one side, such as 0.5mm");
  }
  if (words.skin_varies) problem.skin_variation = words.skin_varies->value;
  if (words.voltage) problem.drive.amplitude_v = words.voltage->value;
  if (words.frequency) problem.drive.frequency_hz = words.frequency->value;
  if (auto fit = CheckVariation(problem.skin_variation); !fit) return std::unexpected(fit.error());
  if (auto fit = CheckDrive(question); !fit) return std::unexpected(fit.error());
  if (auto read = ReadBounds(words, problem.bounds); !read) return std::unexpected(read.error());
  if (auto read = ReadSprings(words.springs, question); !read) {
    return std::unexpected(read.error());
  }
  if (auto read = ReadReceptors(words, question.receptors); !read) {
    return std::unexpected(read.error());
  }
  if (const auto fault = sim::Fault(problem)) {
    return Usage(question.name, std::string(document::SentenceOf(*fault).text),
                 "give bounds as LOW:HIGH, such as --stiffness 2000:12000");
  }
  question.objective = sim::ObjectiveOf(words.objective).value_or(sim::Objective::kSkinRms);
  if (auto fit = CheckObjective(question); !fit) return std::unexpected(fit.error());
  if (auto read = ReadLatency(words.latency, question); !read) {
    return std::unexpected(read.error());
  }
  if (auto fit = CheckLatency(question); !fit) return std::unexpected(fit.error());
  if (auto read = ReadGrid(words, question); !read) return std::unexpected(read.error());
  return question;
}

}  // namespace haptometer::tools
