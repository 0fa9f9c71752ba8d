#include "tools/trial/trial_panel.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.h"

namespace haptometer::tools {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool IsGood(const trial::Channel& channel, std::size_t row) {
  return IsMeasurement(channel.statuses[row]) && std::isfinite(channel.values[row]);
}

// of the measurements; 0 where there is none
double MeanOf(const trial::Channel& channel) {
  double sum = 0;
  double count = 0;
  double first = 0;
  for (std::size_t row = 0; row < channel.values.size(); ++row) {
    if (!IsGood(channel, row)) continue;
    if (count == 0) first = channel.values[row];
    sum += channel.values[row] - first;
    count += 1;
  }
  return count == 0 ? 0 : first + sum / count;
}

// "displacement about 30012.345 um"
std::string Title(const trial::Channel& channel, double mean) {
  if (channel.unit == "m") return fmt::format("{} about {:.3f} um", channel.name, mean * 1e6);
  return fmt::format("{} about {:.6g} {}", channel.name, mean, channel.unit);
}

}  // namespace

plot::Panel PanelOf(const trial::Record& record, const trial::Channel& channel) {
  HAPTOMETER_CHECK(record.rows > 0, "no rows to draw");
  const double factor = channel.unit == "m" ? 1e6 : 1;
  const double mean = MeanOf(channel);
  plot::Series line{.title = "", .style = plot::Lines(plot::kBlue), .x = {}, .y = {}};
  plot::Series bad{
      .title = "",
      .style = {.mark = plot::Mark::kPoints, .colour = plot::kOrange, .size = 0.6, .point = 2},
      .x = {},
      .y = {}};
  double lowest = 0;
  for (const trial::Stretch& stretch : record.stretches) {
    // a row that is not there breaks the line between two stretches
    if (!line.x.empty()) {
      line.x.push_back(stretch.start_s);
      line.y.push_back(kNan);
    }
    for (std::size_t i = 0; i < stretch.rows; ++i) {
      const std::size_t row = stretch.first_row + i;
      const double time_s = stretch.start_s + static_cast<double>(i) / stretch.rate_hz;
      const bool is_good = IsGood(channel, row);
      const double y = is_good ? (channel.values[row] - mean) * factor : kNan;
      line.x.push_back(time_s);
      line.y.push_back(y);
      if (is_good) lowest = std::min(lowest, y);
      if (!is_good) bad.x.push_back(time_s);
    }
  }
  bad.y.assign(bad.x.size(), lowest);
  plot::Panel panel{.title = Title(channel, mean),
                    .x_label = "time / s",
                    .y_label = fmt::format("{} / {}", Name(channel.role),
                                           channel.unit == "m" ? "um" : channel.unit),
                    .series = {std::move(line)}};
  if (!bad.x.empty()) {
    bad.title = fmt::format("{} bad", bad.x.size());
    panel.series.push_back(std::move(bad));
  }
  return panel;
}

}  // namespace haptometer::tools
