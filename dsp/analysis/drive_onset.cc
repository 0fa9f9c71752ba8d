#include "dsp/analysis/drive_onset.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/row_block.h"
#include "dsp/spectrum/envelope.h"

namespace haptometer::dsp {
namespace {

// longest quiet and steady side about the onset
constexpr double kLongestSideS = 1;
// level of the drive at its begin, as a part of its steady maximum
constexpr double kDriveLevel = 0.1;
constexpr double kNoisesBelowDrive = 2;  // times the largest reading without drive
// above this level noise covers the begin
constexpr double kHighestDriveLevel = 0.5;

// samples of a signal: quiet, the rise, steady
struct Around {
  std::size_t begin = 0;
  std::size_t quiet_end = 0;
  std::size_t steady_begin = 0;
  std::size_t end = 0;
};

std::size_t SampleAt(const BandSignal& signal, double time_s) {
  const double sample = std::round((time_s - signal.start_s()) * signal.rate_hz());
  return static_cast<std::size_t>(std::clamp(sample, 0.0, static_cast<double>(signal.size())));
}

// the last quiet part before the drive, the rise, the first second of the steady part
std::optional<Around> AroundOnset(const ChosenPart& chosen) {
  const OnPart* on = chosen.part.drive.Longest();
  if (!chosen.part.from_drive || on == nullptr) return std::nullopt;
  const TimeWindow* before = nullptr;
  for (const TimeWindow& quiet : chosen.part.drive.quiet) {
    if (quiet.end_s <= on->whole.begin_s) before = &quiet;
  }
  if (before == nullptr) return std::nullopt;
  const double quiet_s = std::max(before->begin_s, before->end_s - kLongestSideS);
  const double steady_s = std::min(on->steady.end_s, on->steady.begin_s + kLongestSideS);
  const BandSignal& signal = *chosen.signal;
  return Around{SampleAt(signal, quiet_s), SampleAt(signal, before->end_s),
                SampleAt(signal, on->steady.begin_s), SampleAt(signal, steady_s)};
}

// a drive's readings around the onset
struct Drive {
  std::vector<double> values;  // NaN: none
  bool turns = false;          // a voltage or a current goes through zero, a trigger does not

  // the largest distance from `rest` in a range
  [[nodiscard]] double Farthest(std::size_t begin, std::size_t end, double rest) const {
    double farthest = 0;
    for (std::size_t k = begin; k < end; ++k) {
      if (!std::isnan(values[k])) farthest = std::max(farthest, std::abs(values[k] - rest));
    }
    return farthest;
  }
};

Result<std::optional<Drive>> ReadDrive(const trial::RowSource& source, std::size_t first_row,
                                       std::size_t rows) {
  const auto channel = DriveChannel(source.head());
  if (!channel) return std::nullopt;
  Drive drive;
  drive.values.resize(rows);
  drive.turns = source.head().channels[*channel].role != trial::ChannelRole::kTrigger;
  std::vector<trial::SampleStatus> statuses(rows);
  if (auto read = source.Read(*channel, first_row, drive.values, statuses); !read) {
    return std::unexpected(read.error());
  }
  for (std::size_t k = 0; k < rows; ++k) {
    if (!IsMeasured(drive.values[k], statuses[k])) drive.values[k] = std::nan("");
  }
  return drive;
}

double MeanOf(std::span<const double> values) {
  double sum = 0;
  std::size_t count = 0;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

// when the drive began, in samples of the drive: it did within this range
struct Beginning {
  double sample = 0;
  double half_width = 0;
};

// the first sample beyond 10 % of the drive, or beyond twice its largest value at rest
std::optional<Beginning> BeginningOf(const Drive& drive, const Around& around,
                                     double samples_a_period) {
  const std::size_t quiet = around.quiet_end - around.begin;
  const std::size_t steady = around.steady_begin - around.begin;
  const double rest = MeanOf(std::span(drive.values).first(quiet));
  const double level = drive.Farthest(steady, drive.values.size(), rest);
  const double limit =
      std::max(kDriveLevel * level, kNoisesBelowDrive * drive.Farthest(0, quiet, rest));
  if (!(limit > 0 && limit <= kHighestDriveLevel * level)) return std::nullopt;
  for (std::size_t k = quiet; k < steady; ++k) {
    if (!(std::abs(drive.values[k] - rest) > limit)) continue;
    // a sine of unknown phase may begin at zero: asin(limit / level) / pi periods up to the limit
    const double turn = drive.turns ? std::asin(limit / level) / std::numbers::pi : 0;
    // one sample and that time: the drive began within it
    const double width = 1 + turn * samples_a_period;
    return Beginning{static_cast<double>(k) - 0.5 * width, 0.5 * width};
  }
  return std::nullopt;
}

}  // namespace

Result<std::optional<OnsetNumbers>> FindDriveOnset(const trial::RowSource& source,
                                                   const ChosenPart& chosen, double tone_hz) {
  const auto around = AroundOnset(chosen);
  if (!around) return std::nullopt;
  const BandSignal& signal = *chosen.signal;
  const double rate_hz = signal.rate_hz();
  // samples before the filter: the filter would ring ahead of the onset
  std::vector<double> samples(around->end - around->begin);
  if (auto read = signal.samples().Read(around->begin, samples); !read) {
    return std::unexpected(read.error());
  }
  const Envelope envelope = DemodulateTone(samples, {rate_hz, tone_hz});
  const auto seconds = [&](std::size_t sample) {
    return static_cast<double>(sample - around->begin) / rate_hz;
  };
  if (envelope.amplitude.empty()) return std::nullopt;
  // the first and the last half window have no envelope
  const double last_s =
      envelope.start_s + static_cast<double>(envelope.amplitude.size() - 1) * envelope.step_s;
  auto edge = FindOnset(envelope, {envelope.start_s, seconds(around->quiet_end),
                                   seconds(around->steady_begin), last_s});
  if (!edge) return std::nullopt;

  const double begin_s = TimeOfSample(signal, around->begin);
  OnsetNumbers onset;
  onset.edge = *edge;
  onset.edge.time_s += begin_s;
  const auto drive = ReadDrive(source, signal.first_row() + around->begin, samples.size());
  if (!drive) return std::unexpected(drive.error());
  if (!*drive) return onset;
  const auto beginning = BeginningOf(**drive, *around, rate_hz / tone_hz);
  if (!beginning) return onset;
  onset.drive_s = begin_s + beginning->sample / rate_hz;
  // rectangular distribution: half width / sqrt(3)
  onset.drive_uncertainty_s = beginning->half_width / rate_hz / std::numbers::sqrt3;
  onset.latency_s = onset.edge.time_s - *onset.drive_s;
  onset.latency_uncertainty_s =
      std::hypot(onset.edge.time_uncertainty_s, onset.drive_uncertainty_s);
  return onset;
}

}  // namespace haptometer::dsp
