#include "trial/import/table/dates.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstddef>

#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

constexpr double kHalfDayS = 43'200;

using Order = DayCount::Order;
constexpr std::array kOrders{Order::kYearFirst, Order::kDayFirst, Order::kMonthFirst};

int Number(std::string_view digits) {
  int number = 0;
  std::from_chars(digits.begin(), digits.end(), number);
  return number;
}

// the day of `date` in the calendar, where it is one in this order
std::optional<int> DayOf(std::string_view date, Order order) {
  if (!IsDate(date)) return std::nullopt;
  const char sign = date[date.find_first_of("-./")];
  const std::size_t first = date.find(sign);
  const std::size_t second = date.find(sign, first + 1);
  std::string_view year = date.substr(0, first);
  std::string_view month = date.substr(first + 1, second - first - 1);
  std::string_view day = date.substr(second + 1);
  if (order != Order::kYearFirst) std::swap(year, day);
  if (order == Order::kMonthFirst) std::swap(month, day);
  // months stand before days in no date with points
  if (order == Order::kMonthFirst && sign == '.') return std::nullopt;
  if ((year.size() != 2 && year.size() != 4) || day.size() > 2) return std::nullopt;
  const int century = year.size() == 2 ? 2000 : 0;
  const std::chrono::year_month_day found{std::chrono::year(century + Number(year)),
                                          std::chrono::month(static_cast<unsigned>(Number(month))),
                                          std::chrono::day(static_cast<unsigned>(Number(day)))};
  if (!found.ok()) return std::nullopt;
  return static_cast<int>(std::chrono::sys_days(found).time_since_epoch().count());
}

}  // namespace

std::string_view DateBefore(std::string_view text) {
  text = Trimmed(text);
  const std::size_t end = text.find_last_of(" T");
  return end == std::string_view::npos ? "" : Trimmed(text.substr(0, end));
}

std::optional<int> DayCount::Take(std::string_view date, double clock_s) {
  const bool is_midnight = clock_s_ && clock_s < *clock_s_ - kHalfDayS;
  clock_s_ = clock_s;
  const bool is_known = !date.empty() && !date_.empty();
  if (is_known && date != date_) {
    const auto step = Step(date, is_midnight);
    if (!step) return std::nullopt;
    date_ = date;
    days_ += *step;
    if (IsDate(date)) midnights_ = 0;
    return days_ + midnights_;
  }
  if (!date.empty()) date_ = date;
  // the same date is the same day
  if (is_midnight && !(is_known && IsDate(date))) ++midnights_;
  return days_ + midnights_;
}

// days from the last date to `date`
std::optional<int> DayCount::Step(std::string_view date, bool is_midnight) {
  std::array<std::optional<int>, kOrders.size()> steps;
  std::optional<int> any;
  bool is_one = true;
  bool has_one_day = false;
  for (std::size_t i = 0; i < kOrders.size(); ++i) {
    const auto from = DayOf(date_, kOrders[i]);
    const auto to = DayOf(date, kOrders[i]);
    may_be_[i] = may_be_[i] && from && to;
    if (!may_be_[i]) continue;
    steps[i] = *to - *from;
    is_one = is_one && steps[i] == any.value_or(*steps[i]);
    has_one_day = has_one_day || steps[i] == 1;
    any = steps[i];
  }
  if (any && is_one) return any;
  if (!is_midnight || (any && !has_one_day)) return std::nullopt;
  // no date that can be read, or several orders, of which those are kept that agree with the clock
  for (std::size_t i = 0; i < kOrders.size(); ++i) may_be_[i] = may_be_[i] && steps[i] == 1;
  return 1;
}

}  // namespace haptometer::trial
