#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "dsp/statistics/distributions.h"
#include "tools/compare/compare.h"
#include "tools/document/keys.h"

namespace haptometer::tools {
namespace {

using document::Section;

constexpr double kScoreStep = 0.01;  // of a score: its last digit that is shown
constexpr double kNotSearched = std::numeric_limits<double>::quiet_NaN();
constexpr double kCoverage = 2;  // k of the intervals

std::string KeysOf(const ComparedScene& scene, const std::vector<std::size_t>& places) {
  return fmt::format(
      "{}", fmt::join(Mapped(places, [&](std::size_t k) { return scene.inputs()[k].key; }), ", "));
}

std::vector<std::size_t> Flat(const std::vector<std::vector<std::size_t>>& sets) {
  std::vector<std::size_t> places;
  for (const auto& set : sets) places.insert(places.end(), set.begin(), set.end());
  return places;
}

std::string LabelsOf(const std::vector<Compared>& quantities, sim::SensorTarget target) {
  return fmt::format(
      "{}",
      fmt::join(Mapped(quantities, [&](Compared one) { return KeyOf(one, target).label; }), ", "));
}

// --- tables ---

}  // namespace

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

namespace {

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

}  // namespace

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

namespace {

void FindDifference(const ComparedScene& scene, const ComparisonResult& result, Section& root) {
  if (!result.Differs() && !result.DiffersTogether()) return;
  std::vector<Compared> differing;
  for (const ComparedQuantity& one : result.quantities) {
    if (one.Differs()) differing.push_back(one.quantity);
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
              {{"chi_squared", result.chi_squared}});
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

// recordings that are repeats by their place on the command line, but not by their labels
void FindLabels(const MeasuredNumbers& measured, Section& root) {
  for (const std::string label : {"subject", "condition"}) {
    std::set<std::string> values;
    for (const auto& labels : measured.labels) {
      const auto found = labels.find(label);
      if (found != labels.end()) values.insert(Printable(found->second));
    }
    if (values.size() < 2) continue;
    root.Find(Severity::kDoubt, "labels-differ",
              "the trials are averaged as repeats of one measurement, but their {label}s are "
              "{values}: compare those of one {label} at a time, or use study compare",
              {{"label", label}, {"values", fmt::format("{}", fmt::join(values, ", "))}});
  }
}

// trials of which no mean is to be had
void FindScatter(const MeasuredNumbers& measured, sim::SensorTarget target, Section& root) {
  if (measured.scattered.empty()) return;
  root.Find(Severity::kDoubt, "repeats-differ",
            "the trials are no repeats of one measurement, and are not compared as such: the "
            "largest is more than twice the smallest, beyond their uncertainties, of "
            "{quantities}; compare them one at a time",
            {{"quantities", LabelsOf(measured.scattered, target)}});
}

// inputs whose best value a range excludes
void FindOutside(const ComparedScene& scene, const ComparisonResult& result, Section& root) {
  std::vector<std::size_t> outside;
  for (const std::size_t place : Flat(result.sets)) {
    if (!scene.inputs()[place].is_range) continue;
    const auto j = static_cast<Eigen::Index>(place);
    // in standard uncertainties of the input, of which a range has sqrt(3) to either side
    const double left = std::sqrt(std::max(0.0, 1 - result.agreement.explained(j)));
    const double beyond = std::abs(result.agreement.adjustment(j)) - std::numbers::sqrt3;
    if (beyond > left) outside.push_back(place);
  }
  if (outside.empty()) return;
  root.Find(Severity::kDoubt, "adjusted-outside",
            "the adjusted value lies outside of the range that is stated, by more than its "
            "uncertainty: {inputs}; it explains nothing where the range is right",
            {{"inputs", KeysOf(scene, outside)}});
}

void FindAssumptions(const MeasuredNumbers& measured, const ComparedScene& scene,
                     const ComparisonResult& result, Section& root) {
  FindLabels(measured, root);
  FindScatter(measured, result.target, root);
  FindOutside(scene, result, root);
  for (const std::string& doubt : measured.doubts) {
    root.findings.push_back({.kind = "trial-doubted", .severity = Severity::kDoubt, .text = doubt});
  }
  for (const std::size_t place : result.curved) {
    root.Find(
        Severity::kDoubt, "not-linear",
        "a quantity does not depend linearly on {input} as far as it is uncertain or changed: "
        "its scores hold how far it spreads, pulls and adjusted values are rough",
        {{"input", scene.inputs()[place].key}});
  }
  // inputs that the search moved together
  std::vector<std::size_t> correlated;
  const Eigen::MatrixXd correlation = scene.factor() * scene.factor().transpose();
  for (std::size_t j = 0; j < result.explaining.size(); ++j) {
    const auto others = correlation.col(static_cast<Eigen::Index>(j)).cwiseAbs().sum() - 1;
    if (others > kScoreStep && std::isfinite(result.explaining[j])) correlated.push_back(j);
  }
  if (!correlated.empty()) {
    root.Find(Severity::kNote, "moved-together",
              "{inputs} are correlated: where one explains most at a value, the others are moved "
              "with it, by their correlation",
              {{"inputs", KeysOf(scene, correlated)}});
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

}  // namespace

void AddComparison(const MeasuredNumbers& measured, const ComparedScene& scene,
                   const ComparisonResult& result, Section& section) {
  // of trials that are no repeats neither is known
  section.Add({document::kAgrees.name, "agree (all |E_n| at most 1)"},
              measured.scattered.empty() ? document::Value(!result.Differs()) : document::Value());
  section.Add({"chi_squared"}, result.chi_squared);
  section.Add({document::kDegreesOfFreedom.name}, result.quantities.size());
  section.sections.push_back(document::ListOf(
      {.name = "quantities"}, result.quantities,
      [&](const ComparedQuantity& one) { return QuantityRow(one, result.target); }));
  if (!scene.inputs().empty()) section.sections.push_back(InputsSection(scene, result));
  FindDifference(scene, result, section);
  FindAssumptions(measured, scene, result, section);
}

std::vector<plot::Panel> ComparisonPanels(std::span<const ComparedGroup> groups) {
  constexpr double kWidth = 0.6;  // of a group
  const auto bars = [](std::string title, plot::Colour colour, int point) {
    return plot::Series{
        .title = std::move(title),
        .style = {.mark = plot::Mark::kErrorBars, .colour = colour, .point = point}};
  };
  std::vector<plot::Panel> panels;
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    const auto quantity = static_cast<Compared>(k);
    const auto found =
        Mapped(groups, [&](const ComparedGroup& group) { return group.Of(quantity); });
    // the first number decides the unit
    const auto first = std::ranges::find_if_not(found, &std::vector<ComparedQuantity>::empty);
    if (first == found.end()) continue;
    const document::Key key = KeyOf(quantity, groups.front().results.front().target);
    const document::SpokenUnit unit = key.unit.For(std::abs(first->front().measured.value));
    plot::Panel panel{.y_label = fmt::format("{} / {}", key.label, unit.symbol),
                      .series = {bars("simulated (k = 2)", plot::kOrange, 5),
                                 bars("measured (k = 2)", plot::kBlue, 7)},
                      .has_margins = true};
    const auto add = [&](std::size_t series, double x, const dsp::Estimate& number) {
      panel.series[series].x.push_back(x);
      panel.series[series].y.push_back(number.value * unit.factor);
      panel.series[series].y_error.push_back(kCoverage * number.uncertainty * unit.factor);
    };
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const double left = static_cast<double>(g) - kWidth / 2;
      const double step = kWidth / static_cast<double>(found[g].size());
      const auto differing = std::ranges::count_if(found[g], &ComparedQuantity::Differs);
      panel.ticks.push_back(
          {static_cast<double>(g),
           found[g].size() == 1
               ? fmt::format("{}, E_n = {:.2f}", groups[g].name, found[g][0].NormalizedError())
               : fmt::format("{}, {} of {} differ", groups[g].name, differing, found[g].size())});
      if (!found[g].empty()) add(0, left, found[g].front().simulated);
      for (std::size_t i = 0; i < found[g].size(); ++i) {
        add(1, left + step * static_cast<double>(i + 1), found[g][i].measured);
      }
    }
    panels.push_back(std::move(panel));
  }
  return panels;
}

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
  AddComparison(measured, scene, result, root);
  document::AddFindings(root, scene.unusual());
  if (has_figures) {
    const ComparedGroup group{.name = trials, .results = {result}};
    root.figures = {
        {.caption = std::string(kFigureCaption), .panels = ComparisonPanels({&group, 1})}};
  }
  return document;
}

}  // namespace haptometer::tools
