#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>
#include <utility>

#include "tools/analyze/analyze.h"
#include "tools/document/findings_dsp.h"
#include "tools/document/keys.h"
#include "tools/document/render.h"

namespace haptometer::tools {
namespace {

using document::Item;
using document::Key;
using document::Section;
using document::Unit;
using document::Value;

constexpr double kUm = 1e-6;  // in metres
// units of amplitude over drive
constexpr Unit kMetrePerAmpere{"_m_per_a", "m/A", {{{1e6, "um/A"}, {1e3, "mm/A"}}}};
constexpr Unit kMetrePerUnit{
    "_m_per_unit", "m per unit", {{{1e6, "um per unit"}, {1e3, "mm per unit"}}}};

// m/V or m/A over a recorded drive, m without one, else m for each unit of the drive channel
Unit AmplitudeUnit(const dsp::SweepAnswer& answer) {
  if (answer.amplitude_unit == "m/V") return document::kMetrePerVolt;
  if (answer.amplitude_unit == "m/A") return kMetrePerAmpere;
  return answer.drive.empty() ? document::kMetre : kMetrePerUnit;
}

// |H(f)| = gain / |1 - u^2 + i u / Q| with u = f / f0, in the points' unit
double CurveAt(const dsp::Resonance& fit, double frequency_hz) {
  const double u = frequency_hz / fit.frequency_hz;
  return fit.gain / std::hypot(1 - u * u, u / fit.quality_factor);
}

// one value of each point over frequency
plot::Series SeriesOf(const dsp::SweepAnswer& answer, std::string title, plot::Style style,
                      const std::function<double(const dsp::SweepPoint&)>& value) {
  plot::Series series{std::move(title), style};
  series.x.reserve(answer.points.size());
  series.y.reserve(answer.points.size());
  for (const dsp::SweepPoint& point : answer.points) {
    series.x.push_back(point.frequency_hz);
    series.y.push_back(value(point));
  }
  return series;
}

plot::Panel AmplitudePanel(const dsp::SweepAnswer& answer) {
  plot::Panel panel{"amplitude over frequency",
                    "frequency / Hz",
                    fmt::format("amplitude / u{}", answer.amplitude_unit),
                    {},
                    plot::LogAxes::kY};
  panel.series.push_back(
      SeriesOf(answer, "measured", plot::Lines(plot::kBlue),
               [](const dsp::SweepPoint& point) { return point.amplitude / kUm; }));
  // the fitted curve only where one resonance explains the response
  if (!answer.resonance) return panel;
  const dsp::Resonance& fit = answer.resonance->fit;
  panel.title =
      fmt::format("resonance at {:.5g} Hz, Q {:.4g}", fit.frequency_hz, fit.quality_factor);
  panel.series.push_back(SeriesOf(
      answer, "one resonance", plot::Lines(plot::kOrange),
      [&](const dsp::SweepPoint& point) { return CurveAt(fit, point.frequency_hz) / kUm; }));
  return panel;
}

std::vector<plot::Panel> PanelsOf(const dsp::SweepAnswer& answer) {
  std::vector<plot::Panel> panels{AmplitudePanel(answer)};
  // phase and coherence need a drive: without one there is an amplitude only
  if (answer.drive.empty()) return panels;
  panels.push_back({"phase",
                    "frequency / Hz",
                    "phase / rad",
                    {SeriesOf(answer, "", plot::Lines(plot::kBlue),
                              [](const dsp::SweepPoint& p) { return p.phase_rad.value_or(0); })}});
  panels.push_back({"coherence",
                    "frequency / Hz",
                    "coherence",
                    {SeriesOf(answer, "", plot::Lines(plot::kBlue),
                              [](const dsp::SweepPoint& p) { return p.coherence.value_or(0); })}});
  panels.back().y_from_zero = true;
  return panels;
}

// an estimate with its 95 % interval; text shows the digits of a quarter of the interval's width
void AddEstimate(Section& section, const Key& key, const Key& interval_key, double value,
                 const dsp::Interval& interval) {
  // interval of about +-2 u: u = width / 4
  Item& item = section.Add(key, value, (interval.upper - interval.lower) / 4);
  item.interval = interval;
  section.Add(interval_key, interval);
}

Section ResonanceSection(const dsp::SweepAnswer& answer) {
  const dsp::SweepResonance found = answer.resonance.value_or(dsp::SweepResonance{});
  Section section{.name = "resonance", .is_known = answer.resonance.has_value()};
  AddEstimate(section, {document::kFrequency.name, "natural frequency", document::kHertz},
              {"frequency_interval_95_hz"}, found.fit.frequency_hz, found.frequency_hz);
  AddEstimate(section, document::kQualityFactor, {"quality_factor_interval_95"},
              found.fit.quality_factor, found.quality_factor);
  // gain: static amplitude of the fit, in the points' unit
  section.Add({document::kGain.name}, found.fit.gain);
  section.Add({"residual_share"}, found.fit.residual_share);
  section.Add({document::kDegreesOfFreedom.name}, found.fit.degrees_of_freedom);
  return section;
}

// points of the response; the amplitude's key is `amplitude`, with the unit's ending in a CSV
Section PointsTable(const dsp::SweepAnswer& answer, std::string_view amplitude) {
  Section table{.name = document::kPoints.name,
                .heading = "points",
                .shape = Section::Shape::kTable,
                .detail = document::Detail::kAll};
  for (const dsp::SweepPoint& point : answer.points) {
    Section& row = table.sections.emplace_back();
    row.Add(document::kFrequency, point.frequency_hz);
    row.Add({amplitude, "amplitude", AmplitudeUnit(answer)}, point.amplitude);
    row.Add({document::kPhase.name, "phase", document::kRadian}, point.phase_rad);
    row.Add({"coherence", "coherence"}, point.coherence);
  }
  return table;
}

// range and resolution of the sweep, and the largest amplitude (no fit)
Section SweptSection(const dsp::SweepAnswer& answer) {
  Section section{.is_known = answer.answered};
  section.Add({"resolution_hz", "resolution", document::kHertz}, answer.resolution_hz);
  if (answer.points.empty()) return section;
  section
      .Add({"", "swept", document::kHertz},
           document::Range{answer.points.front().frequency_hz, answer.points.back().frequency_hz})
      .note = fmt::format("{} points", answer.points.size());
  section.Add({"", "drive"}, answer.drive.empty() ? "not recorded" : answer.drive);
  const auto highest = std::ranges::max_element(answer.points, {}, &dsp::SweepPoint::amplitude);
  section.Add({"", "largest amplitude", AmplitudeUnit(answer)}, highest->amplitude).note =
      fmt::format("at {:.5g} Hz", highest->frequency_hz);
  return section;
}

}  // namespace

Section SweepSection(const std::string& path, const dsp::SweepAnswer& answer, bool is_alone) {
  // an answer that was refused before the record was read has no rate
  const bool is_measured = answer.rate_hz > 0;
  Section trial{.heading = is_alone ? "" : path};
  trial.Add(document::kFile, path);
  trial.Add(document::kAnswered, answer.answered);
  trial.Add(document::kReasons, document::RefusalsOf(answer.findings));
  trial.Add({"drive_channel"}, document::TextOrNotKnown(answer.drive));
  trial.Add({"amplitude_unit"}, answer.amplitude_unit);
  trial.Add(
      {document::kWindowS.name},
      is_measured ? Value(document::Range{answer.window.begin_s, answer.window.end_s}) : Value());
  trial.Add({document::kSampleRate.name}, is_measured ? Value(answer.rate_hz) : Value());
  trial.Add({document::kSensorAveraging.name},
            is_measured ? Value(document::TextOf(answer.sensor)) : Value());
  trial.Add({document::kAmplitudeVerified.name}, answer.amplitude_verified);
  trial.sections = {ResonanceSection(answer), SweptSection(answer),
                    PointsTable(answer, "amplitude")};
  if (!answer.points.empty()) {
    trial.figures = {{.caption = "amplitude over frequency", .panels = PanelsOf(answer)}};
  }
  document::AddFindings(trial, answer.findings);
  for (document::Finding& finding : trial.findings) {
    if (!is_alone) finding.subject = path;
  }
  return trial;
}

std::string SweepCsv(const dsp::SweepAnswer& answer, const document::Provenance& provenance) {
  std::string text = fmt::format("# resolution_hz = {:.9g}\n", answer.resolution_hz);
  if (answer.resonance) {
    text += fmt::format("# f0_hz = {:.9g}\n# quality_factor = {:.9g}\n",
                        answer.resonance->fit.frequency_hz, answer.resonance->fit.quality_factor);
  }
  const std::string amplitude = fmt::format("amplitude{}", AmplitudeUnit(answer).ending);
  if (!answer.points.empty()) return text + CsvOf(PointsTable(answer, amplitude), provenance);
  // without points a table of the heading alone: one row is made and its line removed
  dsp::SweepAnswer one = answer;
  one.points.resize(1);
  text += CsvOf(PointsTable(one, amplitude), provenance);
  return text.substr(0, text.rfind('\n', text.size() - 2) + 1);
}

}  // namespace haptometer::tools
