#include "trial/import/table/printed_times.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "base/mapped.h"
#include "base/median.h"
#include "trial/import/table/table_cells.h"
#include "trial/time_base.h"
#include "trial/time_lines.h"

namespace haptometer::trial {
namespace {

// rows that follow each other without a missing one
struct Run {
  std::size_t first = 0;
  std::size_t rows = 0;
};

// the median over differences of eight rows: rounding matters an eighth as much as in single
// intervals
double MedianPeriod(std::span<const double> times_s) {
  const std::size_t lag = std::min<std::size_t>(8, times_s.size() - 1);
  // of a long record a part of the differences is enough
  constexpr std::size_t kEnough = 1U << 16U;
  const std::size_t step = 1 + times_s.size() / kEnough;
  std::vector<double> spans;
  spans.reserve(times_s.size() / step + 1);
  for (std::size_t i = lag; i < times_s.size(); i += step) {
    spans.push_back(times_s[i] - times_s[i - lag]);
  }
  return UpperMedian(std::move(spans)) / AsDouble(lag);
}

// runs of rows without an interval that is half a period too long; rounding may add to it, but
// never so much that a missing row would pass
std::vector<Run> Runs(std::span<const double> times_s, std::span<const double> resolutions_s) {
  const double period_s = MedianPeriod(times_s);
  std::vector<Run> runs{{0, 1}};
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    const double rounding_s = resolutions_s[i] + resolutions_s[i - 1];
    const double longest_s = 1.5 * period_s + std::min(rounding_s, 0.4 * period_s);
    if (times_s[i] - times_s[i - 1] > longest_s) runs.push_back({i, 0});
    ++runs.back().rows;
  }
  return runs;
}

// whether first + j * period gives every time of `run` back within its digits
bool Fits(const Run& run, double period_s, std::span<const double> times_s,
          std::span<const double> resolutions_s) {
  const std::size_t last = run.first + run.rows - 1;
  // the grid begins at a printed time, so the end points' digits count too
  const double ends_s = std::max(resolutions_s[run.first], resolutions_s[last]);
  for (std::size_t j = 0; j < run.rows; ++j) {
    const double grid_s = times_s[run.first] + AsDouble(j) * period_s;
    // a millionth of a period for clocks that were summed up
    const double bound_s = ends_s + resolutions_s[run.first + j] + 1e-6 * period_s;
    if (std::abs(times_s[run.first + j] - grid_s) > bound_s) return false;
  }
  return true;
}

// The straight line through times whose digits are coarser than the period: least squares, each
// time weighted by its digits, because most printers keep a number of digits, so that times near 0
// are the finest. Nothing where it does not give every time back within its digits.
std::optional<Stretch> LineThroughCoarse(std::span<const double> times_s,
                                         std::span<const double> resolutions_s) {
  // fewer repeated times prove no grid
  constexpr std::size_t kFewest = 16;
  if (times_s.size() < kFewest) return std::nullopt;
  double sum = 0;
  double sum_x = 0;
  double sum_t = 0;
  // weight 1 / resolution^2, relative to the last row's, limited for times of exact digits
  const auto weight = [&](std::size_t i) {
    const double relative = resolutions_s.back() / std::max(resolutions_s[i], 1e-300);
    return std::clamp(relative * relative, 1e-12, 1e12);
  };
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    // weighted means of row and time
    sum += weight(i);
    sum_x += weight(i) * AsDouble(i);
    sum_t += weight(i) * times_s[i];
  }
  double sum_xx = 0;
  double sum_xt = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    // about the means: period = sum(w x t) / sum(w x^2)
    const double x = AsDouble(i) - sum_x / sum;
    sum_xx += weight(i) * x * x;
    sum_xt += weight(i) * x * (times_s[i] - sum_t / sum);
  }
  const double period_s = sum_xt / sum_xx;
  const double start_s = sum_t / sum - period_s * (sum_x / sum);
  if (!(period_s > 0) || !std::isfinite(1 / period_s)) return std::nullopt;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    // twice, as some printers cut digits off where others round
    const double bound_s = 2 * resolutions_s[i] + 1e-6 * period_s;
    if (!(std::abs(times_s[i] - start_s - AsDouble(i) * period_s) <= bound_s)) return std::nullopt;
    // rounding makes two times equal only where they are closer than a unit of the last digit
    const bool is_repeated = i > 0 && times_s[i] == times_s[i - 1];
    if (is_repeated && period_s > bound_s) return std::nullopt;
  }
  return Stretch{.rows = times_s.size(), .start_s = start_s, .rate_hz = 1 / period_s};
}

// The clocked segments behind printed times, or nothing where the times' resolution does not
// explain how they differ from grids.
//
// A new segment begins where an interval is more than half a period longer than the median one.
// Within a segment of n rows the period is (last - first) / (n - 1); short segments take the
// longest one's period where it fits them. A time may differ from its grid by its own
// resolution and the end points', plus a millionth of a period for clocks that were summed up.
//
// Times that repeat, because their digits are coarser than the period, are one segment on the
// least-squares line, each time weighted by its resolution, if that gives every time back within
// twice that and its period is not above a unit of their last digits; rows that are missing cannot
// be detected there.
//
// `times_s`: at least two, not falling; `resolutions_s`: how far each may lie from what was
// meant (PrintedTimes). Cost: O(rows).
std::optional<std::vector<Stretch>> PrintedGrid(std::span<const double> times_s,
                                                std::span<const double> resolutions_s) {
  // repeated times: digits coarser than the period
  if (std::ranges::adjacent_find(times_s) != times_s.end()) {
    const auto line = LineThroughCoarse(times_s, resolutions_s);
    if (!line) return std::nullopt;
    return std::vector<Stretch>{*line};
  }
  const std::vector<Run> runs = Runs(times_s, resolutions_s);
  // (last - first) / (n - 1)
  auto own_period_s = [&](const Run& run) {
    return (times_s[run.first + run.rows - 1] - times_s[run.first]) / AsDouble(run.rows - 1);
  };
  const Run& longest = *std::ranges::max_element(runs, {}, &Run::rows);
  if (longest.rows < 2) return std::nullopt;
  // the longest run has the smallest error of the period: 2 resolutions / (n - 1)
  const double common_period_s = own_period_s(longest);
  std::vector<Stretch> stretches;
  for (const Run& run : runs) {
    double period_s = common_period_s;
    if (!Fits(run, period_s, times_s, resolutions_s)) {
      // a run that the common period does not fit may have another rate
      period_s = own_period_s(run);
      if (!Fits(run, period_s, times_s, resolutions_s)) return std::nullopt;
    }
    if (!std::isfinite(1 / period_s)) return std::nullopt;
    stretches.push_back({.first_row = run.first,
                         .rows = run.rows,
                         .start_s = times_s[run.first],
                         .rate_hz = 1 / period_s,
                         .time_uncertainty_s = 0});
  }
  return stretches;
}

// the fits of recorded times count nanoseconds; an oscilloscope prints closer ones
constexpr double kShortestPeriodS = 1e-6;

// whether `number` is `rounded` printed with the fewest digits that give it back
bool IsShortest(double number, float rounded) {
  // as a float printed by a program: shortest text that gives the float back
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), rounded).ptr;
  double shortest = 0;
  std::from_chars(text.data(), end, shortest);
  // equal within the rounding of two conversions of a double
  return std::abs(shortest - number) <= 4 * 0x1p-53 * std::abs(number);
}

// the least-squares line through increasing times, and how far they lie from it (RMS)
std::optional<Stretch> MeanLine(std::span<const double> times_s) {
  const auto count = static_cast<double>(times_s.size());
  const double middle = (count - 1) / 2;
  double mean_s = 0;
  for (const double t : times_s) mean_s += t / count;
  double sum_xx = 0;
  double sum_xt = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    // rows centred on their mean: period = sum(x t) / sum(x^2)
    const double x = static_cast<double>(i) - middle;
    sum_xx += x * x;
    sum_xt += x * (times_s[i] - mean_s);
  }
  const double period_s = sum_xt / sum_xx;
  if (!(period_s > 0) || !std::isfinite(1 / period_s)) return std::nullopt;
  double sum_squares = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    // residual against the line, s
    const double off_s = times_s[i] - mean_s - (static_cast<double>(i) - middle) * period_s;
    sum_squares += off_s * off_s;
  }
  return Stretch{.rows = times_s.size(),
                 .start_s = mean_s - middle * period_s,
                 .rate_hz = 1 / period_s,
                 .time_uncertainty_s = std::sqrt(sum_squares / count)};
}

}  // namespace

// decimals may be negative: 1e3 has -3; zeros before the first digit are not significant
PrintedTimes::Digits PrintedTimes::DigitsOf(std::string_view text) {
  // of a date and a time of day, those of the time: what lies before it has its own points and e's
  if (const std::size_t colon = text.find(':'); colon != std::string_view::npos) {
    const std::size_t date_end = text.substr(0, colon).find_last_of(" T");
    if (date_end != std::string_view::npos) text.remove_prefix(date_end + 1);
  }
  Digits digits;
  bool is_behind_point = false;
  for (const char c : text) {
    if (c == 'e' || c == 'E') break;
    if (c == '.' || c == ',') is_behind_point = true;
    if (c < '0' || c > '9') continue;
    if (is_behind_point) ++digits.decimals;
    if (c != '0' || digits.significant > 0) ++digits.significant;
  }
  // an exponent shifts the last printed place; the limits guard against absurd ones
  const std::size_t exponent = text.find_first_of("eE");
  if (exponent != std::string_view::npos) {
    const auto power = ReadNumber(text.substr(exponent + 1));
    digits.decimals -= static_cast<int>(std::clamp(power.value_or(0), -400.0, 400.0));
  }
  return digits;
}

void PrintedTimes::Add(std::string_view printed, double time_s, double factor) {
  if (!times_s_.empty() && time_s == times_s_.back()) repeated_.push_back(times_s_.size());
  times_s_.push_back(time_s);
  const Digits digits = DigitsOf(printed);
  most_.decimals = std::max(most_.decimals, digits.decimals);
  most_.significant = std::max(most_.significant, digits.significant);
  factor_ = factor;
}

void PrintedTimes::AddCount(double time_s) {
  if (!times_s_.empty() && time_s == times_s_.back()) repeated_.push_back(times_s_.size());
  times_s_.push_back(time_s);
  is_count_ = true;
}

// half a unit of the last printed place of one time after the other; those of a decade share it
double PrintedTimes::HalfDigit(double time_s, Decade* decade) const {
  if (is_count_) return 0;
  const double printed = std::abs(time_s / factor_);
  if (printed >= decade->from && printed < decade->below) return decade->half_s;
  // power of ten of the leading digit
  const double magnitude = printed > 0 ? std::floor(std::log10(printed)) : -most_.decimals;
  // last place: by the most decimals or by the most significant digits of the column
  const double place = std::max<double>(-most_.decimals, magnitude + 1 - most_.significant);
  *decade = {.from = std::pow(10.0, magnitude),
             .below = std::pow(10.0, magnitude + 1),
             .half_s = 0.5 * std::pow(10.0, place) * factor_};
  return decade->half_s;
}

// whether the digits of every row may be those of a 32-bit float, of the time since `origin_s` in
// units of 1/`scale` of the printed one
bool PrintedTimes::MayBeFloats(double scale, double origin_s) const {
  // 9 digits are enough to distinguish any two 32-bit floats
  const bool may_be_shortest = most_.significant <= 9 && scale == 1 && origin_s == 0;
  Decade decade;
  // the origin has an uncertainty of its own digits
  const double origin_half_s = origin_s == 0 ? 0 : HalfDigit(origin_s, &decade);
  return std::ranges::all_of(times_s_, [&](double time_s) {
    const double number = (time_s - origin_s) / factor_ * scale;
    const double half = (HalfDigit(time_s, &decade) + origin_half_s) / factor_ * scale;
    const auto rounded = static_cast<float>(number);
    // rounding of the double arithmetic on the time
    const double arithmetic = 4 * 0x1p-53 * std::abs(time_s / factor_ * scale);
    if (std::abs(number - static_cast<double>(rounded)) <= half + arithmetic) return true;
    return may_be_shortest && IsShortest(number, rounded);
  });
}

// what a 32-bit float leaves out of a time, where there may be one behind the digits; else 0
double PrintedTimes::FloatRounding() const {
  const double span_s = times_s_.back() - times_s_.front();
  const double largest_s = std::max(std::abs(times_s_.front()), std::abs(times_s_.back()));
  // half a unit in the last place of a 24-bit significand
  const double rounding_s = 0x1p-24 * (largest_s + span_s);
  // a rounding below a thousandth of the period needs no proof
  constexpr double kNegligible = 1e-3;
  if (rounding_s <= kNegligible * span_s / static_cast<double>(times_s_.size())) return rounding_s;
  // floats of the printed time or of the time since the first row, in s or another unit
  for (const double origin_s : {0.0, times_s_.front()}) {
    for (const double scale : {1.0, 1e-3, 1e-6, 1e-9, 1e3, 1e6}) {
      if (MayBeFloats(scale, origin_s)) return rounding_s;
    }
  }
  return 0;
}

// how far each time may lie from the meant one, s: half its last digit and a float's rounding
std::vector<double> PrintedTimes::Resolutions() const {
  const double rounding_s = is_count_ ? 0 : FloatRounding();
  Decade decade;
  return Mapped<double>(
      times_s_, [&](const double time_s) { return HalfDigit(time_s, &decade) + rounding_s; });
}

std::optional<Stretch> PrintedTimes::By(const StatedClock& clock) const {
  const auto at = [&](std::size_t i) { return static_cast<double>(i) * clock.interval_s; };
  const std::vector<double> resolutions_s = Resolutions();
  // the interval of starts that all rows allow; digits that are cut off instead of rounded
  // move the start alone; a little more for the arithmetic on clock times
  double least_s = -std::numeric_limits<double>::infinity();
  double most_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < times_s_.size(); ++i) {
    const double bound_s = (1 + 1e-4) * resolutions_s[i] + 1e-6 * clock.interval_s;
    least_s = std::max(least_s, times_s_[i] - bound_s - at(i));
    most_s = std::min(most_s, times_s_[i] + bound_s - at(i));
  }
  if (!(least_s <= most_s)) return std::nullopt;
  Stretch stretch{.rows = times_s_.size(), .rate_hz = 1 / clock.interval_s};
  // a stated start may be printed with fewer digits than the rows
  const double slack_s = 2 * resolutions_s[0] + 1e-6 * clock.interval_s;
  if (clock.start_s) {
    if (*clock.start_s < least_s - slack_s || *clock.start_s > most_s + slack_s) {
      return std::nullopt;
    }
    stretch.start_s = *clock.start_s;
  } else {
    // the first row's own time where it lies in the interval
    const bool is_first = times_s_[0] >= least_s && times_s_[0] <= most_s;
    stretch.start_s = is_first ? times_s_[0] : std::midpoint(least_s, most_s);
  }
  return stretch;
}

// whether `stretches` still describe the rows, which a user may have edited
bool PrintedTimes::Describe(std::span<const Stretch> stretches, Timing timing) const {
  // arrival times lie behind their line by the delay of the host, grid times on it; more than a
  // second where the host stalled, which holds for some of the rows
  constexpr double kLargestDelayS = 1;
  std::size_t row = 0;
  std::size_t stalled = 0;
  for (const Stretch& stretch : stretches) {
    if (stretch.first_row != row || stretch.rows > times_s_.size() - row) return false;
    for (; row < stretch.first_row + stretch.rows; ++row) {
      const double line_s =
          stretch.start_s + static_cast<double>(row - stretch.first_row) / stretch.rate_hz;
      const double bound_s = timing != Timing::kUniform ? kLargestDelayS : 1e-6 / stretch.rate_hz;
      const double late_s = times_s_[row] - line_s;
      if (timing == Timing::kArrival && late_s > bound_s) {
        ++stalled;
      } else if (!(std::abs(late_s) <= bound_s)) {
        return false;
      }
    }
  }
  return row == times_s_.size() && 2 * stalled <= row;
}

std::vector<Stretch> PrintedTimes::MeanLines(const Record& record) const {
  const double span_s = times_s_.back() - times_s_.front();
  const double shortest_s = kShortestPeriodS * static_cast<double>(times_s_.size() - 1);
  // periods below 1 us: nanoseconds would be too coarse
  if (record.times_are_known && span_s < shortest_s) {
    const auto line = MeanLine(times_s_);
    return line ? std::vector{*line} : std::vector<Stretch>{};
  }
  std::vector<std::int64_t> time_ns;
  time_ns.reserve(times_s_.size());
  for (const double t : times_s_) {
    // limited to the range of 64 bits: a file may hold any times
    time_ns.push_back(static_cast<std::int64_t>(std::clamp(t * 1e9, -9e18, 9e18)));
  }
  const auto nominal_rate_hz = record.metadata.nominal_rate_hz;
  return record.timing == Timing::kArrival ? FitArrivalTimes(time_ns, nominal_rate_hz)
                                           : FitPolledTimes(time_ns, time_ns, nominal_rate_hz);
}

bool PrintedTimes::HasFewRepeated() const {
  // at most one repeated time in 100 rows (docs/reference/formats.md)
  constexpr std::size_t kRowsARepeat = 100;
  return repeated_.size() * kRowsARepeat <= times_s_.size();
}

std::optional<std::vector<std::size_t>> PrintedTimes::Complete(Timing timing,
                                                               std::vector<Stretch> stated,
                                                               bool has_copies, Record* record) && {
  const bool times_are_raw = timing != Timing::kUniform;
  record->timing = timing;
  record->rows = times_s_.size();
  std::vector<std::size_t> left_out;
  // the file's own time base, where it agrees with the rows
  if (Describe(stated, timing)) {
    record->stretches = std::move(stated);
    if (times_are_raw) record->raw_times_s = std::move(times_s_);
    return left_out;
  }
  if (!times_are_raw) {
    auto grid = has_copies ? std::nullopt : PrintedGrid(times_s_, Resolutions());
    // a few repeated times may mask a grid: those rows are excluded
    if (!grid && !repeated_.empty()) {
      if (!HasFewRepeated()) return std::nullopt;
      left_out = std::move(repeated_);
      times_s_.erase(std::ranges::unique(times_s_).begin(), times_s_.end());
      record->rows = times_s_.size();
      grid = PrintedGrid(times_s_, Resolutions());
    }
    if (grid) {
      record->stretches = std::move(*grid);
      return left_out;
    }
    // no grid explains the times: they are retained as the readings' own
    record->timing = Timing::kPolled;
    record->times_are_known = true;
  }
  // neither a grid nor explained: the mean line, beside the times as they stand
  record->stretches = MeanLines(*record);
  record->raw_times_s = std::move(times_s_);
  // times of no extent give no finite rate
  const bool is_sound =
      !record->stretches.empty() && std::ranges::all_of(record->stretches, [](const Stretch& s) {
        return std::isfinite(s.rate_hz);
      });
  return is_sound ? std::optional(std::move(left_out)) : std::nullopt;
}

}  // namespace haptometer::trial
