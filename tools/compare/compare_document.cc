#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/mapped.h"
#include "dsp/statistics/distributions.h"
#include "tools/compare/compare.h"
#include "tools/document/keys.h"

namespace haptometer::tools {
namespace {

using document::Section;

constexpr double kScoreStep = 0.01;  // of a score: its last digit that is shown
// by Compared, below a figure
constexpr std::array<std::string_view, kComparedCount> kShortNames{"RMS",     "tone",  "rise",
                                                                   "current", "power", "phase"};
constexpr double kNotSearched = std::numeric_limits<double>::quiet_NaN();
constexpr double kCoverage = 2;  // k of the intervals

std::string KeysOf(const ComparedScene& scene, const std::vector<std::size_t>& places) {
  return fmt::format(
      "{}", fmt::join(Mapped(places, [&](std::size_t k) { return scene.inputs()[k].key; }), ", "));
}

std::string LabelsOf(const std::vector<Compared>& quantities, sim::SensorTarget target) {
  return fmt::format(
      "{}",
      fmt::join(Mapped(quantities, [&](Compared one) { return KeyOf(one, target).label; }), ", "));
}

// --- tables ---

Section QuantityRow(const ComparedQuantity& one, sim::SensorTarget target) {
  const document::Key key = KeyOf(one.quantity, target);
  Section row;
  row.Add({"", "quantity"}, key.label);
  row.Add(document::kKey, key.name);
  row.Add({document::kMeasured.name, "measured", key.unit}, one.measured.value,
          one.measured.uncertainty);
  row.Add({"simulated", "simulated", key.unit}, one.simulated.value, one.simulated.uncertainty);
  row.Add({"measured_uncertainty"}, one.measured.uncertainty);
  row.Add({"simulated_uncertainty"}, one.simulated.uncertainty);
  row.Add({document::kDeviation.name, "deviation", key.unit}, one.deviation,
          one.deviation_uncertainty);
  row.Add({"zeta_score", "zeta"}, one.Zeta()).resolution = kScoreStep;
  row.Add({"normalized_error", "E_n"}, one.NormalizedError()).resolution = kScoreStep;
  // two digits of what could have been seen
  const double least = kCoverage * one.deviation_uncertainty;
  row.Add({"smallest_deviation", "would be seen from", key.unit}, least).resolution =
      std::pow(10, std::floor(std::log10(least)) - 1);
  return row;
}

// the inputs in their sets, then those without influence
Section InputsSection(const ComparedScene& scene, const ComparisonResult& result) {
  Section table{.name = document::kInputs.name,
                .heading = "inputs, ordered by pull",
                .shape = Section::Shape::kTable};
  const Agreement& agreement = result.agreement;
  const auto add = [&](std::size_t place, std::optional<std::size_t> set) {
    const ComparedInput& input = scene.inputs()[place];
    const auto j = static_cast<Eigen::Index>(place);
    const document::Unit unit = document::UnitOfName(input.key);
    const double u = input.value.standard_uncertainty;
    Section& row = table.sections.emplace_back();
    row.Add({document::kKey.name, "input"}, input.key);
    row.Add({document::kValue.name, "value", unit}, input.value.value, u);
    row.Add(document::kStandardUncertainty, u);
    row.Add({"pull", "pull"}, set ? document::Value(agreement.pull(j)) : document::Value())
        .resolution = kScoreStep;
    // the variance that is left: u^2 (1 - P_jj)
    const double left = std::sqrt(std::max(0.0, 1 - agreement.explained(j)));
    row.Add({"adjusted", "adjusted", unit}, input.value.value + u * agreement.adjustment(j),
            u * left);
    row.Add({"adjusted_uncertainty"}, u * left);
    const double z = result.explaining.empty() ? kNotSearched : result.explaining[place];
    // of an actuator by a factor, as ComparedScene::At changes it
    const double explaining = input.symbol ? input.value.value * std::exp(z * u / input.value.value)
                                           : input.value.value + z * u;
    row.Add({"explaining_value", "explains most at", unit}, explaining);
    row.Add({"set", "set"}, set ? document::Value(*set + 1) : document::Value());
  };
  for (std::size_t set = 0; set < result.sets.size(); ++set) {
    for (const std::size_t place : result.sets[set]) add(place, set);
  }
  for (std::size_t place = 0; place < scene.inputs().size(); ++place) {
    const auto j = static_cast<Eigen::Index>(place);
    if (!std::isfinite(agreement.pull(j))) add(place, std::nullopt);
  }
  return table;
}

// --- findings ---

// sets of inputs of which one alone leaves no more than chance of chi^2
std::vector<std::string> CausesOf(const ComparedScene& scene, const ComparisonResult& result) {
  const Agreement& agreement = result.agreement;
  const auto freedom = static_cast<double>(result.quantities.size()) - 1;
  // with one quantity nothing but rounding is left
  const double most =
      freedom > 0 ? dsp::ChiSquareQuantile(kTogether, freedom) : 1e-9 * agreement.chi_squared;
  const auto is_cause = [&](std::size_t place) {
    const double pull = agreement.pull(static_cast<Eigen::Index>(place));
    return std::abs(pull) >= kPullOfCause && agreement.chi_squared - pull * pull <= most;
  };
  std::vector<std::string> causes;
  for (std::vector<std::size_t> set : result.sets) {
    std::erase_if(set, [&](std::size_t place) { return !is_cause(place); });
    if (set.empty()) continue;
    causes.push_back(set.size() == 1 ? KeysOf(scene, set)
                                     : fmt::format("one of {}, which cannot be distinguished",
                                                   KeysOf(scene, set)));
  }
  return causes;
}

void FindDifference(const ComparedScene& scene, const ComparisonResult& result, Section& root) {
  if (!result.Differs() && !result.DiffersTogether()) return;
  std::vector<Compared> differing;
  for (const ComparedQuantity& one : result.quantities) {
    if (std::abs(one.NormalizedError()) > 1) differing.push_back(one.quantity);
  }
  if (result.Differs()) {
    root.Find(Severity::kDoubt, "differs",
              "measured and simulated differ by more than their expanded uncertainties: "
              "{quantities}",
              {{"quantities", LabelsOf(differing, result.target)}});
  } else {
    root.Find(Severity::kDoubt, "differs-together",
              "each quantity agrees, but not all together: chi squared is {chi_squared}, which "
              "chance exceeds in 1 % of comparisons",
              {{"chi_squared", result.agreement.chi_squared}});
  }
  const std::vector<std::string> causes = CausesOf(scene, result);
  if (!causes.empty()) {
    root.Find(Severity::kNote, "explained-by", "a wrong value would explain it: {causes}",
              {{"causes", fmt::format("{}", fmt::join(causes, "; or "))}});
  } else if (!scene.inputs().empty()) {
    root.Find(Severity::kDoubt, "not-explained",
              "no stated input explains it alone: the model, the measurement or several inputs "
              "are wrong");
  }
}

void FindAssumptions(const MeasuredNumbers& measured, const ComparedScene& scene,
                     const ComparisonResult& result, Section& root) {
  for (const std::string& doubt : measured.doubts) {
    root.findings.push_back({.kind = "trial-doubted", .severity = Severity::kDoubt, .text = doubt});
  }
  for (const std::size_t place : result.curved) {
    root.Find(Severity::kDoubt, "not-linear",
              "a quantity does not depend linearly on {input} as far as it is changed: its pull "
              "and what is adjusted are rough",
              {{"input", scene.inputs()[place].key}});
  }
  if (scene.inputs().empty()) {
    root.Find(Severity::kNote, "inputs-exact",
              "every number of the scene is exact: state what is uncertain by --input, or "
              "the actuator by a file of fit-lra --save");
  }
  if (!measured.is_calibrated) {
    root.Find(Severity::kNote, "calibration-not-included",
              "the measured uncertainties do not hold the sensor's calibration");
  }
  const bool has_electrical = std::ranges::any_of(
      result.quantities, [](const auto& one) { return one.quantity >= Compared::kCurrent; });
  if (has_electrical && !measured.has_electrical_gain) {
    root.Find(Severity::kNote, "electrical-noise-alone",
              "the measured uncertainties of current, power and phase are of noise alone: state "
              "gain and skew of the channels by --uncertainty current_rms_a=1%");
  }
  const auto note = [&](std::string_view kind, std::string_view text,
                        const std::vector<Compared>& quantities) {
    if (quantities.empty()) return;
    root.Find(Severity::kNote, kind, text, {{"quantities", LabelsOf(quantities, result.target)}});
  };
  note("not-simulated", "measured, but not known of the scene: {quantities}", result.only_measured);
  note("not-measured", "simulated, but not known of the trials: {quantities}",
       result.only_simulated);
}

// --- the figure ---

// both sides as distances from the simulated value in units of the deviation's expanded
// uncertainty: the measured points stand at E_n
document::Figure FigureOf(const ComparisonResult& result) {
  constexpr double kBeside = 0.08;  // of the distance of two quantities
  plot::Panel panel{.y_label = "(value - simulated) / U(deviation)", .has_margins = true};
  const auto bars = [](std::string title, plot::Colour colour, int point) {
    return plot::Series{
        .title = std::move(title),
        .style = {.mark = plot::Mark::kErrorBars, .colour = colour, .point = point}};
  };
  plot::Series measured = bars("measured (k = 2)", plot::kBlue, 7);
  plot::Series simulated = bars("simulated (k = 2)", plot::kOrange, 5);
  for (const ComparedQuantity& one : result.quantities) {
    const double x = static_cast<double>(panel.ticks.size()) + 1;
    panel.ticks.push_back({x, std::string(kShortNames[static_cast<std::size_t>(one.quantity)])});
    const auto add = [&](plot::Series& series, double at, double y, double u) {
      series.x.push_back(at);
      series.y.push_back(y);
      series.y_error.push_back(u / one.deviation_uncertainty);
    };
    add(measured, x - kBeside, one.NormalizedError(), one.measured.uncertainty);
    add(simulated, x + kBeside, 0, one.simulated.uncertainty);
  }
  const double last = static_cast<double>(panel.ticks.size()) + kBeside;
  for (const double limit : {-1.0, 1.0}) {
    panel.series.push_back({.title = limit > 0 ? "|E_n| = 1" : "",
                            .style = plot::Lines(plot::kGrey, 1, 2),
                            .x = {1 - kBeside, last},
                            .y = {limit, limit}});
  }
  panel.series.push_back(std::move(measured));
  panel.series.push_back(std::move(simulated));
  return {.caption =
              "Measured and simulated with expanded uncertainties (k = 2), in units of that "
              "of their deviation: beyond the lines they differ.",
          .panels = {std::move(panel)}};
}

}  // namespace

document::Document CompareDocument(const MeasuredNumbers& measured, const ComparedScene& scene,
                                   const ComparisonResult& result, bool has_figures) {
  const std::string trials = measured.files.size() == 1
                                 ? measured.files.front()
                                 : fmt::format("{} trials", measured.files.size());
  document::Document document{.verb = "compare",
                              .title = fmt::format("{} against {}", trials, scene.path())};
  Section& root = document.root;
  root.sources = measured.sources;
  if (std::ranges::count(root.sources, document::DataSource::kSimulated) == 0) {
    root.sources.push_back(document::DataSource::kSimulated);
  }
  root.Add(document::kScene, scene.path());
  root.Add(document::kTrials, measured.files);
  root.Add({document::kAgrees.name, "agree (all |E_n| at most 1)"}, !result.Differs());
  root.Add({"chi_squared"}, result.agreement.chi_squared);
  root.Add({document::kDegreesOfFreedom.name}, result.quantities.size());
  root.sections.push_back(document::ListOf(
      {.name = "quantities"}, result.quantities,
      [&](const ComparedQuantity& one) { return QuantityRow(one, result.target); }));
  if (!scene.inputs().empty()) root.sections.push_back(InputsSection(scene, result));
  if (has_figures) root.figures = {FigureOf(result)};
  FindDifference(scene, result, root);
  FindAssumptions(measured, scene, result, root);
  return document;
}

}  // namespace haptometer::tools
