#include "trial/import/table/printed_times.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
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

// Printed times, and how far each may lie from what was meant.
struct Printed {
  std::span<const double> times_s;
  std::span<const double> resolutions_s;
  double rounding_s = 0;  // what a float's rounding adds to half a digit in each of resolutions_s
  double origin_s = 0;    // from which the times count, where they were doubles that count from 0

  [[nodiscard]] std::size_t rows() const { return times_s.size(); }
  [[nodiscard]] Printed Of(const Run& run) const {
    return {times_s.subspan(run.first, run.rows), resolutions_s.subspan(run.first, run.rows),
            rounding_s, origin_s};
  }
  // (last - first) / (n - 1)
  [[nodiscard]] double MeanPeriod() const {
    return (times_s.back() - times_s.front()) / AsDouble(rows() - 1);
  }
};

// by how much a line may miss a time: factor * resolution + more_s
struct Bound {
  double factor = 1;
  double more_s = 0;

  [[nodiscard]] double At(const Printed& printed, std::size_t row) const {
    return factor == 0 ? more_s : factor * printed.resolutions_s[row] + more_s;
  }
};

// a millionth of a period for clocks that were summed up
double Slack(double period_s) { return 1e-6 * period_s; }

// times that are not rounded: the millionth, and the rounding of doubles
Bound OfExactTimes(const Printed& printed, double period_s) {
  const double largest_s =
      std::max(std::abs(printed.times_s.front()), std::abs(printed.times_s.back()));
  return {0, Slack(period_s) + 0x1p-51 * (largest_s + printed.origin_s)};
}

// a grid begins at a printed time, so the end points' digits count too
Bound WithEnds(const Printed& printed, double period_s) {
  const double ends_s = std::max(printed.resolutions_s.front(), printed.resolutions_s.back());
  return {1, ends_s + Slack(period_s)};
}

// the bounds that rows may keep, from the least: half a digit, a float's rounding beside it, and
// `widest`
std::array<Bound, 3> BoundsOf(const Printed& printed, double period_s, const Bound& widest) {
  const double slack_s = Slack(period_s);
  return {Bound{1, slack_s - printed.rounding_s}, Bound{1, slack_s}, widest};
}

// whether the line from the first time on misses no time by more than `bound`
bool FitsFromFirst(const Printed& printed, double period_s, const Bound& bound) {
  for (std::size_t j = 0; j < printed.rows(); ++j) {
    const double line_s = printed.times_s[0] + AsDouble(j) * period_s;
    if (!(std::abs(printed.times_s[j] - line_s) <= bound.At(printed, j))) return false;
  }
  return true;
}

// the starts of lines of one period that all rows allow, and the rows that limit them
struct Starts {
  double least_s = -std::numeric_limits<double>::infinity();
  double most_s = std::numeric_limits<double>::infinity();
  std::size_t least_row = 0;
  std::size_t most_row = 0;
};

Starts StartsAt(const Printed& printed, double period_s, const Bound& bound) {
  Starts starts;
  for (std::size_t j = 0; j < printed.rows(); ++j) {
    const double start_s = printed.times_s[j] - AsDouble(j) * period_s;
    const double bound_s = bound.At(printed, j);
    if (start_s - bound_s > starts.least_s) {
      starts.least_s = start_s - bound_s;
      starts.least_row = j;
    }
    if (start_s + bound_s < starts.most_s) {
      starts.most_s = start_s + bound_s;
      starts.most_row = j;
    }
  }
  return starts;
}

// The longest (`sign` 1) or the shortest (-1) period of the lines that miss no time by more than
// `bound`; nothing where there is none. What the rows leave of the starts is a concave function of
// the period, piecewise linear, of slope least_row - most_row. Newton's method from outside takes
// the zero of one piece after the other, of rows that lie closer and closer: some five turns.
std::optional<double> OutermostPeriod(const Printed& printed, const Bound& bound, double sign) {
  const std::size_t last = printed.rows() - 1;
  // no line of a longer (shorter) period keeps the bounds of the end points
  const double ends_s = bound.At(printed, 0) + bound.At(printed, last);
  double period_s = printed.MeanPeriod() + sign * ends_s / AsDouble(last);
  for (double apart = AsDouble(printed.rows());;) {
    const Starts starts = StartsAt(printed, period_s, bound);
    if (starts.least_s <= starts.most_s) return period_s;
    const double between = AsDouble(starts.most_row) - AsDouble(starts.least_row);
    if (!(sign * between > 0)) return std::nullopt;
    // rows that are no closer: what is left is rounding
    if (sign * between >= apart) return period_s;
    apart = sign * between;
    period_s += (starts.most_s - starts.least_s) / between;
  }
}

// a straight line, and the standard uncertainties of its period and of its start at that period
struct Line {
  double start_s = 0;
  double period_s = 0;
  double period_uncertainty_s = 0;
  double start_uncertainty_s = 0;
};

// half the width of a rectangular distribution as a standard deviation (GUM 4.3.7)
double Rectangular(double width) { return width / 2 / std::numbers::sqrt3; }

// The line in the middle of those of `period_s` that keep the least of the bounds that any keeps;
// from the first time on where that gives all times back exactly.
Line LineOfPeriod(const Printed& printed, double period_s, const Bound& widest) {
  Line line{.start_s = printed.times_s[0], .period_s = period_s};
  if (FitsFromFirst(printed, period_s, OfExactTimes(printed, period_s))) return line;
  for (const Bound& bound : BoundsOf(printed, period_s, widest)) {
    const Starts starts = StartsAt(printed, period_s, bound);
    if (!(starts.least_s <= starts.most_s)) continue;
    line.start_s = std::midpoint(starts.least_s, starts.most_s);
    line.start_uncertainty_s = Rectangular(starts.most_s - starts.least_s);
    break;
  }
  return line;
}

// The line in the middle of all that keep the least of the bounds that any keeps. Rounding errors
// follow each other without chance where digits are coarse, so none of these lines is excluded, and
// the period is as likely anywhere between theirs.
std::optional<Line> MiddleLine(const Printed& printed, const Bound& widest) {
  const double mean_s = printed.MeanPeriod();
  if (FitsFromFirst(printed, mean_s, OfExactTimes(printed, mean_s))) {
    return Line{.start_s = printed.times_s[0], .period_s = mean_s};
  }
  for (const Bound& bound : BoundsOf(printed, mean_s, widest)) {
    const auto least_s = OutermostPeriod(printed, bound, -1);
    const auto most_s = OutermostPeriod(printed, bound, 1);
    if (!least_s || !most_s) continue;
    Line line = LineOfPeriod(printed, std::midpoint(*least_s, *most_s), bound);
    line.period_uncertainty_s = Rectangular(*most_s - *least_s);
    return line;
  }
  return std::nullopt;
}

// The uncertainty of the times that gives the rate of `rows` its own: that of either end of the
// line, sqrt(2) of which is that of the span. A start common to all rows leaves the rate as it is.
double TimeUncertainty(const Line& line, std::size_t rows) {
  return line.period_uncertainty_s * AsDouble(rows) / std::numbers::sqrt2;
}

// The line through times whose digits are coarser than the period, or nothing where none gives
// every time back within twice its resolution.
std::optional<Stretch> LineThroughCoarse(const Printed& printed) {
  // fewer repeated times prove no grid
  constexpr std::size_t kFewest = 16;
  if (printed.rows() < kFewest) return std::nullopt;
  // twice, as some printers cut digits off where others round
  const Bound twice{2, Slack(printed.MeanPeriod())};
  const auto line = MiddleLine(printed, twice);
  if (!line || !(line->period_s > 0) || !std::isfinite(1 / line->period_s)) return std::nullopt;
  for (std::size_t i = 1; i < printed.rows(); ++i) {
    // rounding makes two times equal only where they are closer than a unit of the last digit
    const bool is_repeated = printed.times_s[i] == printed.times_s[i - 1];
    if (is_repeated && line->period_s > twice.At(printed, i)) return std::nullopt;
  }
  return Stretch{.rows = printed.rows(),
                 .start_s = line->start_s,
                 .rate_hz = 1 / line->period_s,
                 .time_uncertainty_s = TimeUncertainty(*line, printed.rows())};
}

// The one segment of times that the grid through their ends gives back to a millionth of a period:
// those need no resolutions, which only widen the bounds (WithEnds, OfExactTimes). Nothing of
// others.
std::optional<Stretch> ExactGrid(std::span<const double> times_s) {
  const Printed printed{.times_s = times_s, .resolutions_s = {}};
  const double period_s = printed.MeanPeriod();
  if (!(period_s > 0) || !std::isfinite(1 / period_s)) return std::nullopt;
  if (!FitsFromFirst(printed, period_s, {0, Slack(period_s)})) return std::nullopt;
  return Stretch{.rows = times_s.size(), .start_s = times_s[0], .rate_hz = 1 / period_s};
}

// The clocked segments behind printed times, or nothing where the times' resolution does not
// explain how they differ from grids.
//
// A new segment begins where an interval is more than half a period longer than the median one.
// Short segments take the longest one's period where it fits them. A time may differ from the grid
// through its segment's end points by its own resolution and the end points', plus a millionth of
// a period for clocks that were summed up. Times that such a grid gives back to that millionth are
// exact; else the line is in the middle of all that give the times back within half a digit, or
// if there is none within the resolution (MiddleLine), and time_uncertainty_s is what they leave
// uncertain of the rate, and of the starts where there are several segments.
//
// Times that repeat, because their digits are coarser than the period, are one segment on such a
// line, within twice the resolution if need be, if its period is not above a unit of their last
// digits; rows that are missing cannot be detected there.
//
// `printed`: at least two, not falling. Cost: O(rows).
std::optional<std::vector<Stretch>> PrintedGrid(const Printed& printed) {
  // repeated times: digits coarser than the period
  if (std::ranges::adjacent_find(printed.times_s) != printed.times_s.end()) {
    const auto line = LineThroughCoarse(printed);
    if (!line) return std::nullopt;
    return std::vector<Stretch>{*line};
  }
  const std::vector<Run> runs = Runs(printed.times_s, printed.resolutions_s);
  const auto own_line = [](const Printed& part) -> std::optional<Line> {
    const double period_s = part.MeanPeriod();
    const Bound bound = WithEnds(part, period_s);
    return FitsFromFirst(part, period_s, bound) ? MiddleLine(part, bound) : std::nullopt;
  };
  // the longest run has the smallest error of the period
  const Run& longest = *std::ranges::max_element(runs, {}, &Run::rows);
  if (longest.rows < 2) return std::nullopt;
  const auto common = own_line(printed.Of(longest));
  if (!common) return std::nullopt;
  std::vector<Stretch> stretches;
  for (const Run& run : runs) {
    const Printed part = printed.Of(run);
    std::optional<Line> line = common;
    if (run.first != longest.first) {
      // a run that the common period does not fit may have another rate
      const Bound bound = WithEnds(part, common->period_s);
      const bool is_common = FitsFromFirst(part, common->period_s, bound);
      line = is_common ? LineOfPeriod(part, common->period_s, bound) : own_line(part);
      if (line && is_common) line->period_uncertainty_s = common->period_uncertainty_s;
    }
    if (!line || !std::isfinite(1 / line->period_s)) return std::nullopt;
    const double start_s = runs.size() > 1 ? line->start_uncertainty_s : 0;
    stretches.push_back(
        {.first_row = run.first,
         .rows = run.rows,
         .start_s = line->start_s,
         .rate_hz = 1 / line->period_s,
         .time_uncertainty_s = std::hypot(TimeUncertainty(*line, run.rows), start_s)});
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

void PrintedTimes::AddCount(double time_s, double factor) {
  if (!times_s_.empty() && time_s == times_s_.back()) repeated_.push_back(times_s_.size());
  times_s_.push_back(time_s);
  factor_ = factor;
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

// whether the digits of every row may be those of a 32-bit float, of the time or of that since the
// first row, in units of 1/`scale` of the printed one
bool PrintedTimes::MayBeFloats(double scale, bool is_since_first) const {
  // 9 digits are enough to distinguish any two 32-bit floats
  const bool may_be_shortest = most_.significant <= 9 && scale == 1 && !is_since_first;
  Decade decade;
  // the first time has an uncertainty of its own digits
  const double first_half_s = is_since_first ? HalfDigit(times_s_.front(), &decade) : 0;
  const double first_s = is_since_first ? times_s_.front() : -origin_s_;
  return std::ranges::all_of(times_s_, [&](double time_s) {
    const double number = (time_s - first_s) / factor_ * scale;
    const double half = (HalfDigit(time_s, &decade) + first_half_s) / factor_ * scale;
    const auto rounded = static_cast<float>(number);
    // rounding of the double arithmetic on the time
    const double largest_s = std::max(std::abs(time_s), std::abs(time_s - first_s));
    const double arithmetic = 4 * 0x1p-53 * std::abs(largest_s / factor_ * scale);
    if (std::abs(number - static_cast<double>(rounded)) <= half + arithmetic) return true;
    return may_be_shortest && IsShortest(number, rounded);
  });
}

// what a 32-bit float leaves out of a time, where there may be one behind the digits; else 0
double PrintedTimes::FloatRounding() const {
  if (is_count_) return 0;
  const double span_s = times_s_.back() - times_s_.front();
  const double first_s = times_s_.front() + origin_s_;
  const double largest_s = std::max(std::abs(first_s), std::abs(times_s_.back() + origin_s_));
  // a rounding below a thousandth of the period needs no proof
  constexpr double kNegligible = 1e-3;
  const double negligible_s = kNegligible * span_s / static_cast<double>(times_s_.size());
  // floats of the printed time or of the time since the first row, in s or another unit
  for (const bool is_since_first : {false, true}) {
    if (is_since_first && first_s == 0) break;
    // half a unit in the last place of a 24-bit significand
    const double rounding_s = 0x1p-24 * (is_since_first ? span_s : largest_s + span_s);
    if (rounding_s <= negligible_s) return rounding_s;
    for (const double scale : {1.0, 1e-3, 1e-6, 1e-9, 1e3, 1e6}) {
      if (MayBeFloats(scale, is_since_first)) return rounding_s;
    }
  }
  return 0;
}

// how far each time may lie from the meant one, s: half its last digit and a float's rounding
std::vector<double> PrintedTimes::Resolutions(double rounding_s) const {
  Decade decade;
  return Mapped<double>(
      times_s_, [&](const double time_s) { return HalfDigit(time_s, &decade) + rounding_s; });
}

std::optional<std::vector<Stretch>> PrintedTimes::Grid() const {
  if (const auto exact = ExactGrid(times_s_)) return std::vector<Stretch>{*exact};
  const double rounding_s = FloatRounding();
  const std::vector<double> resolutions_s = Resolutions(rounding_s);
  // more digits than a double has may be those of one, as are counts that were read as doubles
  constexpr int kDigits = 16;
  const bool may_be_doubles =
      is_count_ ? std::abs(origin_s_ / factor_) > 0x1p53 : most_.significant > kDigits;
  return PrintedGrid(
      {times_s_, resolutions_s, rounding_s, may_be_doubles ? std::abs(origin_s_) : 0});
}

std::optional<Stretch> PrintedTimes::By(const StatedClock& clock) const {
  const double rounding_s = FloatRounding();
  const std::vector<double> resolutions_s = Resolutions(rounding_s);
  // digits that are cut off instead of rounded move the start alone; a little more for the
  // arithmetic on clock times
  const Starts starts = StartsAt({times_s_, resolutions_s, rounding_s}, clock.interval_s,
                                 {1 + 1e-4, Slack(clock.interval_s)});
  const double least_s = starts.least_s + origin_s_;
  const double most_s = starts.most_s + origin_s_;
  if (!(starts.least_s <= starts.most_s)) return std::nullopt;
  Stretch stretch{.rows = times_s_.size(), .rate_hz = 1 / clock.interval_s};
  // a stated start may be printed with fewer digits than the rows
  const double slack_s = 2 * resolutions_s[0] + Slack(clock.interval_s);
  if (clock.start_s) {
    if (*clock.start_s < least_s - slack_s || *clock.start_s > most_s + slack_s) {
      return std::nullopt;
    }
    stretch.start_s = *clock.start_s;
  } else {
    // the first row's own time where it lies in the interval
    const double first_s = times_s_[0] + origin_s_;
    const bool is_first = first_s >= least_s && first_s <= most_s;
    stretch.start_s = is_first ? first_s : std::midpoint(least_s, most_s);
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
      const double late_s = times_s_[row] - (line_s - origin_s_);
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

// makes times that count from the origin count from 0
void PrintedTimes::MoveToOrigin(Record* record) const {
  for (Stretch& stretch : record->stretches) stretch.start_s += origin_s_;
  for (double& time_s : record->raw_times_s) time_s += origin_s_;
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
    if (times_are_raw) record->raw_times_s = std::move(times_s_);
    MoveToOrigin(record);
    record->stretches = std::move(stated);
    return left_out;
  }
  if (!times_are_raw) {
    auto grid = has_copies ? std::nullopt : Grid();
    // a few repeated times may mask a grid: those rows are excluded
    if (!grid && !repeated_.empty()) {
      if (!HasFewRepeated()) return std::nullopt;
      left_out = std::move(repeated_);
      times_s_.erase(std::ranges::unique(times_s_).begin(), times_s_.end());
      record->rows = times_s_.size();
      grid = Grid();
    }
    if (grid) {
      record->stretches = std::move(*grid);
      MoveToOrigin(record);
      return left_out;
    }
    // no grid explains the times: they are retained as the readings' own
    record->timing = Timing::kPolled;
    record->times_are_known = true;
  }
  // neither a grid nor explained: the mean line, beside the times as they stand
  record->stretches = MeanLines(*record);
  record->raw_times_s = std::move(times_s_);
  MoveToOrigin(record);
  // times of no extent give no finite rate
  const bool is_sound =
      !record->stretches.empty() && std::ranges::all_of(record->stretches, [](const Stretch& s) {
        return std::isfinite(s.rate_hz);
      });
  return is_sound ? std::optional(std::move(left_out)) : std::nullopt;
}

}  // namespace haptometer::trial
