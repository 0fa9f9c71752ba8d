#include "dsp/analysis/drive_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace haptometer::dsp {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16U;
// a value near the border of two digits flickers between these, with noise of half a digit between
// three
constexpr double kCoarseSteps = 2.000001;
constexpr double kRounding = 1.000001;  // what the products of decimal digits are off by, and more

// visits values of rows [first, first + size), block by block
template <typename Visit>
Result<void> ForEachValue(const trial::RowSource& source, std::size_t channel, std::size_t first,
                          std::size_t size, const Visit& visit) {
  std::vector<double> values(std::min(size, kBlock));
  std::vector<trial::SampleStatus> statuses(values.size());
  for (std::size_t done = 0; done < size; done += values.size()) {
    const std::size_t count = std::min(values.size(), size - done);
    const auto read = source.Read(channel, first + done, std::span(values).first(count),
                                  std::span(statuses).first(count));
    if (!read) return read;
    for (std::size_t k = 0; k < count; ++k) visit(done + k, values[k]);
  }
  return {};
}

// range of a channel's values, and the least change from row to row
struct Steps {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double step = std::numeric_limits<double>::infinity();  // the least change from row to row
  double before = std::numeric_limits<double>::quiet_NaN();

  void See(double value) {
    if (!std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
    const double change = std::abs(value - before);
    if (change > 0) step = std::min(step, change);
    before = value;
  }
};

}  // namespace

// a voltage before a current before a trigger
std::optional<std::size_t> DriveChannel(const trial::Record& head) {
  for (const trial::ChannelRole role :
       {trial::ChannelRole::kVoltage, trial::ChannelRole::kCurrent, trial::ChannelRole::kTrigger}) {
    if (const trial::Channel* channel = head.Find(role)) {
      return static_cast<std::size_t>(channel - head.channels.data());
    }
  }
  return std::nullopt;
}

Result<DrivePower> PowerOfRows(const trial::RowSource& source, std::size_t channel,
                               std::size_t first, std::size_t rows, std::size_t cell_rows) {
  const trial::Channel& of = source.head().channels[channel];
  const bool is_trigger = of.role == trial::ChannelRole::kTrigger;
  // a trigger's rest level is the least value over all rows, not only over those in question
  Steps steps;
  if (is_trigger) {
    const auto seen = ForEachValue(source, channel, 0, source.head().rows,
                                   [&](std::size_t, double value) { steps.See(value); });
    if (!seen) return std::unexpected(seen.error());
  }
  const double rest = is_trigger ? steps.least : 0;
  DrivePower power;
  power.mean_square.resize((rows + cell_rows - 1) / cell_rows, 0.0);
  const auto seen = ForEachValue(source, channel, first, rows, [&](std::size_t k, double value) {
    steps.See(value);
    const double x = std::isfinite(value) ? value - rest : 0;
    power.mean_square[k / cell_rows] += x * x / static_cast<double>(cell_rows);
  });
  if (!seen) return std::unexpected(seen.error());
  if (is_trigger) return power;
  // without a stated resolution the least change is taken as one step
  const double step = of.resolution > 0 ? of.resolution : steps.step;
  power.is_coarse = steps.most - steps.least <= kCoarseSteps * step;
  if (power.is_coarse) return power;
  // one step about zero is noise of the last digit: the drive is exactly 0 there
  for (double& cell : power.mean_square) {
    if (cell <= kRounding * step * step) cell = 0;
  }
  return power;
}

Result<DrivePower> DriveCells(const trial::RowSource& source, std::size_t channel,
                              const BandSignal& signal, std::size_t begin, std::size_t end) {
  const std::size_t cell = signal.cell_samples();
  const std::size_t rows = std::min(end * cell, signal.size()) - begin * cell;
  return PowerOfRows(source, channel, signal.first_row() + begin * cell, rows, cell);
}

}  // namespace haptometer::dsp
