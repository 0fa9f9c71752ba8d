#include "tools/tune/tune_document.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "sim/tuning/latency_limit.h"
#include "tools/analyze/analysis_document.h"
#include "tools/cli/json.h"
#include "tools/plot/gnuplot.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

std::string Said(sim::Objective objective, double value) {
  const SpokenUnit spoken = SpokenUnitOf(objective);
  return fmt::format("{:.5f} {}", value * spoken.factor, spoken.unit);
}

// "*" behind a number that one of its bounds holds
const char* Mark(double value, const sim::Range& range) {
  return value == range.lower || value == range.upper ? "*" : "";
}

std::string Adapter(const sim::AdapterPoint& point, const sim::TuningProblem& problem) {
  const sim::Adapter& adapter = point.adapter;
  const sim::AdapterBounds& bounds = problem.bounds;
  const std::string area = problem.fixed_skin
                               ? ""
                               : fmt::format(", contact {:.6g}{} mm2", point.contact_area_m2 * 1e6,
                                             Mark(point.contact_area_m2, bounds.contact_area_m2));
  return fmt::format(
      "motor side {:.6g}{} g, skin side {:.6g}{} g, spring {:.6g}{} N/m, damper {:.6g}{} N s/m{}",
      adapter.motor_side_mass_kg * 1e3, Mark(adapter.motor_side_mass_kg, bounds.motor_side_mass_kg),
      adapter.skin_side_mass_kg * 1e3, Mark(adapter.skin_side_mass_kg, bounds.skin_side_mass_kg),
      adapter.stiffness_n_per_m, Mark(adapter.stiffness_n_per_m, bounds.stiffness_n_per_m),
      adapter.damping_n_s_per_m, Mark(adapter.damping_n_s_per_m, bounds.damping_n_s_per_m), area);
}

// whom the bound of boxes holds for
std::string BoundedText(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  std::string text = "no adapter within the bounds";
  if (!question.springs_n_per_m.empty()) text += " with one of these springs";
  if (std::isfinite(question.problem.mover_limit_m)) text += " that keeps to the travel";
  text += " gives more";
  if (answer.latency && !answer.latency->proved) text += ", whatever its latency";
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

// how far the bound lies above what was found, in percent
std::string GapText(const sim::AdapterOptimum& optimum) {
  return fmt::format("{:.2g} % above", (optimum.upper_bound / optimum.value - 1) * 100);
}

std::string PointsText(const TuneAnswer& answer, std::string_view title,
                       const std::vector<sim::RidgePoint>& points) {
  if (points.empty()) return {};
  std::string text = fmt::format("  {}\n", title);
  for (const sim::RidgePoint& point : points) {
    text += point.value > 0
                ? fmt::format("    {}: {}\n", Adapter(point.point, answer.question.problem),
                              Said(answer.question.objective, point.value))
                : "    none found that keeps to the limit\n";
  }
  return text;
}

// whether a spring that is off breaks the mover's limit, which holds to rounding
bool BreaksLimit(const sim::TuningProblem& problem, double mover_peak_m) {
  constexpr double kRounding = 1e-9;
  return mover_peak_m > problem.mover_limit_m * (1 + kRounding);
}

std::string BeyondText(const sim::TuningProblem& problem, double mover_peak_m) {
  if (!BreaksLimit(problem, mover_peak_m)) return {};
  return fmt::format(", but a mover travel of {:.5f} um, beyond the {:g} um allowed",
                     mover_peak_m * 1e6, problem.mover_limit_m * 1e6);
}

std::string SpringsText(const TuneAnswer& answer) {
  std::string text;
  const double best = answer.optimum.value;
  for (const auto& [spring, mover_peak_m] : answer.springs) {
    const std::string rebalanced =
        spring.rebalanced > 0
            ? fmt::format("{:s} ({:+.3f} %)", Said(answer.question.objective, spring.rebalanced),
                          (spring.rebalanced / best - 1) * 100)
            : "none found that keeps the mover within its travel";
    text += fmt::format(
        "  a spring {:.0f} % too {}: {:s} ({:+.2f} %){}, with the skin side's mass chosen anew "
        "{:s}\n",
        std::abs(spring.factor - 1) * 100, spring.factor < 1 ? "soft" : "stiff",
        Said(answer.question.objective, spring.as_built), (spring.as_built / best - 1) * 100,
        BeyondText(answer.question.problem, mover_peak_m), rebalanced);
  }
  return text;
}

// how sure the answer is where the latency is limited
std::string SearchText(const LatencySearch& search) {
  if (search.proved) {
    return "the latency is that of a simulated run, its standard uncertainty added; the best "
           "adapter "
           "without the limit keeps to it, so that the upper bound is the answer's own";
  }
  return fmt::format(
      "the latency is that of a simulated run, its standard uncertainty added, and was searched, "
      "not proved ({} runs: an even "
      "lattice of all five numbers, and climbs from its best that come up in time and from the "
      "best without the limit): that the adapter keeps to the limit is certain, that no other does "
      "and moves the skin more is not; the upper bound is that without the limit",
      search.runs);
}

ordered_json SearchJson(const TuneAnswer& answer) {
  if (!answer.latency) return nullptr;
  return {{"proved", answer.latency->proved}, {"runs", answer.latency->runs}};
}

// what simulate says of the adapter in a run of that length
std::string RiseText(const TuneAnswer& answer) {
  const double run_s = sim::LatencyRunS(answer.question.problem);
  if (!answer.rise) {
    return fmt::format("  latency            none told: {}\n",
                       NoLatencyText(answer.question.problem, answer.optimum.point));
  }
  const std::optional<double>& limit_s = answer.question.latency_limit_s;
  return fmt::format("  latency to 10 %    {}{}: {} (a run of {:g} s from rest)\n",
                     LatencyText(*answer.rise),
                     limit_s ? fmt::format(", of {:g} ms allowed", *limit_s * 1e3) : "",
                     LatencyVerdict(*answer.rise), run_s);
}

ordered_json RiseJson(const TuneAnswer& answer) {
  if (!answer.rise) return nullptr;
  return {{"run_s", sim::LatencyRunS(answer.question.problem)},
          {"rise_s", cli::NumberOrNull(answer.rise->rise_s)},
          {"rise_at_most_s", cli::NumberOrNull(answer.rise->rise_at_most_s)},
          {"latency_s", answer.rise->latency_s},
          {"latency_below_s", cli::NumberOrNull(LatencyBelowS(*answer.rise))},
          {"standard_uncertainty_s", answer.rise->uncertainty_s},
          {"verdict", LatencyVerdict(*answer.rise)}};
}

ordered_json PointJson(const sim::AdapterPoint& point, const sim::TuningProblem& problem) {
  return {{"motor_side_mass_kg", point.adapter.motor_side_mass_kg},
          {"skin_side_mass_kg", point.adapter.skin_side_mass_kg},
          {"stiffness_n_per_m", point.adapter.stiffness_n_per_m},
          {"damping_n_s_per_m", point.adapter.damping_n_s_per_m},
          {"contact_area_m2",
           problem.fixed_skin ? ordered_json(nullptr) : ordered_json(point.contact_area_m2)}};
}

ordered_json GridJson(const TuneAnswer& answer) {
  if (!answer.grid) return nullptr;
  return {{"values_per_axis", answer.question.grid_values},
          {"points", answer.grid->points},
          {"best", PointJson(answer.grid->point, answer.question.problem)},
          {"skin_rms_m", answer.grid->skin_rms_m}};
}

ordered_json PointsJson(const TuneAnswer& answer, const std::vector<sim::RidgePoint>& points) {
  ordered_json list = ordered_json::array();
  for (const sim::RidgePoint& point : points) {
    const bool found = point.value > 0;
    list.push_back({{"best", found ? PointJson(point.point, answer.question.problem) : nullptr},
                    {"value", found ? cli::NumberOrNull(point.value) : nullptr}});
  }
  return list;
}

ordered_json SpringsJson(const TuneAnswer& answer) {
  ordered_json springs = ordered_json::array();
  for (const auto& [spring, mover_peak_m] : answer.springs) {
    springs.push_back({{"factor", spring.factor},
                       {"value", cli::NumberOrNull(spring.as_built)},
                       {"mover_peak_m", cli::NumberOrNull(mover_peak_m)},
                       {"keeps_mover_limit", !BreaksLimit(answer.question.problem, mover_peak_m)},
                       {"value_with_new_skin_side_mass",
                        spring.rebalanced > 0 ? cli::NumberOrNull(spring.rebalanced) : nullptr}});
  }
  return springs;
}

// whether the objective is the skin_rms_m that is printed beside its bound
bool IsSkinRms(const TuneAnswer& answer) {
  return answer.question.objective == sim::Objective::kSkinRms &&
         answer.question.problem.skin_variation == 0;
}

// what the objective asks of the skins
std::string AskedText(const TuneQuestion& question) {
  if (question.problem.skin_variation == 0) return std::string(sim::Name(question.objective));
  return fmt::format("{} of the skin that moves least, stiffness and damping +-{:g} %",
                     sim::Name(question.objective), question.problem.skin_variation * 100);
}

std::string_view ProofName(sim::Proof proof) {
  switch (proof) {
    case sim::Proof::kBranchAndBound:
      return "branch and bound";
    case sim::Proof::kLimitedTravel:
      return "limited travel";
    case sim::Proof::kMatchedLoad:
      break;
  }
  return "matched load";
}

// what of the scene is not in the numbers
std::string LeftOutText(const TuneQuestion& question) {
  const bool hint = question.has_stops && std::isinf(question.problem.mover_limit_m);
  return fmt::format("{} of the scene left out: check the adapter by simulate{}",
                     fmt::join(question.left_out, ", "),
                     hint ? ", or keep off the stops by --mover-travel" : "");
}

}  // namespace

SpokenUnit SpokenUnitOf(sim::Objective objective) {
  switch (objective) {
    case sim::Objective::kSkinRms:
      return {1e6, "um"};
    case sim::Objective::kStimulus:
      return {1e3, "mm x receptors"};
    case sim::Objective::kSkinPower:
      return {1e3, "mW"};
    case sim::Objective::kRmsPerWatt:
      return {1e6, "um/W"};
  }
  return {1e6, "um"};
}

std::string NoLatencyText(const sim::TuningProblem& problem, const sim::AdapterPoint& point) {
  const double run_s = sim::LatencyRunS(problem);
  if (sim::RunIsTooLong(problem, point)) {
    return fmt::format("a run of {:g} s has too many outputs to be looked at", run_s);
  }
  return fmt::format("in a run of {:g} s its amplitude does not pass from 10 % to 90 %", run_s);
}

std::vector<std::string> TuneAssumptions(const TuneAnswer& answer) {
  std::vector<std::string> assumptions{
      "springs and dampers are linear at any travel: check the mover's against its stops",
      fmt::format("contact is kept whatever the force: it is lost where less than {:.3g} N "
                  "presses actuator and skin together",
                  answer.steady.skin_force_peak_n),
      answer.question.problem.fixed_skin
          ? "the skin is the scene's whatever the contact's area"
          : "the skin follows the thesis's cube root of the contact's area"};
  if (answer.latency) assumptions.push_back(SearchText(*answer.latency));
  if (!answer.question.left_out.empty()) assumptions.push_back(LeftOutText(answer.question));
  return assumptions;
}

std::string TuneText(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  const sim::Objective objective = question.objective;
  std::string text = fmt::format("{}: {:g} V at {:g} Hz, largest {}\n", question.name,
                                 question.problem.drive.amplitude_v,
                                 question.problem.drive.frequency_hz, AskedText(question));
  text += fmt::format("  {} (* at a bound)\n", Adapter(answer.optimum.point, question.problem));
  text +=
      fmt::format("  {:<19}{:s}\n", sim::Name(objective), Said(objective, answer.optimum.value));
  text += fmt::format("  upper bound        {:s} ({:s}): {:s}\n",
                      Said(objective, answer.optimum.upper_bound), GapText(answer.optimum),
                      ProofText(answer));
  text += fmt::format("  any adapter        {:s}: matched load with the lowest dampings\n",
                      Said(objective, answer.matched_load_bound));
  text += fmt::format("  skin displacement  {:.5f} um RMS\n", answer.steady.skin_rms_m * 1e6);
  text += fmt::format(
      "  mover travel    +- {:.5f} um in its case{}\n", answer.steady.mover_peak_m * 1e6,
      std::isinf(question.problem.mover_limit_m)
          ? ""
          : fmt::format(", of {:g} um allowed", question.problem.mover_limit_m * 1e6));
  text += fmt::format("  electrical power   {:.5f} mW, of which into the skin {:.5f} mW\n",
                      answer.steady.power_w * 1e3, answer.skin_power_w * 1e3);
  text += RiseText(answer);
  if (answer.stimulus_m) {
    text += fmt::format("  stimulus           {:.5f} mm x receptors\n", *answer.stimulus_m * 1e3);
  }
  if (answer.grid) {
    text +=
        fmt::format("  best of a grid of {} points: {:.5f} um RMS\n    {}\n", answer.grid->points,
                    answer.grid->skin_rms_m * 1e6, Adapter(answer.grid->point, question.problem));
  }
  text += PointsText(answer, "the best with each spring", answer.listed);
  text += PointsText(answer, "the ridge: best with a given mass on the motor's side", answer.ridge);
  text += SpringsText(answer);
  for (const std::string& assumption : TuneAssumptions(answer)) {
    text += fmt::format("  assumed: {}\n", assumption);
  }
  return text;
}

std::string TuneJson(const TuneAnswer& answer) {
  const TuneQuestion& question = answer.question;
  const sim::AdapterOptimum& optimum = answer.optimum;
  const ordered_json document{
      {"scene", question.name},
      {"best", PointJson(optimum.point, question.problem)},
      {"skin_rms_m", cli::NumberOrNull(answer.steady.skin_rms_m)},
      {"upper_bound_m",
       IsSkinRms(answer) ? cli::NumberOrNull(optimum.upper_bound) : ordered_json(nullptr)},
      {"objective",
       {{"name", sim::Name(question.objective)},
        {"unit", sim::UnitOf(question.objective)},
        {"skin_variation", question.problem.skin_variation},
        {"value", cli::NumberOrNull(optimum.value)},
        {"upper_bound", cli::NumberOrNull(optimum.upper_bound)},
        {"matched_load_bound", cli::NumberOrNull(answer.matched_load_bound)},
        {"proof", ProofName(optimum.proof)},
        {"boxes", optimum.boxes}}},
      {"mover_peak_m", cli::NumberOrNull(answer.steady.mover_peak_m)},
      {"mover_limit_m", cli::NumberOrNull(question.problem.mover_limit_m)},
      {"rise", RiseJson(answer)},
      {"latency_limit_s", cli::NumberOrNull(question.latency_limit_s)},
      {"latency_search", SearchJson(answer)},
      {"skin_force_peak_n", cli::NumberOrNull(answer.steady.skin_force_peak_n)},
      {"power_w", cli::NumberOrNull(answer.steady.power_w)},
      {"skin_power_w", cli::NumberOrNull(answer.skin_power_w)},
      {"stimulus_m", cli::NumberOrNull(answer.stimulus_m)},
      {"grid", GridJson(answer)},
      {"ridge", PointsJson(answer, answer.ridge)},
      {"springs", PointsJson(answer, answer.listed)},
      {"spring_off", SpringsJson(answer)},
      {"assumptions", TuneAssumptions(answer)}};
  return cli::JsonText(document);
}

namespace {

constexpr std::size_t kFactors = 121;
constexpr std::size_t kRidgeMasses = 41;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Number {
  const char* name;
  plot::Colour colour;
};
// apart in grey too (Okabe and Ito, 2008)
constexpr std::array<Number, 5> kNumbers{{{"motor side's mass", plot::kBlue},
                                          {"skin side's mass", plot::kOrange},
                                          {"spring", plot::kGreen},
                                          {"damper", plot::kPurple},
                                          {"contact's area", plot::kYellow}}};
constexpr std::size_t kSpring = 2, kArea = 4;

double& PartOf(sim::AdapterPoint& point, std::size_t number) {
  switch (number) {
    case 0:
      return point.adapter.motor_side_mass_kg;
    case 1:
      return point.adapter.skin_side_mass_kg;
    case kSpring:
      return point.adapter.stiffness_n_per_m;
    case 3:
      return point.adapter.damping_n_s_per_m;
    default:
      return point.contact_area_m2;
  }
}

std::vector<double> Factors() { return sim::EqualSteps({.lower = 0.7, .upper = 1.3}, kFactors); }

// a curve for each number; value(point) at the optimum with one number times a factor
template <typename Value>
std::vector<plot::Series> AroundOptimum(const TuneAnswer& answer, const Value& value) {
  std::vector<plot::Series> curves;
  for (std::size_t number = 0; number < kNumbers.size(); ++number) {
    if (number == kArea && answer.question.problem.fixed_skin) continue;
    plot::Series curve{.title = kNumbers[number].name,
                       .style = plot::Lines(kNumbers[number].colour, 1.5),
                       .x = Factors(),
                       .y = {}};
    for (const double factor : curve.x) {
      sim::AdapterPoint point = answer.optimum.point;
      PartOf(point, number) *= factor;
      // the skin's law holds for these areas
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
  plot::Series curve{.title = "spring, the skin side's mass chosen anew",
                     .style = plot::Lines(kNumbers[kSpring].colour, 1.5, 2),
                     .x = Factors(),
                     .y = {}};
  for (const double factor : curve.x) {
    const sim::SpringCost cost = sim::CostOfSpring(
        question.objective, question.problem, question.receptors, answer.optimum.point, factor);
    curve.y.push_back(
        cost.rebalanced > 0 ? cost.rebalanced * SpokenUnitOf(question.objective).factor : kNaN);
  }
  return curve;
}

std::string ObjectiveLabel(const TuneQuestion& question) {
  return fmt::format("{} / {}", sim::Name(question.objective),
                     SpokenUnitOf(question.objective).unit);
}

plot::Panel ObjectivePanel(const TuneAnswer& answer, const sim::MotorSource& source) {
  const TuneQuestion& question = answer.question;
  plot::Panel panel{.title = fmt::format("{}: around the optimum", question.name),
                    .x_label = "one number / its best",
                    .y_label = ObjectiveLabel(question),
                    .series = AroundOptimum(answer, [&](const sim::AdapterPoint& point) {
                      return sim::ValueOf(question.objective, question.problem, source,
                                          question.receptors, point) *
                             SpokenUnitOf(question.objective).factor;
                    })};
  panel.series.push_back(Rebalanced(answer));
  return panel;
}

plot::Panel TravelPanel(const TuneAnswer& answer, const sim::MotorSource& source) {
  const sim::TuningProblem& problem = answer.question.problem;
  plot::Panel panel{.title = "",
                    .x_label = "one number / its best",
                    .y_label = "mover travel / um",
                    .series = AroundOptimum(answer, [&](const sim::AdapterPoint& point) {
                      const sim::Skin skin = sim::SkinOf(problem, point.contact_area_m2);
                      const sim::AdapterMotion motion = sim::MotionOf(source, point.adapter, skin);
                      return sim::MoverTravel(source, motion.case_m) * 1e6;
                    })};
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
  plot::Series ridge{
      .title = "the best with that mass", .style = plot::Lines(plot::kBlue, 1.5), .x = {}, .y = {}};
  for (const sim::RidgePoint& point :
       sim::RidgeOf(question.objective, question.problem, question.receptors, kRidgeMasses)) {
    ridge.x.push_back(point.point.adapter.motor_side_mass_kg * 1e3);
    ridge.y.push_back(point.value * SpokenUnitOf(question.objective).factor);
  }
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

}  // namespace

Result<void> DrawTune(const std::string& path, const TuneAnswer& answer) {
  const sim::TuningProblem& problem = answer.question.problem;
  const sim::MotorSource source = sim::SourceOf(problem.actuator, problem.drive);
  std::vector<plot::Panel> panels{ObjectivePanel(answer, source), TravelPanel(answer, source)};
  if (!answer.ridge.empty()) panels.push_back(RidgePanel(answer));
  return plot::DrawPanels(path, panels);
}

}  // namespace haptometer::tools
