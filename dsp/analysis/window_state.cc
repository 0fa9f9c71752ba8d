#include "dsp/analysis/window_state.h"

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "dsp/analysis/row_block.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kBeside = 128;  // twice the most taps of a differentiator

std::optional<std::size_t> ChannelIn(const trial::Record& head, trial::ChannelRole role,
                                     std::string_view unit) {
  for (std::size_t k = 0; k < head.channels.size(); ++k) {
    if (head.channels[k].role == role && head.channels[k].unit == unit) return k;
  }
  return std::nullopt;
}

// values of a channel; `unmeasured` counts rows that hold no measurement
Result<std::vector<double>> ReadChannel(const trial::RowSource& source, std::size_t channel,
                                        std::size_t first_row, std::size_t rows,
                                        std::size_t* unmeasured) {
  std::vector<double> values(rows);
  std::vector<trial::SampleStatus> statuses(rows);
  if (auto read = source.Read(channel, first_row, values, statuses); !read) {
    return std::unexpected(read.error());
  }
  for (std::size_t k = 0; k < rows; ++k) *unmeasured += IsMeasured(values[k], statuses[k]) ? 0 : 1;
  return values;
}

}  // namespace

Result<std::optional<Kinematics>> MeasureKinematics(const BandSignal& signal, std::size_t begin,
                                                    std::size_t end, double upper_hz) {
  const std::size_t size = FittedOf(end - begin);
  const std::size_t first = begin + (end - begin - size) / 2;
  // samples beside the window, as far as they are free of transients
  const std::size_t before = std::min(first - signal.settled_begin(), kBeside);
  const std::size_t after = std::min(signal.settled_end() - first - size, kBeside);
  std::vector<double> samples(before + size + after);
  if (auto read = signal.Read(first - before, samples); !read) {
    return std::unexpected(read.error());
  }
  auto motion = DescribeKinematics(samples, signal.rate_hz(), upper_hz, before, before + size);
  if (!motion) return std::nullopt;
  // from samples that were read to rows of the record
  const std::size_t row = signal.first_row() + first - before;
  motion->begin += row;
  motion->end += row;
  return motion;
}

Result<ElectricalFinding> MeasureElectrical(const trial::RowSource& source, std::size_t first_row,
                                            std::size_t rows, double rate_hz, double tone_hz) {
  const auto voltage = ChannelIn(source.head(), trial::ChannelRole::kVoltage, "V");
  const auto current = ChannelIn(source.head(), trial::ChannelRole::kCurrent, "A");
  if (!voltage || !current) return ElectricalFinding{};
  const std::size_t size = std::min(rows, kMostFitted);
  const std::size_t first = first_row + (rows - size) / 2;
  std::size_t unmeasured = 0;
  const auto volts = ReadChannel(source, *voltage, first, size, &unmeasured);
  if (!volts) return std::unexpected(volts.error());
  const auto amperes = ReadChannel(source, *current, first, size, &unmeasured);
  if (!amperes) return std::unexpected(amperes.error());
  // every row is required: a sine fit at uniform times has no gaps
  if (unmeasured > 0) {
    return ElectricalFinding{std::nullopt, Finding{.kind = FindingKind::kElectricalUnmeasured,
                                                   .numbers = {{"readings", unmeasured}}}};
  }
  ElectricalFinding found{DescribeElectrical(*volts, *amperes, rate_hz, tone_hz), {}};
  if (!found.state) {
    found.why_not = {.kind = FindingKind::kElectricalNoTone,
                     .numbers = {{"frequency_hz", tone_hz}}};
  }
  return found;
}

}  // namespace haptometer::dsp
