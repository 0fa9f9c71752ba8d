#include "tools/simulate/simulate_document.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "base/elementary_functions.h"
#include "base/mapped.h"
#include "base/text.h"
#include "sim/linear/linear_model.h"
#include "sim/scene/plausible_ranges.h"
#include "tools/document/keys.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Item;
using document::Key;
using document::Section;

// keys of more than one place
constexpr Key kDrivePeriods{"drive_periods", "drive periods per repetition"};
constexpr Key kSolverSteps{"solver_steps", "steps of the solver"};

bool IsNamed(const SceneAnswer& solved, sim::Effect effect) {
  return solved.scene.effects[effect] != sim::Wish::kOff;
}

// assumptions about springs, stops, preload and contact
void NoteBodies(const SceneAnswer& solved, sim::Findings& of_sim,
                Findings<SimulateFinding>& findings) {
  // a spring law or stops act on the mover only; without them every spring is linear
  if (IsNamed(solved, sim::Effect::kStiffening) || IsNamed(solved, sim::Effect::kTravelStops)) {
    findings.Note(SimulateFinding::kOtherSpringsLinear);
  } else {
    sim::Finding linear{Severity::kNote, sim::FindingKind::kLinearSprings, {}};
    if (solved.scene.effects.stiffening) linear.numbers = {{"off", std::string("stiffening")}};
    of_sim.Add(std::move(linear));
  }
  // without the effect contact cannot break: the peak force is the least preload that keeps it
  if (!IsNamed(solved, sim::Effect::kContactLoss) && (solved.steady || solved.tones)) {
    const double peak_n =
        -(solved.steady ? solved.steady->skin_force_least_n : solved.tones->skin_force_least_n);
    of_sim.Note(sim::FindingKind::kContactKept, {{"least_force_n", peak_n}});
  }
  const double preload_n = solved.scene.mover_preload_n;
  if (preload_n == 0) return;
  const sim::EffectiveScene effective = EffectiveOf(solved);
  FindingOf<SimulateFinding> preload{
      Severity::kNote,
      // static displacement of the mover in m, under weight too and by the cubic law where it is on
      SimulateFinding::kMoverPreload,
      {{"preload_n", preload_n},
       {"displacement_m", sim::MoverSag(solved.scene, IsNamed(solved, sim::Effect::kGravity),
                                        effective.smooth.spring.has_value())}}};
  if (sim::RestsOnStop(effective)) preload.numbers.emplace_back("stop", std::string("stop"));
  findings.Add(std::move(preload));
}

// with a resistance of the source the terminal voltage differs from the stated one
void NoteSource(const SceneAnswer& solved, Findings<SimulateFinding>& findings) {
  const double source_ohm = solved.scene.drive.source_resistance_ohm;
  const auto kind = IsNamed(solved, sim::Effect::kCoilHeating)
                        ? SimulateFinding::kOnlyCoilWarms
                        : SimulateFinding::kSourceHoldsVoltage;
  FindingOf<SimulateFinding> source{Severity::kNote, kind};
  if (source_ohm > 0) source.numbers = {{"source_resistance_ohm", source_ohm}};
  findings.Add(std::move(source));
}

// how a run under limits or effects ends, and until when its numbers are valid
void NoteMotion(const SceneAnswer& solved, Findings<SimulateFinding>& findings) {
  // a sine with a duration and no steady state: stops, lost contact or a smooth effect limit it
  const bool is_sine = solved.scene.drive.kind == sim::DriveKind::kSine;
  if (is_sine && solved.scene.duration_s && !solved.steady && solved.effects) {
    findings.Note(SimulateFinding::kSteadyNotLinear);
  }
  if (solved.tones && !(solved.tones->period_s > 0)) findings.Note(SimulateFinding::kPeaksAreSums);
  if (is_sine && solved.scene.duration_s && !solved.window &&
      *solved.scene.duration_s * solved.scene.drive.frequency_hz < kWindowPeriods) {
    findings.Note(SimulateFinding::kNoWindow, {{"run_s", *solved.scene.duration_s}});
  }
  // the run is valid until its error exceeds the tolerance
  const sim::SceneRun* run = RunOf(solved);
  if (run != nullptr && run->known_until_s) {
    findings.Doubt(SimulateFinding::kKnownUntil,
                   {{"tolerance", solved.scene.tolerance}, {"known_until_s", *run->known_until_s}});
  }
  const bool is_told = run != nullptr && run->known_until_s;
  if (!is_told && IsAboveAsked(solved)) {
    FindingOf<SimulateFinding> above{
        Severity::kDoubt,
        SimulateFinding::kErrorAboveAsked,
        {{"relative_error", ErrorOfAll(solved)}, {"tolerance", solved.scene.tolerance}}};
    if (sim::DriveError(solved.scene) > 0) {
      above.numbers.emplace_back("hold_tolerance", solved.scene.drive.hold_tolerance);
    }
    findings.Add(std::move(above));
  }
  if (!solved.effects) return;
  // chaos: growth is the largest Lyapunov exponent per drive period, with its uncertainty
  if (const auto& chaotic = solved.effects->chaotic) {
    findings.Note(SimulateFinding::kChaotic,
                  {{"growth", chaotic->exponent},
                   {"growth_uncertainty", chaotic->exponent_standard_uncertainty},
                   {"periods", chaotic->periods}});
  }
  // a run whose end repeats after whole drive periods needs no doubt about its window
  if (!solved.effects->end || solved.effects->end->drive_periods) return;
  if (const auto uncertainty = solved.effects->end->window_uncertainty) {
    findings.Doubt(SimulateFinding::kEndVaries, {{"relative_uncertainty", *uncertainty}});
  } else {
    findings.Doubt(SimulateFinding::kEndNotKnown);
  }
}

// findings of this verb and those of sim, in one list of the document
void AddAllFindings(const SimulateAnswer& answer, Section& root) {
  sim::Findings of_sim;
  sim::NoteUnused(answer.solved.scene, of_sim);
  Findings<SimulateFinding> findings = answer.findings;
  NoteMotion(answer.solved, findings);
  NoteBodies(answer.solved, of_sim, findings);
  NoteSource(answer.solved, findings);
  if (answer.numbers.no_rise) of_sim.Add(*answer.numbers.no_rise);
  sim::DoubtUnusual(answer.solved.scene, of_sim);
  document::AddFindings(root, findings);
  document::AddFindings(root, of_sim);
}

// --- the motion ---

// the computations that gave the numbers, joined by "; "
std::string Method(const SceneAnswer& solved) {
  std::vector<std::string_view> methods;
  if (solved.steady) methods.emplace_back("exact phasor of the linear model");
  if (solved.tones || IsSuperposed(solved)) {
    methods.emplace_back("exact phasors of the linear model, superposed");
  }
  if (solved.plain_run) methods.emplace_back("exact pieces of the drive");
  // with a smooth effect one solver plays the run, its window included
  const bool smooth = solved.effects && solved.effects->run.solver_tolerance > 0;
  if (solved.window && !smooth) methods.emplace_back("window by the balanced matrix exponential");
  if (solved.effects && solved.effects->periodic) methods.emplace_back("transient and shooting");
  if (solved.effects && solved.effects->chaotic) methods.emplace_back("averages of batches");
  if (solved.effects && !solved.effects->run.events.empty()) {
    methods.emplace_back("events located to rounding");
  }
  if (smooth) {
    methods.emplace_back("exponential collocation");
  }
  return fmt::format("{}", fmt::join(methods, "; "));
}

// resolution of a number: its relative error times its value, so no digit below it is printed
void AddNumbers(std::span<const AnswerNumber> numbers, const SceneAnswer& solved, double error,
                Section& section) {
  for (const AnswerNumber& number : numbers) {
    const std::optional<double> value = number.of(solved);
    section.Add(number.key, value).resolution = std::abs(value.value_or(0)) * error;
  }
}

Section SteadySection(const SceneAnswer& solved) {
  Section steady;
  AddNumbers(SteadyNumbers(), solved, ErrorOfAll(solved), steady);
  // the skin's RMS is the first of SteadyNumbers()
  Item& skin = steady.items.front();
  skin.form = document::Form::kUncertain;
  // from the actuator's constants: u = relative u x RMS, where the steady motion is the linear one
  const double relative_uncertainty = solved.steady ? sim::SkinRmsUncertainty(solved.scene) : 0;
  if (relative_uncertainty > 0) {
    skin.standard_uncertainty = relative_uncertainty * solved.steady->skin_rms_m;
    skin.note = "standard uncertainty from the actuator's constants";
  }
  // constant part of the motion, caused by an offset of the voltage; absent without one
  Section mean{.is_known = solved.steady && solved.scene.drive.offset_v != 0};
  const double skin_m =
      mean.is_known ? solved.steady->mean(sim::AssembleModel(solved.scene).skin()) : 0;
  mean.Add({"skin_mean_m", "skin displacement, constant part", document::kMetre}, skin_m);
  mean.Add({"mover_mean_m", "mover displacement in its case, constant part", document::kMetre},
           mean.is_known ? solved.steady->mean_travel_m : 0);
  mean.Add({"current_mean_a", "current, constant part", document::kAmpere},
           mean.is_known ? solved.steady->mean_current_a : 0);
  steady.sections.push_back(std::move(mean));
  return steady;
}

// preload and weight act on the contact; a least force below 0 N means that contact is lost, where
// it is not assumed to be kept
Section ContactSection(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  Section contact;
  Item& least = contact.Add({"contact_force_least_n", "least force on the skin", document::kNewton},
                            answer.numbers.contact_force_least_n);
  const bool pulls = answer.numbers.contact_force_least_n.value_or(0) < 0;
  if (IsNamed(solved, sim::Effect::kContactLoss)) {
    least.note = "preload and weight included";
    if (pulls) least.note += ": contact is lost";
  } else {
    least.note = pulls ? "pulled, as contact is assumed to be kept" : "weight included";
  }
  contact.Add({"efficiency", "part of the power into the skin", document::kShare},
              answer.numbers.efficiency);
  const auto& tones = solved.tones;
  contact.Add({"period_s", "repeats itself every", document::kSecond},
              tones && tones->period_s > 0 ? std::optional(tones->period_s) : std::nullopt);
  return contact;
}

std::string_view StartName(const sim::Scene& scene) {
  if (scene.initial.Any()) return "the stated start";
  return sim::StartOf(scene) == sim::Start::kRest ? "rest" : "the steady state";
}

// RMS over the last ten periods of the run, and the motion that the run starts from
Section WindowSection(const SceneAnswer& solved) {
  Section section{.is_known = solved.window.has_value()};
  const WindowAnswer window = solved.window.value_or(WindowAnswer{});
  // so many digits that the window is shown to three of its length
  const double windows = window.end_s / (window.end_s - window.begin_s);
  const int digits = section.is_known ? std::max(6, 4 + static_cast<int>(Log10(windows))) : 6;
  section.Add(kWindowRms, window.skin_rms_m).note =
      fmt::format("{:.{}g} to {:.{}g} s, from {}", window.begin_s, digits, window.end_s, digits,
                  StartName(solved.scene));
  section.Add({document::kWindowS.name}, document::Range{window.begin_s, window.end_s});
  return section;
}

// --- the run ---

Section EventsTable(const sim::SceneRun& run) {
  Section events{.name = document::kEvents.name,
                 .heading = run.events.empty() ? "" : std::string(document::kEvents.label),
                 .shape = Section::Shape::kTable};
  for (const sim::EventCount& event : run.events) {
    Section& row = events.sections.emplace_back();
    row.Add({document::kName.name, "event"}, event.name);
    row.Add({document::kCount.name, "times"}, event.count);
    row.Add({document::kFirst.name, "first at", document::kSecond}, event.first_s);
  }
  return events;
}

Section RunSection(const SceneAnswer& solved) {
  const sim::SceneRun* played = RunOf(solved);
  Section section{.name = "run", .heading = "run", .is_known = played != nullptr};
  if (played == nullptr) return section;
  const sim::SceneRun& run = *played;
  // numbers of the motion reached in the end are printed in the steady section instead
  if (SettledRun(solved) != nullptr || solved.steady) section.detail = Detail::kAll;
  // interval of time that the numbers of the run are of; superposed ones are over all time
  using Window = std::optional<document::Range>;
  section.Add(document::kWindowS,
              IsSuperposed(solved) ? Window() : Window({run.begin_s, run.end_s}));
  AddNumbers(RunNumbers(), solved, run.error_estimate, section);
  const sim::RunEnd end =
      solved.effects ? solved.effects->end.value_or(sim::RunEnd{}) : sim::RunEnd{};
  // whole drive periods after which the end repeats, else the uncertainty of its window
  section.Add(kDrivePeriods, end.drive_periods);
  section.Add({"window_relative_uncertainty"}, end.window_uncertainty);
  // labels are empty where the coil does not warm: the keys remain in JSON
  const bool warms = solved.effects && solved.effects->on[sim::PlaceOf(sim::Effect::kCoilHeating)];
  section.Add({"temperature_rise_k", warms ? "temperature rise of the coil at the end" : "",
               document::kKelvin},
              run.temperature_rise_k);
  section.Add({"temperature_peak_k", warms ? "largest temperature rise of the coil" : "",
               document::kKelvin},
              run.temperature_peak_k);
  section.Add({kErrorEstimate.name}, run.error_estimate);
  section.Add({"known_until_s"}, run.known_until_s);
  const bool is_exact = run.solver_tolerance == 0;
  section.Add({kSolverSteps.name, is_exact ? "" : kSolverSteps.label}, run.work.steps);
  // a tenth of the imbalance: two digits of a quantity that is itself an error
  section.Add(kEnergyImbalance, run.ledger.Imbalance()).resolution =
      std::abs(run.ledger.Imbalance()) / 10;
  section.sections.push_back(EventsTable(run));
  return section;
}

Section PeriodicSection(const SceneAnswer& solved) {
  const bool is_known = solved.effects && solved.effects->periodic;
  Section section{.name = "periodic", .is_known = is_known};
  if (!is_known) return section;
  const sim::PeriodicMotion& motion = *solved.effects->periodic;
  section.Add(kDrivePeriods, motion.drive_periods);
  // magnitude of the largest Floquet multiplier: part of a deviation that remains after a period
  if (motion.multipliers.size() > 0) {
    section.Add({"", "deviation left after each"}, std::abs(motion.multipliers(0))).resolution =
        1e-4;
  }
  // complex numbers as pairs [real, imaginary]
  const std::span all(motion.multipliers.data(),
                      static_cast<std::size_t>(motion.multipliers.size()));
  auto multipliers = Mapped<std::vector<double>>(all, [](const auto& multiplier) {
    return std::vector<double>{multiplier.real(), multiplier.imag()};
  });
  section.Add({"floquet_multipliers"}, std::move(multipliers));
  section.Add({"residual"}, motion.residual);
  return section;
}

// averages over a chaotic motion, with standard uncertainties from batches of periods
Section AverageSection(const SceneAnswer& solved) {
  const bool is_known = solved.effects && solved.effects->chaotic;
  Section section{.name = "average", .is_known = is_known};
  if (!is_known) return section;
  const sim::ChaoticMotion& motion = *solved.effects->chaotic;
  const sim::SceneRun& run = solved.effects->run;
  const Eigen::Index skin = sim::AssembleModel(EffectiveOf(solved).scene).skin();
  // u(rms) = u(mean square) / (2 rms), by the derivative of the root
  const sim::PeriodMeans& uncertain = motion.standard_uncertainties;
  const auto of_rms = [&](double rms, Eigen::Index state) {
    return uncertain.mean_squares(state) / (2 * rms);
  };
  section.Add({kDrivePeriods.name, "drive periods of the averages"}, motion.periods);
  section.Add({"lyapunov_exponent_per_period", "Lyapunov exponent, each period"}, motion.exponent,
              motion.exponent_standard_uncertainty);
  section.Add({"lyapunov_exponent_standard_uncertainty"}, motion.exponent_standard_uncertainty);
  section
      .Add({"skin_rms_standard_uncertainty_m", "skin displacement, uncertainty", document::kMetre},
           of_rms(run.skin_rms_m, skin))
      .resolution = of_rms(run.skin_rms_m, skin) / 10;
  section.Add({"case_rms_standard_uncertainty_m"}, of_rms(run.case_rms_m, sim::LinearModel::kCase));
  section.Add({"power_standard_uncertainty_w"}, uncertain.power_w);
  return section;
}

// --- effects ---

std::string_view NameOf(sim::Ground ground) {
  // in the order of the enumerators
  static constexpr std::array<std::string_view, 6> kNames{"not named",  "named",   "never reached",
                                                          "superposed", "bounded", "kept"};
  return kNames[static_cast<std::size_t>(ground)];
}

std::string GroundText(const sim::EffectVerdict& verdict, const sim::Scene& scene) {
  switch (verdict.ground) {
    case sim::Ground::kNotNamed:
      return "not named in the scene";
    case sim::Ground::kNamed:
      return "named in the scene";
    case sim::Ground::kNeverReached:
      return "never reached, proved between samples too: the motion is the same without it";
    case sim::Ground::kSuperposed:
      return "no limit and no nonlinear spring acts on the motion, so weight changes its centre "
             "only";
    case sim::Ground::kBounded:
      return fmt::format("without it no number changes by more than {:.2g}, a bound",
                         *verdict.change);
    case sim::Ground::kKept:
      break;
  }
  // measured by --explain: relative change of the quantity between two runs
  if (!verdict.change) return "no bound shows that it may be omitted; --explain compares";
  const auto quantity = sim::kAskedQuantityNames[static_cast<std::size_t>(scene.quantity)];
  if (*verdict.change == 0) return fmt::format("without it {} is the same", quantity);
  if (std::isinf(*verdict.change)) return "without it the answer is not known";
  return fmt::format("without it {} changes by {:.2g}{}", quantity, *verdict.change,
                     *verdict.change < scene.tolerance ? ", less than the tolerance" : "");
}

// an object for each effect; in the text a line for those that the scene names, or for all
Section EffectsSection(const SceneAnswer& solved, const std::optional<Explanation>& explanation) {
  // --explain decides on every effect, so its choice replaces that of the run
  const sim::EffectChoice* choice = nullptr;
  if (solved.effects) choice = &*solved.effects;
  if (explanation) choice = &explanation->choice;
  const sim::Scene& scene = solved.scene;
  Section effects{.name = "effects", .is_known = choice != nullptr};
  if (choice == nullptr) return effects;
  effects.heading = fmt::format("effects, for an accuracy of {:g}", scene.tolerance);
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    const sim::EffectVerdict& verdict = choice->verdicts[k];
    // in the text only effects that the scene names, or all of them with --explain
    const bool is_shown = explanation || scene.effects.wishes[k] != sim::Effects{}.wishes[k];
    Section& effect = effects.sections.emplace_back();
    effect.name = sim::kEffectNames[k];
    effect.Add({document::kOn.name, is_shown ? sim::kEffectNames[k] : ""}, verdict.on).note =
        GroundText(verdict, scene);
    effect.Add({"ground"}, NameOf(verdict.ground));
    effect.Add({document::kChange.name}, verdict.change);
  }
  return effects;
}

Section ExplainedTable(const std::optional<Explanation>& explanation) {
  Section table{.name = document::kExplained.name,
                .heading = "each effect forced on and forced off, best time of three runs",
                .shape = Section::Shape::kTable,
                .is_known = explanation.has_value()};
  if (!explanation) return table;
  for (const EffectTrial& trial : explanation->trials) {
    Section& row = table.sections.emplace_back();
    row.Add({"effect", "effect"}, sim::kEffectNames[sim::PlaceOf(trial.effect)]);
    // two digits of the change; times in steps of a microsecond
    row.Add(document::kChange, trial.change).resolution = trial.change / 10;
    row.Add({"with_s", "with it", document::kSecond}, trial.with_s).resolution = 1e-6;
    row.Add({"without_s", "without it", document::kSecond}, trial.without_s).resolution = 1e-6;
  }
  return table;
}

Section AccuraciesTable(const std::optional<Explanation>& explanation) {
  Section table{.name = "accuracies",
                .heading = "what an accuracy costs, best time of three answers",
                .shape = Section::Shape::kTable,
                .is_known = explanation.has_value()};
  if (!explanation) return table;
  for (const AccuracyTrial& trial : explanation->accuracies) {
    Section& row = table.sections.emplace_back();
    row.Add({document::kAccuracy.name, "asked for"}, trial.accuracy);
    row.Add({"answer_s", "time", document::kSecond}, trial.seconds).resolution = 1e-6;
    row.Add(kErrorEstimate, trial.error_estimate).resolution =
        trial.error_estimate.value_or(0) / 10;
    row.Add(kSolverSteps, trial.solver_steps);
  }
  return table;
}

// --- method and files ---

Section MethodSection(const SimulateAnswer& answer) {
  const double error = ErrorOfAll(answer.solved);
  Section section;
  section.Add(document::kMethod, Method(answer.solved));
  section.Add(kErrorEstimate, error).resolution = error / 10;
  section.Add({"trial", "trial"}, document::TextOrNotKnown(answer.trial_path));
  section.Add({"waveforms", "waveforms"}, document::TextOrNotKnown(answer.waveforms_path));
  section.Add(document::kPlot, document::TextOrNotKnown(answer.plot_path));
  return section;
}

// amplitude and frequency of each tone
std::string DriveTonesText(const sim::Drive& drive) {
  std::string text = "tones of ";
  for (std::size_t k = 0; k < drive.tones.size(); ++k) {
    const bool is_last = k + 1 == drive.tones.size();
    if (k > 0) text += is_last ? " and " : ", ";
    text += fmt::format("{:g} V at {:g} Hz", drive.tones[k].amplitude, drive.tones[k].frequency_hz);
  }
  return text;
}

// description of the drive without source resistance and offset
std::string KindPlays(const sim::Drive& drive) {
  const std::string when =
      fmt::format("from {:g} to {:g} s", drive.start_s, sim::EndOfDriveS(drive));
  switch (drive.kind) {
    case sim::DriveKind::kSine:
      return fmt::format("{:g} V at {:g} Hz", drive.amplitude_v, drive.frequency_hz);
    case sim::DriveKind::kTones:
      return DriveTonesText(drive);
    case sim::DriveKind::kBurst:
      return fmt::format("a burst of {:g} V at {:g} Hz {}", drive.amplitude_v, drive.frequency_hz,
                         when);
    case sim::DriveKind::kChirp:
      return fmt::format("a chirp of {:g} V, {:g} to {:g} Hz {}", drive.amplitude_v,
                         drive.frequency_hz, drive.end_frequency_hz, when);
    case sim::DriveKind::kPulse:
      return fmt::format("a pulse of {:g} V {}", drive.amplitude_v, when);
    case sim::DriveKind::kSamples:
      return fmt::format("{} voltages at {:g} Hz, up to {:g} V", drive.samples->voltages_v.size(),
                         drive.samples->rate_hz, sim::LargestVoltageV(drive));
  }
  return {};
}

// with the offset and the source's resistance where there is one
std::string DriveText(const sim::Drive& drive) {
  std::string text = KindPlays(drive);
  if (drive.offset_v != 0) text += fmt::format(" on an offset of {:g} V", drive.offset_v);
  const double source_ohm = drive.source_resistance_ohm;
  return source_ohm == 0 ? text : text + fmt::format(" through {:g} ohm", source_ohm);
}

std::string TitleOf(const SimulateAnswer& answer) {
  const sim::Scene& scene = answer.solved.scene;
  return fmt::format(
      "{}: {}, {}", Printable(answer.scene_path),
      scene.adapter ? "actuator, adapter, skin (7 states)" : "actuator on the skin (5 states)",
      DriveText(scene.drive));
}

}  // namespace

document::Sentence SentenceOf(SimulateFinding kind) {
  using enum SimulateFinding;
  static constexpr document::KindSentence<SimulateFinding> kSentences[] = {
      {kOtherSpringsLinear, "other-springs-linear",
       "springs and dampers without an effect of their own are linear at any travel"},
      {kMoverPreload, "mover-preload",
       "{preload_n} act on the mover, towards the skin positive; positions count from static "
       "equilibrium, where the force holds it {displacement_m} from where its spring is "
       "unloaded[, beyond the {stop} on which it therefore rests]"},
      {kSourceHoldsVoltage, "source-holds-voltage",
       "the source holds its voltage[ ahead of its {source_resistance_ohm}, which power and "
       "phase include], and the coil keeps its resistance"},
      {kOnlyCoilWarms, "only-coil-warms",
       "the source holds its voltage[ ahead of its {source_resistance_ohm}, which power and "
       "phase include], and only the coil warms"},
      {kSteadyNotLinear, "steady-not-linear",
       "the steady motion is not the linear one and is not known; leave out --duration to have "
       "it searched for"},
      {kPeaksAreSums, "peaks-are-sums",
       "travel and force on the skin are upper limits, the sums of the tones' amplitudes: the "
       "tones have no short common period"},
      {kNoWindow, "no-window", "{run_s} are less than ten periods, so there is no window_rms_m"},
      {kChaotic, "chaotic",
       "the motion is chaotic: small deviations grow by {growth} +-{growth_uncertainty} "
       "(logarithm, each period of the drive); RMS values and power are averages over {periods} "
       "periods"},
      {kEndVaries, "end-varies",
       "the run's end does not repeat itself: the RMS over its window has a relative standard "
       "uncertainty of {relative_uncertainty} (standard deviation from window to window)"},
      {kEndNotKnown, "end-not-known",
       "the run's end does not repeat itself, and the run is too short to state what the "
       "uncertainty of its window is"},
      {kKnownUntil, "known-until",
       "the motion is known to {tolerance} until {known_until_s}: small errors grow in it"},
      {kErrorAboveAsked, "error-above-asked",
       "the numbers are known to {relative_error} of themselves, above the required {tolerance}"
       "[; lower the drive's hold_tolerance of {hold_tolerance}]"},
      {kDurationOfDrive, "duration-of-drive",
       "no duration is given: the run lasts {duration_s}, the drive's {drive_s} and "
       "{ring_down_s} in which the slowest motion falls to a thousandth"},
      {kDurationAssumed, "duration-assumed", "no duration is given: files last {duration_s}"},
      {kIdealSensor, "ideal-sensor",
       "the scene has no sensor: the trial is that of an ideal one on the skin at {rate_hz}"},
      {kWaveformsStalled, "waveforms-stalled",
       "waveforms end at {at_s}, where events follow each other without end"},
  };
  return document::SentenceIn(kSentences, kind);
}

document::Section RiseSection(const std::optional<sim::SkinRise>& known) {
  const sim::SkinRise rise = known.value_or(sim::SkinRise{});
  Section section{.name = "rise", .is_known = known.has_value()};
  section.Add(document::kRise, rise.rise_s, rise.uncertainty_s);
  section.Add(document::kRiseAtMost, rise.rise_at_most_s).resolution = rise.uncertainty_s / 10;
  // a latency that is not above its uncertainty is a limit alone
  const bool is_limit = !rise.TellsLatency();
  section.Add(
      {document::kLatency.name, is_limit ? "" : document::kLatency.label, document::kLatency.unit},
      rise.latency_s, rise.uncertainty_s);
  section
      .Add({"latency_below_s", "latency to 10 %, at most", document::kSecond},
           is_limit ? std::optional(rise.LatencyAtMostS()) : std::nullopt)
      .resolution = rise.uncertainty_s / 100;
  section.Add({"standard_uncertainty_s"}, rise.uncertainty_s);
  const sim::Finding verdict{
      Severity::kNote,
      sim::VerdictOf(rise),
      {{"latency_s", rise.latency_s}, {"standard_uncertainty_s", rise.uncertainty_s}}};
  section.Add(document::kVerdict, document::SentenceOf(verdict.kind).kind);
  sim::Findings findings;
  if (known) findings.Add(verdict);
  document::AddFindings(section, findings);
  return section;
}

document::Document SimulateDocument(const SimulateAnswer& answer) {
  const SceneAnswer& solved = answer.solved;
  document::Document document{.verb = "simulate", .title = TitleOf(answer)};
  Section& root = document.root;
  root.sources = {document::DataSource::kSimulated};
  root.Add(document::kScene, answer.scene_path);
  root.sections = {SteadySection(solved),
                   ContactSection(answer),
                   WindowSection(solved),
                   PeriodicSection(solved),
                   AverageSection(solved),
                   RiseSection(answer.numbers.rise),
                   RunSection(solved),
                   EffectsSection(solved, answer.explanation),
                   ExplainedTable(answer.explanation),
                   AccuraciesTable(answer.explanation),
                   MethodSection(answer)};
  if (!answer.panels.empty()) root.figures = {{.caption = "motion", .panels = answer.panels}};
  AddAllFindings(answer, root);
  return document;
}

std::string KindText(sim::DriveKind kind) {
  // kinds without an article: several tones, several samples
  const bool is_plural = kind == sim::DriveKind::kTones || kind == sim::DriveKind::kSamples;
  return fmt::format("{}{}", is_plural ? "" : "a ", Name(kind));
}

}  // namespace haptometer::tools
