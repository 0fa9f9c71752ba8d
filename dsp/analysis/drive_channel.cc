#include "dsp/analysis/drive_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace haptometer::dsp {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16U;

// visits values of rows [first, first + size)
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

}  // namespace

std::optional<std::size_t> DriveChannel(const trial::Record& head) {
  for (const trial::ChannelRole role :
       {trial::ChannelRole::kVoltage, trial::ChannelRole::kCurrent, trial::ChannelRole::kTrigger}) {
    if (const trial::Channel* channel = head.Find(role)) {
      return static_cast<std::size_t>(channel - head.channels.data());
    }
  }
  return std::nullopt;
}

Result<std::vector<double>> DriveCells(const trial::RowSource& source, std::size_t channel,
                                       const BandSignal& signal, std::size_t begin,
                                       std::size_t end) {
  const std::size_t cell = signal.cell_samples();
  const std::size_t first = signal.first_row() + begin * cell;
  const std::size_t size = std::min(end * cell, signal.size()) - begin * cell;
  double least = 0;
  if (source.head().channels[channel].role == trial::ChannelRole::kTrigger) {
    least = std::numeric_limits<double>::infinity();
    const auto seen = ForEachValue(source, channel, first, size, [&](std::size_t, double value) {
      if (std::isfinite(value)) least = std::min(least, value);
    });
    if (!seen) return std::unexpected(seen.error());
  }
  std::vector<double> cells(end - begin, 0.0);
  const auto seen = ForEachValue(source, channel, first, size, [&](std::size_t k, double value) {
    const double x = std::isfinite(value) ? value - least : 0;
    cells[k / cell] += x * x / static_cast<double>(cell);
  });
  if (!seen) return std::unexpected(seen.error());
  return cells;
}

}  // namespace haptometer::dsp
