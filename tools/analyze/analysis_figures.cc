#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/analysis/record_facts.h"
#include "dsp/readings/faults.h"
#include "tools/analyze/analyze.h"
#include "trial/record.h"

namespace haptometer::tools {
namespace {

constexpr double kUm = 1e-6;  // in metres

// `values` in um about `offset_m` where `keep` holds, NaN elsewhere: a gap in the line
template <typename Keep>
std::vector<double> Where(std::span<const double> values, double offset_m, const Keep& keep) {
  std::vector<double> shown(values.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (keep(row)) shown[row] = (values[row] - offset_m) / kUm;
  }
  return shown;
}

std::vector<double> TimesOf(const trial::Record& head) {
  std::vector<double> times_s(head.rows);
  for (std::size_t row = 0; row < head.rows; ++row) times_s[row] = TimeOf(head, row);
  return times_s;
}

// rows that the numbers are of
bool IsInWindow(const dsp::BandAnalysis& analysis, std::size_t row) {
  if (!analysis.numbers) return false;
  const dsp::UsedPart& part = analysis.numbers->part;
  if (row < part.first_row || row >= part.first_row + part.rows) return false;
  const double time_s =
      part.window.begin_s + static_cast<double>(row - part.first_row) / analysis.record.rate_hz;
  return std::ranges::none_of(analysis.numbers->excluded, [&](const dsp::TimeWindow& bump) {
    return time_s >= bump.begin_s && time_s < bump.end_s;
  });
}

// ten periods of the tone (or all of the window) in the middle of the window
plot::Panel CloseUp(const std::vector<double>& times_s, const std::vector<double>& filtered_um,
                    const dsp::BandAnalysis& analysis) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  std::size_t rows = numbers.part.rows;
  if (numbers.tone) {
    const double ten_periods =
        std::ceil(10 * analysis.record.rate_hz / numbers.tone->fit.frequency_hz);
    rows = std::min(rows, static_cast<std::size_t>(ten_periods));
  }
  const auto first =
      static_cast<std::ptrdiff_t>(numbers.part.first_row + (numbers.part.rows - rows) / 2);
  const auto last = first + static_cast<std::ptrdiff_t>(rows);
  return {"a part of the window",
          "time / s",
          "in band / um",
          {{"",
            plot::Lines(plot::kBlue),
            {times_s.begin() + first, times_s.begin() + last},
            {filtered_um.begin() + first, filtered_um.begin() + last}}}};
}

// what is drawn: rows of the analysed channel, their times, and the least and greatest value of
// those that are no artifacts, um about the offset
struct Rows {
  const dsp::BandAnalysis& analysis;
  std::vector<double> times_s;
  std::vector<double> values;
  std::vector<trial::SampleStatus> statuses;
  double least_um = 0;
  double most_um = 0;

  [[nodiscard]] bool IsMeasured(std::size_t row) const {
    return trial::IsMeasurement(statuses[row]) && std::isfinite(values[row]);
  }
  [[nodiscard]] double Um(std::size_t row) const {
    return (values[row] - analysis.record.offset_m) / kUm;
  }
  // whether it was filtered although there is no measurement
  [[nodiscard]] bool IsInterpolated(std::size_t row) const {
    return row < analysis.filtered_m.size() && std::isfinite(analysis.filtered_m[row]);
  }
  [[nodiscard]] std::pair<double, double> Range() const {
    return {times_s.front(), times_s.back()};
  }
};

// rows that are spikes or short holds: no measurements, although they say so
std::vector<bool> SpikesOf(const dsp::BandAnalysis& analysis, std::size_t rows) {
  std::vector<bool> spikes(rows, false);
  for (const dsp::Fault& fault : analysis.faults.list) {
    if (fault.kind != dsp::FaultKind::kSpike) continue;
    for (std::size_t k = 0; k < fault.rows && fault.first_row + k < rows; ++k) {
      spikes[fault.first_row + k] = true;
    }
  }
  return spikes;
}

// range of the rows that are measurements and no spikes
void FindRange(Rows& rows) {
  const std::vector<bool> spikes = SpikesOf(rows.analysis, rows.values.size());
  bool any = false;
  for (std::size_t row = 0; row < rows.values.size(); ++row) {
    if (!rows.IsMeasured(row) || spikes[row]) continue;
    rows.least_um = any ? std::min(rows.least_um, rows.Um(row)) : rows.Um(row);
    rows.most_um = any ? std::max(rows.most_um, rows.Um(row)) : rows.Um(row);
    any = true;
  }
}

// points of rows that are artifacts; those beyond the axis are drawn at its end
plot::Series MarksOf(std::string title, plot::Colour colour, int point) {
  plot::Series series{std::move(title), plot::Points(colour, 0.8)};
  series.style.point = point;
  return series;
}

void AddMark(const Rows& rows, std::size_t row, plot::Series& series) {
  if (row >= rows.times_s.size()) return;
  series.x.push_back(rows.times_s[row]);
  const double um = rows.IsMeasured(row) ? rows.Um(row) : rows.least_um;
  series.y.push_back(std::clamp(um, rows.least_um, rows.most_um));
}

// one series for each kind of artifact that the record has
std::vector<plot::Series> ArtifactMarks(const Rows& rows) {
  constexpr std::array<std::string_view, dsp::kFaultKindCount> kTitles{"clipped", "held",
                                                                       "spike (excluded)", "step"};
  constexpr std::array<plot::Colour, dsp::kFaultKindCount> kColours{plot::kOrange, plot::kYellow,
                                                                    plot::kOrange, plot::kBlack};
  constexpr std::array<int, dsp::kFaultKindCount> kPoints{7, 4, 2, 8};
  std::vector<plot::Series> marks;
  for (std::size_t kind = 0; kind < dsp::kFaultKindCount; ++kind) {
    plot::Series series = MarksOf(std::string(kTitles[kind]), kColours[kind], kPoints[kind]);
    for (const dsp::Fault& fault : rows.analysis.faults.list) {
      if (static_cast<std::size_t>(fault.kind) != kind) continue;
      for (std::size_t k = 0; k < std::max<std::size_t>(1, fault.rows); ++k) {
        AddMark(rows, fault.first_row + k, series);
      }
    }
    if (!series.x.empty()) marks.push_back(std::move(series));
  }
  // rows without a measurement, at the lower end
  plot::Series filled = MarksOf("interpolated", plot::kPurple, 6);
  plot::Series missing = MarksOf("no measurement", plot::kBlack, 3);
  for (std::size_t row = 0; row < rows.values.size(); ++row) {
    if (!rows.IsMeasured(row)) AddMark(rows, row, rows.IsInterpolated(row) ? filled : missing);
  }
  for (plot::Series* series : {&filled, &missing}) {
    if (!series->x.empty()) marks.push_back(std::move(*series));
  }
  return marks;
}

// intervals of x for shading
std::vector<std::pair<double, double>> IntervalsOf(const std::vector<dsp::TimeWindow>& windows) {
  std::vector<std::pair<double, double>> intervals;
  intervals.reserve(windows.size());
  for (const dsp::TimeWindow& one : windows) intervals.emplace_back(one.begin_s, one.end_s);
  return intervals;
}

// What is filtered and in no state: transients of the filter at the ends of each segment.
std::vector<dsp::TimeWindow> TransientsOf(const Rows& rows) {
  const std::vector<double>& filtered = rows.analysis.filtered_m;
  std::vector<dsp::TimeWindow> transients;
  if (rows.analysis.states.empty()) return transients;
  const auto in_state = [&](double time_s) {
    return std::ranges::any_of(rows.analysis.states, [&](const dsp::StateInterval& state) {
      return time_s >= state.time.begin_s && time_s < state.time.end_s;
    });
  };
  const double row_s = 1 / rows.analysis.record.rate_hz;
  for (std::size_t row = 0; row < filtered.size(); ++row) {
    const double time_s = rows.times_s[row];
    if (!std::isfinite(filtered[row]) || in_state(time_s)) continue;
    const bool goes_on = !transients.empty() && time_s - transients.back().end_s < row_s;
    if (!goes_on) transients.push_back({time_s, time_s});
    transients.back().end_s = time_s + row_s;
  }
  return transients;
}

std::vector<plot::Shade> ShadesOf(const Rows& rows) {
  std::vector<plot::Shade> shades{
      {"filter transient (excluded)", plot::kGrey, IntervalsOf(TransientsOf(rows))}};
  if (!rows.analysis.numbers) return shades;
  const dsp::BandNumbers& numbers = *rows.analysis.numbers;
  shades.push_back({"window", plot::kSkyBlue, IntervalsOf({numbers.part.window})});
  if (numbers.floor) shades.push_back({"noise", plot::kGreen, IntervalsOf(numbers.floor->quiet)});
  shades.push_back({"bump (excluded)", plot::kOrange, IntervalsOf(numbers.excluded)});
  return shades;
}

plot::Panel DistancePanel(const Rows& rows) {
  const double offset_m = rows.analysis.record.offset_m;
  const std::vector<bool> spikes = SpikesOf(rows.analysis, rows.values.size());
  const auto is_shown = [&](std::size_t row) { return rows.IsMeasured(row) && !spikes[row]; };
  const auto used = [&](std::size_t row) {
    return is_shown(row) && IsInWindow(rows.analysis, row);
  };
  // rows outside of the window and those in it are two lines, grey and blue
  const auto unused = [&](std::size_t row) {
    return is_shown(row) && !IsInWindow(rows.analysis, row);
  };
  plot::Panel panel{
      fmt::format("distance, about {:g} um", std::round(10 * offset_m / kUm) / 10 + 0.0),
      "time / s",
      "distance / um",
      {{"not used", plot::Lines(plot::kDarkGrey), rows.times_s,
        Where(rows.values, offset_m, unused)},
       {"used", plot::Lines(plot::kBlue), rows.times_s, Where(rows.values, offset_m, used)}}};
  for (plot::Series& marks : ArtifactMarks(rows)) panel.series.push_back(std::move(marks));
  panel.shades = ShadesOf(rows);
  panel.x_range = rows.Range();
  return panel;
}

// level of each state, as RMS of the filtered samples, in the state's colour
plot::Panel StatesPanel(const Rows& rows) {
  using enum dsp::DriveState;
  plot::Panel panel{"states of the drive: RMS of the filtered samples in each", "time / s",
                    "RMS / um"};
  panel.y_from_zero = true;
  const double gap = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [state, colour] : {std::pair(kOn, plot::kBlue), std::pair(kOff, plot::kDarkGrey),
                                      std::pair(kTransition, plot::kYellow)}) {
    plot::Series series{std::string(Name(state)), plot::Lines(colour, 8)};
    for (const dsp::StateInterval& one : rows.analysis.states) {
      if (one.state != state) continue;
      const double rms_um = one.rms_m / kUm;
      // the third point ends the line
      series.x.insert(series.x.end(), {one.time.begin_s, one.time.end_s, one.time.end_s});
      series.y.insert(series.y.end(), {rms_um, rms_um, gap});
    }
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  }
  panel.shades = ShadesOf(rows);
  panel.x_range = rows.Range();
  return panel;
}

// samples behind the filter, used and not, with what is excluded
plot::Panel FilteredPanel(const Rows& rows, const std::vector<double>& used_um) {
  const dsp::BandAnalysis& analysis = rows.analysis;
  const auto outside = [&](std::size_t row) { return !IsInWindow(analysis, row); };
  const dsp::RmsEstimate& rms = analysis.numbers->rms;
  plot::Panel panel{fmt::format("{:g}-{:g} Hz: {} um RMS over the window, as measured",
                                analysis.band.lower_hz, analysis.band.upper_hz,
                                document::NumberText(rms.as_measured_m / kUm,
                                                     rms.standard_uncertainty_m / kUm, 0, 5)),
                    "time / s",
                    "in band / um",
                    {{"not used", plot::Lines(plot::kDarkGrey), rows.times_s,
                      Where(analysis.filtered_m, 0, outside)},
                     {"used", plot::Lines(plot::kBlue), rows.times_s, used_um}}};
  panel.shades = ShadesOf(rows);
  panel.x_range = rows.Range();
  return panel;
}

}  // namespace

Result<std::vector<plot::Panel>> AnalysisPanels(const trial::RowSource& source,
                                                const dsp::BandAnalysis& analysis) {
  const trial::Record& head = source.head();
  // all rows of the analysed channel, unfiltered
  Rows rows{.analysis = analysis,
            .times_s = TimesOf(head),
            .values = std::vector<double>(head.rows),
            .statuses = std::vector<trial::SampleStatus>(head.rows)};
  HAPTOMETER_LET(const auto channel, dsp::AnalyzedChannel(head));
  HAPTOMETER_TRY(source.Read(channel, 0, rows.values, rows.statuses));
  FindRange(rows);
  std::vector<plot::Panel> panels{DistancePanel(rows)};
  if (!analysis.states.empty()) panels.push_back(StatesPanel(rows));
  // without numbers nothing was filtered
  if (!analysis.numbers || analysis.filtered_m.empty()) return panels;
  const auto inside = [&](std::size_t row) { return IsInWindow(analysis, row); };
  const std::vector<double> used_um = Where(analysis.filtered_m, 0, inside);
  panels.push_back(FilteredPanel(rows, used_um));
  panels.push_back(CloseUp(rows.times_s, used_um, analysis));
  return panels;
}

}  // namespace haptometer::tools
