#include "trial/import/printed_times.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "trial/import/printed_grid.h"
#include "trial/import/printed_number.h"
#include "trial/time_base.h"

namespace haptometer::trial {
namespace {

// the fits of recorded times count nanoseconds; an oscilloscope prints closer ones
constexpr double kShortestPeriodS = 1e-6;

// The least-squares line through times that grow, and how far they lie from it (RMS).
std::optional<Stretch> MeanLine(std::span<const double> times_s) {
  const auto count = static_cast<double>(times_s.size());
  const double middle = (count - 1) / 2;
  double mean_s = 0;
  for (const double t : times_s) mean_s += t / count;
  double sum_xx = 0;
  double sum_xt = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    sum_xx += x * x;
    sum_xt += x * (times_s[i] - mean_s);
  }
  const double period_s = sum_xt / sum_xx;
  if (!(period_s > 0) || !std::isfinite(1 / period_s)) return std::nullopt;
  double sum_squares = 0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double off_s = times_s[i] - mean_s - (static_cast<double>(i) - middle) * period_s;
    sum_squares += off_s * off_s;
  }
  return Stretch{.rows = times_s.size(),
                 .start_s = mean_s - middle * period_s,
                 .rate_hz = 1 / period_s,
                 .time_uncertainty_s = std::sqrt(sum_squares / count)};
}

}  // namespace

PrintedTimes::Digits PrintedTimes::DigitsOf(std::string_view text) {
  Digits digits;
  bool is_behind_point = false;
  for (const char c : text) {
    if (c == 'e' || c == 'E') break;
    if (c == '.' || c == ',') is_behind_point = true;
    if (c < '0' || c > '9') continue;
    if (is_behind_point) ++digits.decimals;
    if (c != '0' || digits.significant > 0) ++digits.significant;
  }
  const std::size_t exponent = text.find_first_of("eE");
  if (exponent != std::string_view::npos) {
    const auto power = ReadNumber(text.substr(exponent + 1));
    digits.decimals -= static_cast<int>(std::clamp(power.value_or(0), -400.0, 400.0));
  }
  return digits;
}

void PrintedTimes::Add(std::string_view printed, double time_s, double factor) {
  if (!times_s_.empty() && time_s == times_s_.back()) ++repeated_;
  times_s_.push_back(time_s);
  const Digits digits = DigitsOf(printed);
  most_.decimals = std::max(most_.decimals, digits.decimals);
  most_.significant = std::max(most_.significant, digits.significant);
  factor_ = factor;
}

void PrintedTimes::AddCount(double time_s) {
  if (!times_s_.empty() && time_s == times_s_.back()) ++repeated_;
  times_s_.push_back(time_s);
  is_count_ = true;
}

// half a unit of the last printed place of a time
double PrintedTimes::HalfDigit(double time_s) const {
  if (is_count_) return 0;
  const double printed = std::abs(time_s / factor_);
  const double magnitude = printed > 0 ? std::floor(std::log10(printed)) : -most_.decimals;
  const double place = std::max<double>(-most_.decimals, magnitude + 1 - most_.significant);
  const double half = 0.5 * std::pow(10.0, place);
  // eight or nine digits are those of a 32-bit float, which is rounded by 2^-24 of itself
  const bool may_be_float = most_.significant == 8 || most_.significant == 9;
  return (may_be_float ? std::max(half, 0x1p-24 * printed) : half) * factor_;
}

std::vector<double> PrintedTimes::HalfDigits() const {
  std::vector<double> half;
  half.reserve(times_s_.size());
  for (const double time_s : times_s_) half.push_back(HalfDigit(time_s));
  return half;
}

std::optional<Stretch> PrintedTimes::By(const StatedClock& clock) const {
  const auto at = [&](std::size_t i) { return static_cast<double>(i) * clock.interval_s; };
  // the starts that the digits of all rows leave; where some are cut off instead of rounded, that
  // moves the start alone; a little more for the arithmetic on clock times
  double least_s = -std::numeric_limits<double>::infinity();
  double most_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < times_s_.size(); ++i) {
    const double bound_s = (1 + 1e-4) * HalfDigit(times_s_[i]) + 1e-6 * clock.interval_s;
    least_s = std::max(least_s, times_s_[i] - bound_s - at(i));
    most_s = std::min(most_s, times_s_[i] + bound_s - at(i));
  }
  if (!(least_s <= most_s)) return std::nullopt;
  Stretch stretch{.rows = times_s_.size(), .rate_hz = 1 / clock.interval_s};
  const double slack_s = 2 * HalfDigit(times_s_[0]) + 1e-6 * clock.interval_s;
  if (clock.start_s) {
    if (*clock.start_s < least_s - slack_s || *clock.start_s > most_s + slack_s) {
      return std::nullopt;
    }
    stretch.start_s = *clock.start_s;
  } else {
    // the first row's own time where that will do
    const bool is_first = times_s_[0] >= least_s && times_s_[0] <= most_s;
    stretch.start_s = is_first ? times_s_[0] : std::midpoint(least_s, most_s);
  }
  return stretch;
}

// whether `stretches` still describe the rows: somebody may have edited them
bool PrintedTimes::Describe(std::span<const Stretch> stretches, Timing timing) const {
  constexpr double kLargestDelayS = 1;
  std::size_t row = 0;
  for (const Stretch& stretch : stretches) {
    if (stretch.first_row != row || stretch.rows > times_s_.size() - row) return false;
    for (; row < stretch.first_row + stretch.rows; ++row) {
      const double line_s =
          stretch.start_s + static_cast<double>(row - stretch.first_row) / stretch.rate_hz;
      const double bound_s = timing != Timing::kUniform ? kLargestDelayS : 1e-6 / stretch.rate_hz;
      if (!(std::abs(times_s_[row] - line_s) <= bound_s)) return false;
    }
  }
  return row == times_s_.size();
}

std::vector<Stretch> PrintedTimes::MeanLines(const Record& record) const {
  const double span_s = times_s_.back() - times_s_.front();
  const double shortest_s = kShortestPeriodS * static_cast<double>(times_s_.size() - 1);
  if (record.times_are_known && span_s < shortest_s) {
    const auto line = MeanLine(times_s_);
    return line ? std::vector{*line} : std::vector<Stretch>{};
  }
  std::vector<std::int64_t> time_ns;
  time_ns.reserve(times_s_.size());
  for (const double t : times_s_) {
    time_ns.push_back(static_cast<std::int64_t>(std::clamp(t * 1e9, -9e18, 9e18)));
  }
  const auto nominal_rate_hz = record.metadata.nominal_rate_hz;
  return record.timing == Timing::kArrival ? FitArrivalTimes(time_ns, nominal_rate_hz)
                                           : FitPolledTimes(time_ns, time_ns, nominal_rate_hz);
}

bool PrintedTimes::Complete(Timing timing, std::vector<Stretch> stated, Record* record) && {
  const bool times_are_raw = timing != Timing::kUniform;
  record->timing = timing;
  if (Describe(stated, timing)) {
    record->stretches = std::move(stated);
    if (times_are_raw) record->raw_times_s = std::move(times_s_);
    return true;
  }
  if (!times_are_raw) {
    if (auto grid = PrintedGrid(times_s_, HalfDigits())) {
      record->stretches = std::move(*grid);
      return true;
    }
    if (repeated_ > 0) return false;
    record->timing = Timing::kPolled;
    record->times_are_known = true;
  }
  // neither a grid nor explained: the mean line, beside the times as they stand
  record->stretches = MeanLines(*record);
  record->raw_times_s = std::move(times_s_);
  return std::ranges::all_of(record->stretches,
                             [](const Stretch& s) { return std::isfinite(s.rate_hz); }) &&
         !record->stretches.empty();
}

}  // namespace haptometer::trial
