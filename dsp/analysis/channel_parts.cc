#include "dsp/analysis/channel_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "dsp/analysis/drive_channel.h"

namespace haptometer::dsp {
namespace {

constexpr double kCellS = 1e-3;
constexpr std::size_t kMostCells = std::size_t{1} << 20U;
constexpr double kStandsOut = 1 / (0.3 * 0.3);  // in power
constexpr double kLeastQuiet = 1e-4;            // of the top's power: a drive that is exactly 0
constexpr double kOn = 0.1;                     // of the top's power
constexpr double kLeastPeriods = 0.3;           // of the lower corner; see the header
constexpr double kLeastTriggerPeriods = 4;

// power of rows at one rate that follow each other
struct StretchPower {
  std::vector<double> cells;
  std::vector<double> means;  // over one period about each cell
  double start_s = 0;
  double cell_s = 0;
  std::size_t reach = 0;  // cells of half a period

  [[nodiscard]] double Time(std::size_t cell) const {
    return start_s + static_cast<double>(cell) * cell_s;
  }
};

// moving means over 2 reach + 1 cells, fewer at the ends
std::vector<double> MovingMeans(const std::vector<double>& cells, std::size_t reach) {
  std::vector<double> sums(cells.size() + 1, 0.0);
  for (std::size_t k = 0; k < cells.size(); ++k) sums[k + 1] = sums[k] + cells[k];
  std::vector<double> means(cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const std::size_t begin = k > reach ? k - reach : 0;
    const std::size_t end = std::min(cells.size(), k + reach + 1);
    means[k] = (sums[end] - sums[begin]) / static_cast<double>(end - begin);
  }
  return means;
}

// of all rows; none for a channel of a few steps, which may be a dead one
Result<std::vector<StretchPower>> PowerOfAll(const trial::RowSource& source, std::size_t channel,
                                             double period_s) {
  const trial::Record& head = source.head();
  std::vector<StretchPower> all;
  bool is_coarse = true;
  for (const trial::Stretch& stretch : head.stretches) {
    if (stretch.rows == 0) continue;
    const auto cell_rows =
        std::max({std::size_t{1}, static_cast<std::size_t>(kCellS * stretch.rate_hz),
                  head.rows / kMostCells});
    auto power = PowerOfRows(source, channel, stretch.first_row, stretch.rows, cell_rows);
    if (!power) return std::unexpected(power.error());
    is_coarse = is_coarse && power->is_coarse;
    StretchPower one;
    one.cells = std::move(power->mean_square);
    one.start_s = stretch.start_s;
    one.cell_s = static_cast<double>(cell_rows) / stretch.rate_hz;
    one.reach = static_cast<std::size_t>(0.5 * period_s / one.cell_s);
    one.means = MovingMeans(one.cells, one.reach);
    all.push_back(std::move(one));
  }
  if (is_coarse) all.clear();
  return all;
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// what separates on from off, in power
struct Levels {
  double top = 0;
  double threshold = 0;
};

// off: the lower one of the medians over the record and over `used`; nothing without a clear top
std::optional<Levels> LevelsOf(const std::vector<StretchPower>& all, const TimeWindow& used) {
  std::vector<double> means;
  std::vector<double> in_used;
  for (const StretchPower& power : all) {
    means.insert(means.end(), power.means.begin(), power.means.end());
    for (std::size_t k = 0; k < power.means.size(); ++k) {
      const double time_s = power.Time(k);
      if (time_s >= used.begin_s && time_s < used.end_s) in_used.push_back(power.means[k]);
    }
  }
  if (means.empty()) return std::nullopt;
  const double top = *std::ranges::max_element(means);
  double quiet = MedianOf(std::move(means));
  if (!in_used.empty()) quiet = std::min(quiet, MedianOf(std::move(in_used)));
  if (!(top > kStandsOut * quiet)) return std::nullopt;
  return Levels{top, std::sqrt(std::max(quiet, kLeastQuiet * top) * top)};
}

// cells [begin, end)
struct Cells {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// the cells among [begin, end) with the largest sum of (power - level), by Kadane's search
Cells MostAbove(std::span<const double> cells, const Cells& among, double level) {
  Cells best{among.begin, among.begin};
  double most = 0;
  double sum = 0;
  std::size_t begin = among.begin;
  for (std::size_t k = among.begin; k < among.end; ++k) {
    sum += cells[k] - level;
    if (sum > most) {
      most = sum;
      best = {begin, k + 1};
    }
    // a negative sum cannot begin the best range
    if (sum <= 0) {
      sum = 0;
      begin = k + 1;
    }
  }
  return best;
}

// windows in which the drive is on, of rows at one rate
std::vector<TimeWindow> PartsOf(const StretchPower& power, const Levels& levels, double least_s) {
  std::vector<TimeWindow> parts;
  const double level = std::max(levels.threshold, kOn * levels.top);
  const auto is_on = [&](double mean) { return mean > levels.threshold; };
  for (std::size_t k = 0; k < power.means.size(); ++k) {
    if (!is_on(power.means[k])) continue;
    std::size_t end = k;
    while (end < power.means.size() && is_on(power.means[end])) ++end;
    // the moving mean blurs the ends by half a period: the true ends lie within that
    const Cells among{k > power.reach ? k - power.reach : 0,
                      std::min(power.cells.size(), end + power.reach)};
    k = end;
    const Cells on = MostAbove(power.cells, among, level);
    // half of the cells must exceed the level: single spikes are no drive
    const auto loud = static_cast<std::size_t>(
        std::count_if(power.cells.begin() + static_cast<std::ptrdiff_t>(on.begin),
                      power.cells.begin() + static_cast<std::ptrdiff_t>(on.end),
                      [&](double cell) { return cell > level; }));
    const TimeWindow part{power.Time(on.begin), power.Time(on.end)};
    if (part.duration_s() >= least_s && 2 * loud >= on.end - on.begin) parts.push_back(part);
  }
  return parts;
}

}  // namespace

Result<std::vector<TimeWindow>> FindChannelParts(const trial::RowSource& source,
                                                 const BandPass& band, const TimeWindow& used) {
  const auto channel = DriveChannel(source.head());
  if (!channel) return std::vector<TimeWindow>{};
  const double period_s = 1 / band.lower_hz;
  const auto all = PowerOfAll(source, *channel, period_s);
  if (!all) return std::unexpected(all.error());
  const auto levels = LevelsOf(*all, used);
  if (!levels) return std::vector<TimeWindow>{};
  const bool is_trigger = source.head().channels[*channel].role == trial::ChannelRole::kTrigger;
  const double least_s = (is_trigger ? kLeastTriggerPeriods : kLeastPeriods) * period_s;
  std::vector<TimeWindow> parts;
  for (const StretchPower& power : *all) {
    for (const TimeWindow& part : PartsOf(power, *levels, least_s)) {
      // a drive that covers all of `used` was not missed
      if (part.begin_s <= used.begin_s && part.end_s >= used.end_s) {
        return std::vector<TimeWindow>{};
      }
      parts.push_back(part);
    }
  }
  return parts;
}

}  // namespace haptometer::dsp
