#include "tools/analyze/sweep_document.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "tools/cli/json.h"
#include "tools/cli/terminal.h"
#include "tools/cli/uncertain_number.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUm = 1e-6;  // in metres

void Line(std::string_view label, std::string_view text) {
  cli::Print(fmt::format("  {:<17}{}\n", label, Printable(text)));
}

// "um/V" of "m/V"
std::string ShownUnit(const dsp::SweepAnswer& answer) { return "u" + answer.amplitude_unit; }

// "amplitude_m_per_v"
std::string AmplitudeColumn(const dsp::SweepAnswer& answer) {
  if (answer.amplitude_unit == "m/V") return "amplitude_m_per_v";
  if (answer.amplitude_unit == "m/A") return "amplitude_m_per_a";
  return answer.drive.empty() ? "amplitude_m" : "amplitude_m_per_unit";
}

// "12.3 (95 % interval 12.1 to 12.5)"
std::string WithInterval(double value, const dsp::Interval& interval, std::string_view unit) {
  const double uncertainty = (interval.upper - interval.lower) / 4;
  return fmt::format("{}{} (95 % interval {} to {}{})", cli::ToThePlaceOf(uncertainty, value), unit,
                     cli::ToThePlaceOf(uncertainty, interval.lower),
                     cli::ToThePlaceOf(uncertainty, interval.upper), unit);
}

const dsp::SweepPoint& Highest(const dsp::SweepAnswer& answer) {
  return *std::ranges::max_element(answer.points, {}, &dsp::SweepPoint::amplitude);
}

Json ResonanceJson(const dsp::SweepAnswer& answer) {
  if (!answer.resonance) return nullptr;
  const dsp::SweepResonance& r = *answer.resonance;
  return {{"frequency_hz", r.fit.frequency_hz},
          {"frequency_interval_95_hz", {r.frequency_hz.lower, r.frequency_hz.upper}},
          {"quality_factor", r.fit.quality_factor},
          {"quality_factor_interval_95", {r.quality_factor.lower, r.quality_factor.upper}},
          {"gain", cli::NumberOrNull(r.fit.gain)},
          {"residual_share", cli::NumberOrNull(r.fit.residual_share)},
          {"degrees_of_freedom", r.fit.degrees_of_freedom}};
}

Json PointsJson(const dsp::SweepAnswer& answer) {
  Json points = Json::array();
  for (const dsp::SweepPoint& point : answer.points) {
    points.push_back({{"frequency_hz", point.frequency_hz},
                      {"amplitude", point.amplitude},
                      {"phase_rad", cli::NumberOrNull(point.phase_rad)},
                      {"coherence", cli::NumberOrNull(point.coherence)}});
  }
  return points;
}

// the fitted curve's magnitude, in the points' unit
double CurveAt(const dsp::Resonance& fit, double frequency_hz) {
  const double u = frequency_hz / fit.frequency_hz;
  return fit.gain / std::hypot(1 - u * u, u / fit.quality_factor);
}

// one value of each point over frequency
plot::Series SeriesOf(const dsp::SweepAnswer& answer, std::string title, plot::Style style,
                      const std::function<double(const dsp::SweepPoint&)>& value) {
  plot::Series series{std::move(title), style, {}, {}};
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
                    "amplitude / " + ShownUnit(answer),
                    {},
                    plot::LogAxes::kY};
  panel.series.push_back(
      SeriesOf(answer, "measured", plot::Lines(plot::kBlue),
               [](const dsp::SweepPoint& point) { return point.amplitude / kUm; }));
  if (!answer.resonance) return panel;
  const dsp::Resonance& fit = answer.resonance->fit;
  panel.title =
      fmt::format("resonance at {:.5g} Hz, Q {:.4g}", fit.frequency_hz, fit.quality_factor);
  panel.series.push_back(SeriesOf(
      answer, "one resonance", plot::Lines(plot::kOrange),
      [&](const dsp::SweepPoint& point) { return CurveAt(fit, point.frequency_hz) / kUm; }));
  return panel;
}

}  // namespace

void PrintSweep(const std::string& path, const dsp::SweepAnswer& answer) {
  cli::Print(Printable(path) + "\n");
  if (answer.answered) {
    Line("sweep", fmt::format("{:.4g} Hz to {:.4g} Hz, {} points, resolution {:.3g} Hz",
                              answer.points.front().frequency_hz, answer.points.back().frequency_hz,
                              answer.points.size(), answer.resolution_hz));
    Line("drive", answer.drive.empty() ? "not recorded" : answer.drive);
    const dsp::SweepPoint& highest = Highest(answer);
    Line("largest", fmt::format("{:.4g} {} amplitude at {:.5g} Hz", highest.amplitude / kUm,
                                ShownUnit(answer), highest.frequency_hz));
  }
  if (answer.resonance) {
    const dsp::SweepResonance& found = *answer.resonance;
    Line("f0", WithInterval(found.fit.frequency_hz, found.frequency_hz, " Hz"));
    Line("Q", WithInterval(found.fit.quality_factor, found.quality_factor, ""));
  }
  for (const std::string& remark : answer.remarks) Line("remark", remark);
  for (const std::string& reason : answer.reasons) Line("not determined", reason);
}

Json SweepJson(const std::string& path, const dsp::SweepAnswer& answer) {
  const bool measured = answer.rate_hz > 0;
  return {{"file", path},
          {"answered", answer.answered},
          {"reasons", answer.reasons},
          {"remarks", answer.remarks},
          {"drive_channel", cli::TextOrNull(answer.drive)},
          {"amplitude_unit", answer.amplitude_unit},
          {"window_s", measured ? Json{answer.window.begin_s, answer.window.end_s} : Json(nullptr)},
          {"sample_rate_hz", measured ? Json(answer.rate_hz) : Json(nullptr)},
          {"resolution_hz", answer.answered ? Json(answer.resolution_hz) : Json(nullptr)},
          {"sensor_averaging", measured ? Json(Describe(answer.sensor)) : Json(nullptr)},
          {"amplitude_verified", answer.amplitude_verified},
          {"resonance", ResonanceJson(answer)},
          {"points", PointsJson(answer)}};
}

std::string SweepCsv(const dsp::SweepAnswer& answer) {
  std::string text = fmt::format("# resolution_hz = {:.9g}\n", answer.resolution_hz);
  if (answer.resonance) {
    fmt::format_to(std::back_inserter(text), "# f0_hz = {:.9g}\n# quality_factor = {:.9g}\n",
                   answer.resonance->fit.frequency_hz, answer.resonance->fit.quality_factor);
  }
  fmt::format_to(std::back_inserter(text), "frequency_hz,{},phase_rad,coherence\n",
                 AmplitudeColumn(answer));
  const auto text_or_nothing = [](const std::optional<double>& number) {
    return number ? fmt::format("{:.9g}", *number) : std::string{};
  };
  for (const dsp::SweepPoint& point : answer.points) {
    fmt::format_to(std::back_inserter(text), "{:.9g},{:.9g},{},{}\n", point.frequency_hz,
                   point.amplitude, text_or_nothing(point.phase_rad),
                   text_or_nothing(point.coherence));
  }
  return text;
}

std::vector<plot::Panel> SweepPanels(const dsp::SweepAnswer& answer) {
  if (answer.points.empty()) return {};
  std::vector<plot::Panel> panels{AmplitudePanel(answer)};
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

}  // namespace haptometer::tools
