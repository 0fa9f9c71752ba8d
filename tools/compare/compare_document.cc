#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/mapped.h"
#include "dsp/statistics/distributions.h"
#include "tools/compare/compare.h"
#include "tools/document/keys.h"

namespace haptometer::tools {
namespace {

using document::Section;

constexpr double kScoreStep = 0.01;  // of a score: its last digit that is shown
constexpr double kPullOfCause = 2;   // |p| of an input that may be the cause, as of E_n
constexpr double kCoverage = 2;      // k of the intervals

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
      freedom > 0 ? dsp::ChiSquareQuantile(0.95, freedom) : 1e-9 * agreement.chi_squared;
  std::vector<std::string> causes;
  for (const std::vector<std::size_t>& set : result.sets) {
    const double pull = agreement.pull(static_cast<Eigen::Index>(set.front()));
    if (std::abs(pull) < kPullOfCause || agreement.chi_squared - pull * pull > most) continue;
    causes.push_back(
        set.size() == 1 ? KeysOf(scene, set)
                        : fmt::format("one of {}, which cannot be told apart", KeysOf(scene, set)));
  }
  return causes;
}

void FindDifference(const ComparedScene& scene, const ComparisonResult& result, Section& root) {
  if (!result.Differs()) return;
  std::vector<Compared> differing;
  for (const ComparedQuantity& one : result.quantities) {
    if (std::abs(one.NormalizedError()) > 1) differing.push_back(one.quantity);
  }
  root.Find(Severity::kDoubt, "differs",
            "measured and simulated differ by more than their expanded uncertainties: {quantities}",
            {{"quantities", LabelsOf(differing, result.target)}});
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
              "a quantity does not depend linearly on {input} within its uncertainty: scores and "
              "pulls are rough",
              {{"input", scene.inputs()[place].key}});
  }
  if (scene.inputs().empty()) {
    root.Find(Severity::kNote, "inputs-exact",
              "every number of the scene is taken as exact: state what is uncertain by --input, or "
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

// both sides with their expanded uncertainties, `scale` of a value
plot::Panel PairPanel(const std::vector<ComparedQuantity>& quantities, sim::SensorTarget target,
                      std::string label, double (*scale)(const ComparedQuantity& one)) {
  constexpr double kBeside = 0.08;  // of the distance of two quantities
  plot::Panel panel{.y_label = std::move(label), .has_margins = true};
  plot::Series measured{.title = "measured (k = 2)",
                        .style = {.mark = plot::Mark::kErrorBars, .colour = plot::kBlue}};
  plot::Series simulated{
      .title = "simulated (k = 2)",
      .style = {.mark = plot::Mark::kErrorBars, .colour = plot::kOrange, .point = 5}};
  for (const ComparedQuantity& one : quantities) {
    const double x = static_cast<double>(panel.ticks.size()) + 1, by = scale(one);
    panel.ticks.push_back({x, std::string(KeyOf(one.quantity, target).label)});
    measured.x.push_back(x - kBeside);
    measured.y.push_back((one.simulated.value + one.deviation) * by);
    measured.y_error.push_back(kCoverage * one.measured.uncertainty * std::abs(by));
    simulated.x.push_back(x + kBeside);
    simulated.y.push_back(one.simulated.value * by);
    simulated.y_error.push_back(kCoverage * one.simulated.uncertainty * std::abs(by));
  }
  panel.series = {std::move(measured), std::move(simulated)};
  return panel;
}

document::Figure FigureOf(const ComparisonResult& result) {
  std::vector<ComparedQuantity> phase, others;
  for (const ComparedQuantity& one : result.quantities) {
    (one.quantity == Compared::kPhase || one.simulated.value == 0 ? phase : others).push_back(one);
  }
  document::Figure figure{
      .caption =
          "Measured and simulated with expanded uncertainties (k = 2); where the bars are "
          "apart, |E_n| may exceed 1.",
      .panels = {}};
  if (!others.empty()) {
    figure.panels.push_back(PairPanel(others, result.target, "value / simulated value",
                                      [](const auto& one) { return 1 / one.simulated.value; }));
  }
  if (!phase.empty()) {
    figure.panels.push_back(PairPanel(phase, result.target, "phase / degrees", [](const auto&) {
      return document::kRadian.spoken[0].factor;
    }));
  }
  return figure;
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
  root.Add({"agrees", "agree (all |E_n| at most 1)"}, !result.Differs());
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
