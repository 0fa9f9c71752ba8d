#include "dsp/analysis/drive_channel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "base/mapped.h"
#include "base/median.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/readings/row_block.h"
#include "dsp/readings/segments.h"
#include "dsp/spectrum/envelope.h"
#include "dsp/spectrum/power_edges.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {

namespace {

// a value near the border of two digits flickers between these, with noise of half a digit between
// three
constexpr double kCoarseSteps = 2.000001;
constexpr double kRounding = 1.000001;  // what the products of decimal digits are off by, and more

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

// Mean squares of a channel over cells of rows that follow each other.
struct DrivePower {
  std::vector<double> mean_square;
  // Whether its values span two steps of its resolution at most: a dead channel whose last digit
  // flickers, or one that only says on and off. Only the displacement can tell these apart.
  bool is_coarse = false;
};

// Of the rows of `signal`, by its cells.
//
// A trigger counts from its least value of all rows, and is never coarse. A voltage's or current's
// step is what the channel states, else the least difference of rows that follow each other; a cell
// whose mean square is below one step's is 0 (unless all of it is coarse): what flickers by its
// last digit stands out of exact zeros by any factor.
Result<DrivePower> PowerOf(const trial::RowSource& source, std::size_t channel,
                           const BandSignal& signal) {
  const std::size_t cell_rows = signal.cell_samples();
  const trial::Channel& of = source.head().channels[channel];
  const bool is_trigger = of.role == trial::ChannelRole::kTrigger;
  // a trigger's rest level is the least value over all rows, not only over those in question
  Steps steps;
  if (is_trigger) {
    HAPTOMETER_TRY(ForEachValue(source, channel, 0, source.head().rows,
                                [&](std::size_t, double value, auto) { steps.See(value); }));
  }
  const double rest = is_trigger ? steps.least : 0;
  DrivePower power;
  power.mean_square.resize(signal.cells().size(), 0.0);
  const auto see = [&](std::size_t k, double value, auto) {
    steps.See(value);
    const double x = std::isfinite(value) ? value - rest : 0;
    power.mean_square[k / cell_rows] += x * x / static_cast<double>(cell_rows);
  };
  HAPTOMETER_TRY(ForEachValue(source, channel, signal.first_row(), signal.size(), see));
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

// differences of corresponding edges: the nearest of the same kind
std::vector<PowerEdge> Differences(std::span<const PowerEdge> drive,
                                   std::span<const PowerEdge> motion) {
  std::vector<PowerEdge> differences;
  for (const PowerEdge& edge : drive) {
    PowerEdge best{kLongestDelayS, edge.rises, -1};
    for (const PowerEdge& other : motion) {
      const double difference = other.time_s - edge.time_s;
      if (other.rises != edge.rises || std::abs(difference) > std::abs(best.time_s)) continue;
      best = {difference, edge.rises, std::hypot(edge.uncertainty_s, other.uncertainty_s)};
    }
    if (best.uncertainty_s >= 0) differences.push_back(best);
  }
  return differences;
}

// median of the differences, with its uncertainty or that of their scatter
DriveDelay DelayOf(const std::vector<PowerEdge>& differences) {
  const double median = Median(Mapped(differences, &PowerEdge::time_s));
  const auto n = static_cast<double>(differences.size());
  double variance = 0;
  double chi_square = 0;
  for (const PowerEdge& one : differences) {
    variance += one.uncertainty_s * one.uncertainty_s / (n * n);
    chi_square += std::pow((one.time_s - median) / one.uncertainty_s, 2);
  }
  if (n > 2) variance *= std::numbers::pi / 2;
  // Birge's ratio, where chance gives more scatter in 5 % only
  if (n > 1 && chi_square > ChiSquareQuantile(kConfidence, n - 1)) variance *= chi_square / (n - 1);
  return {median, std::sqrt(variance), differences.size()};
}

std::vector<double> MeanSquares(const BandSignal& signal) {
  std::vector<double> squares;
  squares.reserve(signal.cells().size());
  for (const BandCell& cell : signal.cells()) {
    squares.push_back(cell.square_sum / static_cast<double>(signal.cell_samples()));
  }
  return squares;
}

// The power of the channel behind the filter, whose changes the filter moves as the vibration's;
// nothing where most of its power is not in the band: a trigger, a level.
Result<std::optional<std::vector<double>>> FilteredPower(const trial::RowSource& source,
                                                         std::size_t channel,
                                                         const BandSignal& signal, double power) {
  // what was interpolated is displacement
  Segment segment = signal.segment();
  segment.bridges.clear();
  HAPTOMETER_LET(const auto filtered,
                 BandSignal::Filter({source, channel, segment}, signal.design(), 1));
  std::vector<double> squares = MeanSquares(filtered);
  const double in_band = std::accumulate(squares.begin(), squares.end(), 0.0);
  return in_band > 0.5 * power ? std::optional(std::move(squares)) : std::nullopt;
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

Result<ChannelCourse> FollowChannel(const trial::RowSource& source, std::size_t channel,
                                    const BandSignal& signal, const BandPass& band,
                                    double tone_hz) {
  const std::size_t cells = signal.cells().size();
  HAPTOMETER_LET(const auto drive, PowerOf(source, channel, signal));
  const PowerCells shape{.start_s = signal.start_s(),
                         .cell_s = static_cast<double>(signal.cell_samples()) / signal.rate_hz(),
                         .window_s = 1 / band.lower_hz,
                         .bandwidth_hz = band.upper_hz - band.lower_hz};
  const std::vector<PowerEdge> edges = PowerEdges(drive.mean_square, shape);
  ChannelCourse course;
  // on from each rise to the next fall; without edges on throughout, if there is any power
  const double end_s = shape.start_s + static_cast<double>(cells) * shape.cell_s;
  const double power = std::accumulate(drive.mean_square.begin(), drive.mean_square.end(), 0.0);
  if (power > 0 && (edges.empty() || !edges.front().rises)) {
    course.on.push_back({shape.start_s, end_s});
  }
  for (const PowerEdge& edge : edges) {
    if (edge.rises) course.on.push_back({edge.time_s, end_s});
    if (!edge.rises) course.on.back().end_s = edge.time_s;
  }
  const std::vector<double> motion = MeanSquares(signal);
  const std::vector<PowerEdge> of_motion = PowerEdges(motion, shape);
  // of a channel of two levels only the displacement says whether it is a drive or flickers
  const bool flickers = edges.size() > 2 * of_motion.size();
  if (drive.is_coarse && (flickers || Differences(edges, of_motion).empty())) {
    course.on = {{shape.start_s, end_s}};
    return course;
  }
  if (edges.empty()) return course;
  // changes of both, refined
  HAPTOMETER_LET(const auto filtered, FilteredPower(source, channel, signal, power));
  const double of_phase_s = 1 / (4 * std::numbers::pi * tone_hz * std::numbers::sqrt2);
  const double apart_hz = 1 / (1 / std::max(tone_hz - band.lower_hz, band.lower_hz) +
                               1 / std::max(band.upper_hz - tone_hz, band.lower_hz));
  const double unknown_s =
      filtered ? of_phase_s : 1 / (4 * std::pow(std::numbers::pi, 2) * apart_hz);
  const auto of_drive =
      RefinedEdges(filtered ? *filtered : drive.mean_square, shape, unknown_s, edges);
  const auto differences =
      Differences(of_drive, RefinedEdges(motion, shape, of_phase_s, of_motion));
  if (!differences.empty()) course.delay = DelayOf(differences);
  return course;
}

namespace {

// samples of `chosen` within `window`
void CutTo(const TimeWindow& window, ChosenPart& chosen) {
  const auto [begin, end] = SettledWithin(*chosen.signal, window);
  chosen.begin = std::max(chosen.begin, begin);
  chosen.end = std::min(chosen.end, end);
  std::erase_if(chosen.excluded, [&](const auto& one) {
    return one.second <= chosen.begin || one.first >= chosen.end;
  });
}

}  // namespace

Result<void> FollowDrive(const trial::RowSource& source, bool may_cut, ChosenPart& chosen,
                         BandAnalysis* analysis) {
  const auto channel = DriveChannel(source.head());
  if (!channel || !chosen.part.from_drive) return {};
  const double tone_hz = 0.5 * (chosen.part.state.from_hz + chosen.part.state.to_hz);
  HAPTOMETER_LET(const auto course,
                 FollowChannel(source, *channel, *chosen.signal, analysis->band, tone_hz));
  chosen.delay = course.delay;
  const DriveDelay delay = course.delay.value_or(DriveDelay{});
  if (std::abs(delay.delay_s) > 1 / analysis->band.lower_hz) {
    analysis->findings.Note(FindingKind::kDriveDelayed,
                            {{"delay_s", delay.delay_s}, {"uncertainty_s", delay.uncertainty_s}});
  }
  // the longest interval on, so much later, within the part
  const TimeWindow part{TimeOfSample(*chosen.signal, chosen.begin),
                        TimeOfSample(*chosen.signal, chosen.end)};
  TimeWindow longest{part.begin_s, part.begin_s};
  double on_s = 0;
  for (const TimeWindow& on : course.on) {
    const TimeWindow shared{std::max(part.begin_s, on.begin_s + delay.delay_s),
                            std::min(part.end_s, on.end_s + delay.delay_s)};
    on_s += std::max(0.0, shared.duration_s());
    if (shared.duration_s() > longest.duration_s()) longest = shared;
  }
  // beside a change the filter rings for a period of the lower corner
  const double period_s = 1 / analysis->band.lower_hz;
  if (part.duration_s() - on_s <= period_s) return {};
  analysis->findings.Add({.severity = Severity::kDoubt,
                          .kind = FindingKind::kDriveContradicted,
                          .numbers = {{"off_s", part.duration_s() - on_s},
                                      {"from_s", part.begin_s},
                                      {"to_s", part.end_s}},
                          .subject = source.head().channels[*channel].name});
  if (!may_cut || longest.duration_s() < kMajority * part.duration_s()) return {};
  if (longest.begin_s > part.begin_s) longest.begin_s += period_s;
  if (longest.end_s < part.end_s) longest.end_s -= period_s;
  if (longest.duration_s() >= kLeastWindowPeriods * period_s) CutTo(longest, chosen);
  return {};
}

namespace {

// level of the drive at its begin, as a part of its steady maximum: that of a 10-90 % rise
constexpr double kDriveLevel = 0.1;

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
  const StateInterval& on = chosen.part.state;
  if (!chosen.part.from_drive) return std::nullopt;
  const TimeWindow* before = nullptr;
  for (const TimeWindow& quiet : chosen.part.quiet) {
    if (quiet.end_s <= on.time.begin_s) before = &quiet;
  }
  if (before == nullptr) return std::nullopt;
  const double quiet_s = std::max(before->begin_s, before->end_s - kLongestDelayS);
  const BandSignal& signal = *chosen.signal;
  const double begin_s = TimeOfSample(signal, chosen.begin);
  const double steady_s = std::min(TimeOfSample(signal, chosen.end), begin_s + kLongestDelayS);
  return Around{SampleAt(signal, quiet_s), SampleAt(signal, before->end_s), chosen.begin,
                SampleAt(signal, steady_s)};
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
  HAPTOMETER_TRY(source.Read(*channel, first_row, drive.values, statuses));
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
      std::max(kDriveLevel * level, kRestsBelowDrive * drive.Farthest(0, quiet, rest));
  if (!(limit > 0 && limit <= kMajority * level)) return std::nullopt;
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
  HAPTOMETER_TRY(signal.samples().Read(around->begin, samples));
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
  HAPTOMETER_LET(const auto drive,
                 ReadDrive(source, signal.first_row() + around->begin, samples.size()));
  if (!drive) return onset;
  const auto beginning = BeginningOf(*drive, *around, rate_hz / tone_hz);
  if (!beginning) return onset;
  onset.drive_s = begin_s + beginning->sample / rate_hz;
  // rectangular distribution: half width / sqrt(3)
  onset.drive_uncertainty_s = beginning->half_width / rate_hz / std::numbers::sqrt3;
  onset.latency_s = onset.edge.time_s - *onset.drive_s;
  onset.latency_uncertainty_s =
      std::hypot(onset.edge.time_uncertainty_s, onset.drive_uncertainty_s);
  return onset;
}

namespace {

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
  HAPTOMETER_TRY(source.Read(channel, first_row, values, statuses));
  for (std::size_t k = 0; k < rows; ++k) *unmeasured += IsMeasured(values[k], statuses[k]) ? 0 : 1;
  return values;
}

}  // namespace

Result<ElectricalFinding> MeasureElectrical(const trial::RowSource& source, std::size_t first_row,
                                            std::size_t rows, double rate_hz, double tone_hz) {
  const auto voltage = ChannelIn(source.head(), trial::ChannelRole::kVoltage, "V");
  const auto current = ChannelIn(source.head(), trial::ChannelRole::kCurrent, "A");
  if (!voltage || !current) return ElectricalFinding{};
  const std::size_t size = std::min(rows, kMostFitted);
  const std::size_t first = first_row + (rows - size) / 2;
  std::size_t unmeasured = 0;
  HAPTOMETER_LET(const auto volts, ReadChannel(source, *voltage, first, size, &unmeasured));
  HAPTOMETER_LET(const auto amperes, ReadChannel(source, *current, first, size, &unmeasured));
  // every row is required: a sine fit at uniform times has no gaps
  if (unmeasured > 0) {
    return ElectricalFinding{std::nullopt, Finding{.kind = FindingKind::kElectricalUnmeasured,
                                                   .numbers = {{"readings", unmeasured}}}};
  }
  ElectricalFinding found{DescribeElectrical(volts, amperes, rate_hz, tone_hz), {}};
  if (!found.state) {
    found.why_not = {.kind = FindingKind::kElectricalNoTone,
                     .numbers = {{"frequency_hz", tone_hz}}};
  }
  return found;
}

}  // namespace haptometer::dsp
