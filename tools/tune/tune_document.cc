#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "sim/tuning/latency_limit.h"
#include "tools/document/keys.h"
#include "tools/simulate/simulate_document.h"
#include "tools/tune/tune.h"

namespace haptometer::tools {
namespace {

using document::Detail;
using document::Item;
using document::Key;
using document::Section;
using document::Unit;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Unit ObjectiveUnit(sim::Objective objective) {
  switch (objective) {
    case sim::Objective::kStimulus:
      // RMS of the skin times the number of receptive fields (thesis, equation 2.7)
      return {"_m", "m", {{{1e3, "mm x receptors"}}}};
    case sim::Objective::kSkinPower:
      return document::kWatt;
    case sim::Objective::kRmsPerWatt:
      return document::kMetrePerWatt;
    case sim::Objective::kSkinRms:
      break;
  }
  return document::kMetre;
}

// the objective as it is shown; --objective and JSON have its name
std::string_view LabelOf(sim::Objective objective) {
  switch (objective) {
    case sim::Objective::kStimulus:
      return "stimulus";
    case sim::Objective::kSkinPower:
      return "power in the skin";
    case sim::Objective::kRmsPerWatt:
      return "skin displacement (RMS) per electrical power";
    case sim::Objective::kSkinRms:
      break;
  }
  return "skin displacement (RMS)";
}

// --- findings ---

// a run too long to simulate, or a run whose rise determines no latency
sim::Finding NoLatency(const sim::TuningProblem& problem, const sim::AdapterPoint& point) {
  using enum sim::FindingKind;
  return {.severity = Severity::kDoubt,
          .kind = sim::RunIsTooLong(problem, point) ? kRunTooLong : kNoRise,
          .numbers = {{"run_s", sim::LatencyRunS(problem)}}};
}

// the law of the skin in place of the scene's own: the answer is of another skin than simulate's
void DoubtSkin(const TuneAnswer& answer, Section& root) {
  constexpr double kSameSkin = 0.01;  // relative; a hundredth of Ks moves the skin's RMS by less
  const std::optional<sim::Skin>& stated = answer.question.scene_skin;
  if (!stated) return;
  const double area_m2 = answer.optimum.point.contact_area_m2;
  const sim::Skin used = sim::SkinOf(answer.question.problem, area_m2);
  const auto is_same = [](double one, double other) {
    return std::abs(one - other) <= kSameSkin * std::abs(other);
  };
  if (is_same(used.stiffness_n_per_m, stated->stiffness_n_per_m) &&
      is_same(used.damping_n_s_per_m, stated->damping_n_s_per_m)) {
    return;
  }
  root.Find(
      Severity::kDoubt, "scene-skin-unused",
      "the scene's skin of {stiffness_n_per_m} and {damping_n_s_per_m} is not used: the "
      "thesis's law gives {law_stiffness_n_per_m} and {law_damping_n_s_per_m} at the answer's "
      "area; --skin scene takes the scene's",
      {{"stiffness_n_per_m", stated->stiffness_n_per_m},
       {"damping_n_s_per_m", stated->damping_n_s_per_m},
       {"law_stiffness_n_per_m", used.stiffness_n_per_m},
       {"law_damping_n_s_per_m", used.damping_n_s_per_m}});
}

// assumptions of the numbers: skin, latency and omitted effects
void AddTuneFindings(const TuneAnswer& answer, Section& root) {
  const TuneQuestion& question = answer.question;
  const auto note = [&root](std::string_view kind, std::string_view text,
                            std::vector<FindingNumber> numbers = {}) {
    root.Find(Severity::kNote, kind, text, std::move(numbers));
  };
  if (question.problem.fixed_skin) {
    note("skin-given", "the skin is the scene's for any contact area");
  } else {
    note("skin-of-area", "the skin follows the thesis's cube root of the contact's area");
  }
  if (answer.latency && answer.latency->proved) {
    note("latency-proved",
         "the latency is that of a simulated run, its standard uncertainty added; the best "
         "adapter without the limit keeps to it, so that the upper bound is the answer's own");
  }
  if (answer.latency && !answer.latency->proved) {
    note("latency-searched",
         "the latency is that of a simulated run, its standard uncertainty added, and was "
         "searched, not proved ({runs} runs: an even lattice of all five numbers, and climbs from "
         "its best that keep to the limit and from the best without it): the adapter keeps to the "
         "limit; another that does may move the skin more; the upper bound is that without the "
         "limit",
         {{"runs", answer.latency->runs}});
  }
  // effects of the scene that tuning does not include: its model is linear and steady
  if (question.left_out.empty()) return;
  note("effects-left-out",
       "the numbers are without these effects of the scene: {effects}; check the adapter by "
       "simulate",
       {{"effects", fmt::format("{}", fmt::join(question.left_out, ", "))}});
  if (question.has_stops && std::isinf(question.problem.mover_limit_m)) {
    note("stops-left-out", "the stops are not modelled: limit the travel with --mover-travel");
  }
}

// findings of every scene (linear springs, kept contact), and of the rise
sim::Findings SimFindingsOf(const TuneAnswer& answer) {
  sim::Findings findings;
  // steady phasors assume linear springs and a contact that is kept
  findings.Note(sim::FindingKind::kLinearSprings);
  findings.Note(sim::FindingKind::kContactKept,
                {{"least_force_n", answer.steady.skin_force_peak_n}});
  if (!answer.rise) findings.Add(NoLatency(answer.question.problem, answer.optimum.point));
  return findings;
}

// --- the proof ---

// the adapters that the bound of branch and bound holds for
std::string BoundedText(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  std::string text = "no adapter within the bounds";
  if (!question.springs_n_per_m.empty()) text += " with one of these springs";
  if (std::isfinite(question.problem.mover_limit_m)) text += " that keeps to the travel";
  text += " gives more";
  if (answer.latency && !answer.latency->proved) text += ", of any latency";
  return text;
}

std::string ProofText(const TuneAnswer& answer) {
  switch (answer.optimum.proof) {
    case sim::Proof::kBranchAndBound:
      return fmt::format("{} ({} boxes)", BoundedText(answer), answer.optimum.boxes);
    case sim::Proof::kLimitedTravel:
      return "no adapter at all gives more (the coil's work over that travel)";
    case sim::Proof::kMatchedLoad:
      break;
  }
  return "no adapter at all gives more (matched load)";
}

std::string_view ProofName(sim::Proof proof) {
  // in the order of the enumerators
  static constexpr std::array<std::string_view, 3> kNames{"branch and bound", "matched load",
                                                          "limited travel"};
  return kNames[static_cast<std::size_t>(proof)];
}

// --- sections ---

Section AdapterSection(const sim::AdapterPoint& point, const sim::TuningProblem& problem) {
  Section best{.name = document::kBest.name};
  const auto add = [&best](const Key& key, double value, const sim::Range& range) {
    // a value at a bound: more may be possible beyond it
    Item& item = best.Add(key, value);
    if (value == range.lower || value == range.upper) item.note = "at a bound";
  };
  const sim::Adapter& adapter = point.adapter;
  const sim::AdapterBounds& bounds = problem.bounds;
  add({"motor_side_mass_kg", "mass on the motor's side", document::kKilogram},
      adapter.motor_side_mass_kg, bounds.motor_side_mass_kg);
  add({"skin_side_mass_kg", "mass on the skin's side", document::kKilogram},
      adapter.skin_side_mass_kg, bounds.skin_side_mass_kg);
  add({"stiffness_n_per_m", "spring", document::kNewtonPerMetre}, adapter.stiffness_n_per_m,
      bounds.stiffness_n_per_m);
  add({"damping_n_s_per_m", "damper", document::kNewtonSecondPerMetre}, adapter.damping_n_s_per_m,
      bounds.damping_n_s_per_m);
  add({document::kContactArea.name, "contact's area", document::kSquareMetre},
      // with the scene's skin the area has no influence
      problem.fixed_skin ? kNaN : point.contact_area_m2, bounds.contact_area_m2);
  return best;
}

Section ObjectiveSection(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  const sim::AdapterOptimum& optimum = answer.optimum;
  const Unit unit = ObjectiveUnit(question.objective);
  Section objective{.name = "objective"};
  objective.Add(document::kName, sim::Name(question.objective));
  objective.Add(document::kUnit, sim::UnitOf(question.objective));
  objective.Add({"skin_variation"}, question.problem.skin_variation);
  objective.Add({document::kValue.name, "largest value", unit}, optimum.value);
  // gap between answer and proved bound, in percent of the answer
  objective.Add({"upper_bound", "upper bound", unit}, optimum.upper_bound).note = fmt::format(
      "{:.2g} % above: {}", (optimum.upper_bound / optimum.value - 1) * 100, ProofText(answer));
  // bound of the matched load for any adapter (docs/explanation/notation.md)
  objective.Add({"matched_load_bound", "any adapter", unit}, answer.matched_load_bound).note =
      "matched load with the lowest dampings";
  objective.Add({"proof"}, ProofName(optimum.proof));
  objective.Add({"boxes"}, optimum.boxes);
  return objective;
}

Section MotionSection(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  const sim::SteadyState& steady = answer.steady;
  const double limit_m = question.problem.mover_limit_m;
  // an upper bound of the RMS exists only where the RMS was maximised
  const bool is_bound =
      question.objective == sim::Objective::kSkinRms && question.problem.skin_variation == 0;
  Section motion;
  motion.Add(document::kSkinRms, steady.skin_rms_m);
  motion.Add({"upper_bound_m"}, is_bound ? answer.optimum.upper_bound : kNaN);
  motion.Add(document::kMoverPeak, steady.mover_peak_m).note = "in its case";
  motion.Add({"mover_limit_m", "allowed", document::kMetre}, limit_m);
  motion.Add({document::kSkinForcePeak.name}, steady.skin_force_peak_n);
  motion.Add(document::kPower, steady.power_w);
  motion.Add({"skin_power_w", "of which into the skin", document::kWatt}, answer.skin_power_w);
  motion.Add({"stimulus_m", "stimulus", ObjectiveUnit(sim::Objective::kStimulus)},
             answer.stimulus_m);
  return motion;
}

// rise of the skin with this adapter, as simulate computes it from a run of that length
Section RiseOfRun(const TuneAnswer& answer) {
  Section rise = RiseSection(answer.rise);
  rise.Add({"run_s", "in a run from rest of", document::kSecond},
           sim::LatencyRunS(answer.question.problem));
  return rise;
}

Section SearchSection(const TuneAnswer& answer) {
  Section section;
  // proved: the optimum without the limit keeps to it; otherwise a search
  section.Add({"latency_limit_s", "latency allowed", document::kSecond},
              answer.question.latency_limit_s);
  Section search{.name = "latency_search", .is_known = answer.latency.has_value()};
  search.Add({"proved"}, answer.latency && answer.latency->proved);
  search.Add({"runs"}, answer.latency ? answer.latency->runs : 0);
  section.sections.push_back(std::move(search));
  return section;
}

Section GridSection(const TuneAnswer& answer) {
  const sim::GridBest best = answer.grid.value_or(sim::GridBest{});
  Section grid{.name = "grid",
               // independent check of the optimum: best of a uniform grid over all numbers
               .heading = "best of a grid",
               .detail = Detail::kAll,
               .is_known = answer.grid.has_value()};
  grid.Add({"values_per_axis", "values an axis"}, answer.question.grid_values);
  grid.Add(document::kPoints, best.points);
  grid.Add(document::kSkinRms, best.skin_rms_m);
  grid.sections.push_back(AdapterSection(best.point, answer.question.problem));
  return grid;
}

// the best adapters of a list, with the objective of each
Section PointList(const TuneAnswer& answer, const std::vector<sim::RidgePoint>& points,
                  const document::Key& key, Detail detail) {
  const sim::Objective objective = answer.question.objective;
  Section list{.name = key.name,
               .heading = std::string(key.label),
               .shape = Section::Shape::kTable,
               .detail = detail};
  for (const sim::RidgePoint& point : points) {
    // value 0: no adapter was found for this row
    const bool is_found = point.value > 0;
    Section& row = list.sections.emplace_back();
    row.Add({document::kValue.name, LabelOf(objective), ObjectiveUnit(objective)},
            is_found ? point.value : kNaN);
    row.sections.push_back(AdapterSection(point.point, answer.question.problem));
    row.sections.back().is_known = is_found;
  }
  return list;
}

Section WrongSprings(const TuneAnswer& answer) {
  const Unit unit = ObjectiveUnit(answer.question.objective);
  // the limit with a margin for rounding
  const double limit_m = answer.question.problem.mover_limit_m * (1 + 1e-9);
  Section list{.name = "spring_off",
               .heading = "a spring that is off",
               .shape = Section::Shape::kTable,
               .detail = Detail::kAll};
  for (const auto& [spring, mover_peak_m] : answer.springs) {
    Section& row = list.sections.emplace_back();
    row.Add({"factor", "of the best", document::kShare}, spring.factor);
    // the objective with the spring alone changed, then with Ma2 optimised again
    row.Add({document::kValue.name, LabelOf(answer.question.objective), unit}, spring.as_built);
    row.Add({"", "change", document::kShare}, spring.as_built / answer.optimum.value - 1);
    row.Add({"value_with_new_skin_side_mass", "skin side's mass optimised again", unit},
            spring.rebalanced > 0 ? spring.rebalanced : kNaN);
    row.Add(document::kMoverPeak, mover_peak_m);
    row.Add({"keeps_mover_limit", "keeps to the travel"}, mover_peak_m <= limit_m);
  }
  return list;
}

// --- figures ---

document::SpokenUnit SpokenOf(sim::Objective objective) {
  return ObjectiveUnit(objective).spoken[0];
}

constexpr std::size_t kFactors = 121;
constexpr std::size_t kRidgeMasses = 41;

// a number of the adapter, distinguishable in grey too (Okabe and Ito, 2008)
struct Number {
  const char* name;
  plot::Colour colour;
  double& (*of)(sim::AdapterPoint& point);
};
using Point = sim::AdapterPoint;
constexpr std::array<Number, 5> kNumbers{
    {{"motor side's mass", plot::kBlue,
      [](Point& at) -> double& { return at.adapter.motor_side_mass_kg; }},
     {"skin side's mass", plot::kOrange,
      [](Point& at) -> double& { return at.adapter.skin_side_mass_kg; }},
     {"spring", plot::kGreen, [](Point& at) -> double& { return at.adapter.stiffness_n_per_m; }},
     {"damper", plot::kPurple, [](Point& at) -> double& { return at.adapter.damping_n_s_per_m; }},
     {"contact's area", plot::kYellow, [](Point& at) -> double& { return at.contact_area_m2; }}}};
constexpr std::size_t kSpring = 2, kArea = 4;

// factors 0.7 to 1.3: +-30 % around the optimum
std::vector<double> Factors() { return sim::EqualSteps({.lower = 0.7, .upper = 1.3}, kFactors); }

// a curve for each number: value(point) at the optimum with that number times a factor
template <typename Value>
std::vector<plot::Series> AroundOptimum(const TuneAnswer& answer, const Value& value) {
  std::vector<plot::Series> curves;
  for (std::size_t number = 0; number < kNumbers.size(); ++number) {
    // with the scene's skin the objective has no dependence on the area
    if (number == kArea && answer.question.problem.fixed_skin) continue;
    plot::Series curve{.title = kNumbers[number].name,
                       .style = plot::Lines(kNumbers[number].colour, 1.5),
                       .x = Factors()};
    for (const double factor : curve.x) {
      sim::AdapterPoint point = answer.optimum.point;
      kNumbers[number].of(point) *= factor;
      // outside of these areas the skin's law does not hold
      const bool known = number != kArea || (point.contact_area_m2 >= sim::kSkinAreaMinM2 &&
                                             point.contact_area_m2 <= sim::kSkinAreaMaxM2);
      curve.y.push_back(known ? value(point) : kNaN);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

plot::Series Rebalanced(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  plot::Series curve{.title = "spring, mass optimised again",
                     .style = plot::Lines(kNumbers[kSpring].colour, 1.5, 2),
                     .x = Factors()};
  // each point is a maximisation over Ma2 at a fixed spring
  for (const double factor : curve.x) {
    const sim::SpringCost cost = sim::CostOfSpring(
        question.objective, question.problem, question.receptors, answer.optimum.point, factor);
    curve.y.push_back(cost.rebalanced > 0 ? cost.rebalanced * SpokenOf(question.objective).factor
                                          : kNaN);
  }
  return curve;
}

std::string ObjectiveLabel(const TuneQuestion& question) {
  return fmt::format("{} / {}", LabelOf(question.objective), SpokenOf(question.objective).symbol);
}

plot::Panel ObjectivePanel(const TuneAnswer& answer, const sim::MotorSource& source) {
  const TuneQuestion& question = answer.question;
  plot::Panel panel{.title = fmt::format("{}: around the optimum", question.name),
                    .x_label = "number relative to its optimum",
                    .y_label = ObjectiveLabel(question),
                    .series = AroundOptimum(answer, [&](const sim::AdapterPoint& point) {
                      return sim::ValueOf(question.objective, question.problem, source,
                                          question.receptors, point) *
                             SpokenOf(question.objective).factor;
                    })};
  panel.series.push_back(Rebalanced(answer));
  return panel;
}

plot::Panel TravelPanel(const TuneAnswer& answer, const sim::MotorSource& source) {
  const sim::TuningProblem& problem = answer.question.problem;
  plot::Panel panel{.title = "",
                    .x_label = "number relative to its optimum",
                    .y_label = "mover travel / um",
                    .series = AroundOptimum(answer, [&](const sim::AdapterPoint& point) {
                      // travel of the mover in its case from the motion of the case, peak in um
                      const sim::Skin skin = sim::SkinOf(problem, point.contact_area_m2);
                      const sim::AdapterMotion motion = sim::MotionOf(source, point.adapter, skin);
                      return sim::MoverTravel(source, motion.case_m) * 1e6;
                    })};
  // an infinite limit has no line
  if (std::isinf(problem.mover_limit_m)) return panel;
  const double limit_um = problem.mover_limit_m * 1e6;
  panel.series.push_back({.title = "allowed",
                          .style = plot::Lines(plot::kGrey, 2),
                          .x = {0.7, 1.3},
                          .y = {limit_um, limit_um}});
  return panel;
}

plot::Panel RidgePanel(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  plot::Series ridge{.title = "the best with that mass", .style = plot::Lines(plot::kBlue, 1.5)};
  for (const sim::RidgePoint& point :
       sim::RidgeOf(question.objective, question.problem, question.receptors, kRidgeMasses)) {
    ridge.x.push_back(point.point.adapter.motor_side_mass_kg * 1e3);
    ridge.y.push_back(point.value * SpokenOf(question.objective).factor);
  }
  // how flat the ridge is: best over least value, in percent
  const auto [least, most] = std::ranges::minmax_element(ridge.y);
  const std::string title = ridge.y.empty()
                                ? "the ridge"
                                : fmt::format("the ridge: its best is {:.3g} % above its least",
                                              (*most / *least - 1) * 100);
  return {.title = title,
          .x_label = "mass on the motor's side / g",
          .y_label = ObjectiveLabel(question),
          .series = {std::move(ridge)}};
}

std::vector<plot::Panel> PanelsOf(const TuneAnswer& answer) {
  const sim::TuningProblem& problem = answer.question.problem;
  // force Fc behind a stiffness kc, the same for all adapters
  const sim::MotorSource source = sim::SourceOf(problem.actuator, problem.drive);
  std::vector<plot::Panel> panels{ObjectivePanel(answer, source), TravelPanel(answer, source)};
  if (!answer.ridge.empty()) panels.push_back(RidgePanel(answer));
  return panels;
}

// with a varied skin the least favourable skin is maximised
std::string TitleOf(const TuneQuestion& question) {
  std::string title = fmt::format("{}: {:g} V at {:g} Hz, largest {}", question.name,
                                  question.problem.drive.amplitude_v,
                                  question.problem.drive.frequency_hz, LabelOf(question.objective));
  if (question.problem.skin_variation == 0) return title;
  return title + fmt::format(" of the skin that moves least, stiffness and damping +-{:g} %",
                             question.problem.skin_variation * 100);
}

}  // namespace

std::string NoLatencyText(const sim::TuningProblem& problem, const sim::AdapterPoint& point) {
  return document::WordsOf(NoLatency(problem, point));
}

document::Document TuneDocument(const TuneAnswer& answer, bool has_figures) {
  const TuneQuestion& question = answer.question;
  document::Document document{.verb = "tune", .title = TitleOf(question)};
  Section& root = document.root;
  root.sources = {document::DataSource::kSimulated};
  root.Add(document::kScene, question.name);
  root.sections = {
      AdapterSection(answer.optimum.point, question.problem),
      ObjectiveSection(answer),
      MotionSection(answer),
      RiseOfRun(answer),
      SearchSection(answer),
      PointList(answer, answer.listed, {"springs", "the best with each spring"}, Detail::kShort),
      GridSection(answer),
      PointList(answer, answer.ridge,
                {"ridge", "the ridge: best with a given mass on the motor's side"}, Detail::kAll),
      WrongSprings(answer)};
  if (has_figures)
    root.figures = {{.caption = "Around the optimum: each number of the adapter alone is changed. "
                                "Dashed: the spring is changed, and the skin side's mass is "
                                "optimised again.",
                     .panels = PanelsOf(answer)}};
  document::AddFindings(root, SimFindingsOf(answer));
  DoubtSkin(answer, root);
  AddTuneFindings(answer, root);
  return document;
}

}  // namespace haptometer::tools
