#include "trial/import/printed_times.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "trial/import/csv_comment.h"
#include "trial/import/printed_grid.h"
#include "trial/time_base.h"

namespace haptometer::trial {

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
  times_s_.push_back(time_s);
  digits_.push_back(DigitsOf(printed));
  factor_ = factor;
}

// half a unit of the last printed place, for each time: the file prints either a number of
// decimals or a number of digits, and drops zeros at the end
std::vector<double> PrintedTimes::HalfDigits() const {
  Digits most;
  for (const Digits& digits : digits_) {
    most.decimals = std::max(most.decimals, digits.decimals);
    most.significant = std::max(most.significant, digits.significant);
  }
  std::vector<double> half;
  for (const double time_s : times_s_) {
    const double printed = std::abs(time_s / factor_);
    const double magnitude = printed > 0 ? std::floor(std::log10(printed)) : -most.decimals;
    const double place = std::max<double>(-most.decimals, magnitude + 1 - most.significant);
    half.push_back(0.5 * std::pow(10.0, place) * factor_);
  }
  return half;
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

void PrintedTimes::Complete(Timing timing, std::vector<Stretch> stated, Record* record) && {
  const bool times_are_raw = timing != Timing::kUniform;
  record->timing = timing;
  if (Describe(stated, timing)) {
    record->stretches = std::move(stated);
    if (times_are_raw) record->raw_times_s = std::move(times_s_);
    return;
  }
  if (!times_are_raw) {
    if (auto grid = PrintedGrid(times_s_, HalfDigits())) {
      record->stretches = std::move(*grid);
      return;
    }
  }
  // neither a grid nor explained: the mean line, beside the times as they stand
  std::vector<std::int64_t> time_ns;
  time_ns.reserve(times_s_.size());
  for (const double t : times_s_) {
    time_ns.push_back(static_cast<std::int64_t>(std::clamp(t * 1e9, -9e18, 9e18)));
  }
  if (!times_are_raw) {
    record->timing = Timing::kPolled;
    record->times_are_known = true;
  }
  const auto nominal_rate_hz = record->metadata.nominal_rate_hz;
  record->stretches = record->timing == Timing::kArrival
                          ? FitArrivalTimes(time_ns, nominal_rate_hz)
                          : FitPolledTimes(time_ns, time_ns, nominal_rate_hz);
  record->raw_times_s = std::move(times_s_);
}

}  // namespace haptometer::trial
