#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace haptometer::trial {

/// What stands before the time of day in `text`: "2024-05-06" of "2024-05-06T12:00:00.5Z"; "" where
/// nothing does.
[[nodiscard]] std::string_view DateBefore(std::string_view text);

/// Counts the days between the rows of a table by their dates and times of day.
///
/// A date that begins with a year of four digits is read as it stands, one with points has its day
/// before its month. Other dates ("5/6/24") may be read in several orders; an order in which one of
/// the dates is none is left out. Where those that are left give other numbers of days, a time of
/// day that falls by more than half a day is a midnight, and the orders that make it one day are
/// kept. Rows without a date, and with one that is no IsDate, count midnights alone.
class DayCount {
 public:
  /// The days since the first row's date, by the next row: its date as printed (may be empty) and
  /// its seconds since midnight. Nothing where the date changes and nothing says by how many days.
  [[nodiscard]] std::optional<int> Take(std::string_view date, double clock_s);

  /// The last date that was given.
  [[nodiscard]] const std::string& date() const { return date_; }

  /// Of year, month and day in a date.
  enum class Order : std::uint8_t { kYearFirst, kDayFirst, kMonthFirst };

 private:
  [[nodiscard]] std::optional<int> Step(std::string_view date, bool is_midnight);

  std::string date_{};
  std::optional<double> clock_s_{};
  std::array<bool, 3> may_be_{true, true, true};  // the orders of dates
  int days_ = 0;                                  // by dates
  int midnights_ = 0;                             // since the last date that was read
};

}  // namespace haptometer::trial
