#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/analysis/record_facts.h"
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
  return row >= part.first_row && row < part.first_row + part.rows;
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

plot::Panel DistancePanel(const std::vector<double>& times_s, std::span<const double> values,
                          const dsp::BandAnalysis& analysis) {
  const double offset_m = analysis.record.offset_m;
  const auto used = [&](std::size_t row) { return IsInWindow(analysis, row); };
  // excluded rows and those of the window are two lines, grey and blue
  const auto unused = [&](std::size_t row) { return !IsInWindow(analysis, row); };
  return {fmt::format("distance, about {:.5g} um", offset_m / kUm),
          "time / s",
          "distance / um",
          {{"excluded", plot::Lines(plot::kGrey), times_s, Where(values, offset_m, unused)},
           {"window", plot::Lines(plot::kBlue), times_s, Where(values, offset_m, used)}}};
}

// horizontal lines over `windows` at `height`
plot::Series Strip(std::string title, plot::Colour colour, double height,
                   const std::vector<dsp::TimeWindow>& windows) {
  constexpr double kWidth = 8;
  plot::Series series{std::move(title), plot::Lines(colour, kWidth)};
  for (const dsp::TimeWindow& window : windows) {
    series.x.insert(series.x.end(), {window.begin_s, window.end_s, window.end_s});
    // the third point ends the line
    series.y.insert(series.y.end(), {height, height, std::numeric_limits<double>::quiet_NaN()});
  }
  return series;
}

// states of the drive above the window and the intervals of the noise
plot::Panel StatesPanel(const dsp::BandAnalysis& analysis) {
  using enum dsp::DriveState;
  plot::Panel panel{"states of the drive", "time / s", ""};
  panel.y_from_zero = true;
  panel.has_margins = true;
  for (const auto& [state, colour] :
       {std::pair(kOn, plot::kBlue), std::pair(kOff, plot::kGrey),
        std::pair(kTransition, plot::kYellow), std::pair(kArtifact, plot::kOrange)}) {
    std::vector<dsp::TimeWindow> windows;
    for (const dsp::StateInterval& one : analysis.states) {
      if (one.state == state) windows.push_back(one.time);
    }
    if (windows.empty()) continue;
    panel.series.push_back(Strip(std::string(Name(state)), colour, 3, windows));
  }
  if (!analysis.numbers) return panel;
  const dsp::BandNumbers& numbers = *analysis.numbers;
  panel.series.push_back(Strip("window", plot::kBlack, 2, {numbers.part.window}));
  if (numbers.floor && !numbers.floor->quiet.empty()) {
    panel.series.push_back(Strip("noise", plot::kGreen, 1, numbers.floor->quiet));
  }
  return panel;
}

}  // namespace

Result<std::vector<plot::Panel>> AnalysisPanels(const trial::RowSource& rows,
                                                const dsp::BandAnalysis& analysis) {
  const trial::Record& head = rows.head();
  // all rows of the analysed channel, unfiltered
  std::vector<double> values(head.rows);
  std::vector<trial::SampleStatus> statuses(head.rows);
  const auto channel = dsp::AnalyzedChannel(head);
  if (!channel) return std::unexpected(channel.error());
  if (auto read = rows.Read(*channel, 0, values, statuses); !read) {
    return std::unexpected(read.error());
  }
  const std::vector<double> times_s = TimesOf(head);
  std::vector<plot::Panel> panels{DistancePanel(times_s, values, analysis)};
  if (!analysis.states.empty()) panels.push_back(StatesPanel(analysis));
  // without numbers nothing was filtered
  if (!analysis.numbers || analysis.filtered_m.empty()) return panels;

  const auto inside = [&](std::size_t row) { return IsInWindow(analysis, row); };
  const auto outside = [&](std::size_t row) { return !IsInWindow(analysis, row); };
  const std::vector<double> used_um = Where(analysis.filtered_m, 0, inside);
  panels.push_back(
      {fmt::format("{:g}-{:g} Hz: {:.5g} um RMS over the window, as measured",
                   analysis.band.lower_hz, analysis.band.upper_hz,
                   analysis.numbers->rms.as_measured_m / kUm),
       "time / s",
       "in band / um",
       {{"not used", plot::Lines(plot::kGrey), times_s, Where(analysis.filtered_m, 0, outside)},
        {"window", plot::Lines(plot::kBlue), times_s, used_um}}});
  panels.push_back(CloseUp(times_s, used_um, analysis));
  return panels;
}

}  // namespace haptometer::tools
