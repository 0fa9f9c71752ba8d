#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "tools/cost/cost.h"
#include "tools/document/keys.h"
#include "tools/fit/fit_document.h"

namespace haptometer::tools {
namespace {

using document::Section;

Section MethodSection(const CostedMethod& method) {
  Section row;
  row.Add(document::kMethod, method.method);
  row.Add({document::kSettings.name, "settings"}, document::TextOrNotKnown(method.settings));
  row.Add({document::kAnswers.name, "reached"}, method.answers);
  ShowDigits(
      row.Add({document::kRecording.name, "recording", document::kSecond}, method.recording_s), 2);
  ShowDigits(row.Add({"predicted_s", "computing", document::kSecond}, method.predicted_s), 2);
  ShowDigits(row.Add({"measured_s", "measured", document::kSecond}, method.measured_s), 2);
  row.Add({"predicted_error"}, method.predicted_error);
  row.Add({"measured_error"}, method.measured_error);
  // people read the error that decides: what was measured, else what is predicted
  const auto error = method.measured_error ? method.measured_error : method.predicted_error;
  ShowDigits(row.Add({"", "relative error, at most"}, error), 2);
  row.Add({"error_of", "error of"}, document::TextOrNotKnown(method.error_of));
  row.Add({document::kLimitedBy.name, "limited by"}, document::TextOrNotKnown(method.limited_by));
  row.Add({"is_peer"}, method.is_peer);
  return row;
}

Section RungSection(const Rung& rung) {
  Section row;
  row.Add({document::kScene.name, "scene"}, NameOf(rung.scene_class));
  row.Add(document::kMethod, rung.method);
  row.Add({"setting", "setting"}, rung.setting);
  ShowDigits(row.Add({"seconds_s", "time", document::kSecond}, rung.seconds), 3);
  ShowDigits(row.Add({"rms_error", "error of the RMS"}, rung.rms_error), 2);
  ShowDigits(row.Add({"worst_error", "largest error"}, rung.worst_error), 2);
  return row;
}

// error of the waveform against time, a panel for each class and a curve for each method
document::Figure LadderFigure(std::span<const Rung> rungs) {
  constexpr std::array kColours{plot::kBlue, plot::kOrange, plot::kGreen, plot::kBlack};
  document::Figure figure{.caption = "Error of the skin's waveform against the time of a run",
                          .panels = {}};
  for (std::size_t k = 0; k < kSceneClasses; ++k) {
    plot::Panel panel{.title = std::string(NameOf(static_cast<SceneClass>(k))),
                      .x_label = "time / s",
                      .y_label = "largest relative error",
                      .log_axes = plot::LogAxes::kBoth,
                      .has_margins = true};
    for (const Rung& rung : rungs) {
      if (rung.scene_class != static_cast<SceneClass>(k) || !std::isfinite(rung.worst_error)) {
        continue;
      }
      auto series = std::ranges::find(panel.series, rung.method, &plot::Series::title);
      if (series == panel.series.end()) {
        const plot::Colour colour = kColours[panel.series.size() % kColours.size()];
        panel.series.push_back(
            {.title = rung.method, .style = {.mark = plot::Mark::kLinesPoints, .colour = colour}});
        series = panel.series.end() - 1;
      }
      series->x.push_back(rung.seconds);
      series->y.push_back(rung.worst_error);
    }
    figure.panels.push_back(std::move(panel));
  }
  return figure;
}

Section KnowledgeSection(const KnowledgeLimit& limit) {
  Section row;
  row.Add({document::kInput.name, "not known"}, limit.input);
  row.Add({"by", "by"}, limit.by);
  ShowDigits(row.Add({document::kChange.name, "changes the skin's RMS by", document::kShare},
                     limit.change),
             2);
  return row;
}

// leaves settings to JSON, where a text has no room for them
void HideSettings(Section& method) {
  std::ranges::find(method.items, document::kSettings.name, &document::Item::name)->label.clear();
}

// in the chain: the accuracy, and the best method for it
Section BestSection(const CostAnswer& answer) {
  Section row;
  row.Add({document::kAccuracy.name, "to", document::kShare}, answer.accuracy);
  Section best = MethodSection(answer.methods.front());
  HideSettings(best);
  std::ranges::move(best.items, std::back_inserter(row.items));
  return row;
}

Section ConstantSection(const CostAnswer& answer) {
  Section row;
  row.Add(document::kConstant, answer.question);
  Section best = BestSection(answer);
  std::ranges::move(best.items, std::back_inserter(row.items));
  return row;
}

Section DigitSection(const DigitPrice& price) {
  Section row;
  const auto add = [&row](std::string_view name, std::string_view label, document::Value seconds) {
    ShowDigits(row.Add({name, label, document::kSecond}, std::move(seconds)), 2);
  };
  row.Add({"digits", "digits"}, price.digits);
  add("steady_rms_s", "RMS", price.steady_rms_s);
  add("linear_s", "waveform", price.waveform_s[0]);
  add("stops_s", "stops", price.waveform_s[1]);
  add("contact_s", "contact", price.waveform_s[2]);
  add("smooth_s", "smooth", price.waveform_s[3]);
  add("others_smooth_s", "others", price.others_smooth_s);
  row.Add({"others_method", "their method"}, document::TextOrNotKnown(price.others_method));
  return row;
}

}  // namespace

document::Document CostDocument(const CostAnswer& answer) {
  document::Document document{
      .verb = "cost",
      .title = fmt::format("{} of {} to {:g}", answer.question, answer.subject, answer.accuracy)};
  Section& root = document.root;
  root.Add({"question"}, answer.question);
  root.Add({document::kSubject.name}, answer.subject);
  root.Add(document::kAccuracy, answer.accuracy);
  root.sections.push_back(document::ListOf(Section{.name = "methods", .heading = "methods"},
                                           answer.methods, MethodSection));
  root.findings = answer.notes.findings;
  if (answer.question == kBandRms) {
    std::ranges::for_each(root.sections.back().sections, HideSettings);
    root.Find(Severity::kNote, "options-of-routes",
              "haptometer acquire --advise states the options and commands of each route");
  }
  return document;
}

document::Document ChainDocument(const CostChain& chain) {
  document::Document document{.verb = "cost", .title = "What accuracy costs"};
  Section& root = document.root;
  root.sections.push_back(document::ListOf(
      Section{.name = "knowledge",
              .heading = "Digits of arithmetic are not digits of knowledge: the thesis's adapter "
                         "scene, 5 V at 225 Hz"},
      chain.knowledge, KnowledgeSection));
  root.sections.push_back(document::ListOf(
      Section{.name = "recordings",
              .heading = "an RMS of 10 um at 225 Hz within 20-500 Hz, with an IL-030"},
      chain.recordings, BestSection));
  root.sections.push_back(document::ListOf(
      Section{.name = "constants", .heading = "an actuator's constants, by drop tests"},
      chain.constants, ConstantSection));
  root.sections.push_back(document::ListOf(
      Section{.name = "simulations",
              .heading =
                  "0.1 s of that scene on this machine: RMS of the steady motion; waveform; with "
                  "travel stops, contact that breaks, smooth effects; these by other programs"},
      chain.simulations, DigitSection));
  Section machine{.name = "machine_ratios", .detail = document::Detail::kAll};
  for (std::size_t k = 0; k < kSceneClasses; ++k) {
    machine.Add({NameOf(static_cast<SceneClass>(k))}, chain.ratios[k]);
  }
  root.sections.push_back(std::move(machine));
  // a probe does not know more than two decimals
  const auto ends = std::ranges::minmax(chain.ratios);
  const double least = std::round(100 * ends.min) / 100, most = std::round(100 * ends.max) / 100;
  if (!chain.measured.empty()) {
    Section& section = root.sections.emplace_back(
        document::ListOf(Section{.name = document::kMeasured.name, .heading = "measured here"},
                         chain.measured, RungSection));
    section.figures.push_back(LadderFigure(chain.measured));
    const bool has_scipy =
        std::ranges::any_of(chain.measured, [](const Rung& rung) { return !IsOwn(rung.method); });
    if (!has_scipy) {
      root.Find(Severity::kNote, "no-scipy",
                "no python3 here has SciPy: it is not among what was measured");
    }
    root.Find(Severity::kNote, "others-scaled",
              "times of other programs than SciPy were measured once (docs/sim_cost.csv) and are "
              "scaled: this machine takes {least} to {most} times as long",
              {{"least", least}, {"most", most}});
    return document;
  }
  root.Find(Severity::kNote, "scaled-by-probe",
            "times were measured once (docs/sim_cost.csv) and are scaled by a probe of 0.8 s: this "
            "machine takes {least} to {most} times as long; --measure measures here",
            {{"least", least}, {"most", most}});
  return document;
}

}  // namespace haptometer::tools
