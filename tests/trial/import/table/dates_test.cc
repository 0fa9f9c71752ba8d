#include "trial/import/table/dates.h"

#include <gtest/gtest.h>

#include <optional>
#include <string_view>

namespace haptometer::trial {
namespace {

// the days from one row to the next, at these times of day
std::optional<int> Days(std::string_view first, std::string_view second, double first_s = 1,
                        double second_s = 2) {
  DayCount days;
  EXPECT_EQ(days.Take(first, first_s), 0);
  return days.Take(second, second_s);
}

constexpr double kBeforeMidnightS = 86'399;
constexpr double kBehindMidnightS = 1;

std::optional<int> OverMidnight(std::string_view first, std::string_view second) {
  return Days(first, second, kBeforeMidnightS, kBehindMidnightS);
}

TEST(Dates, StandBeforeTheTimeOfDay) {
  EXPECT_EQ(DateBefore("2024-05-06T12:00:00.5Z"), "2024-05-06");
  EXPECT_EQ(DateBefore(" 5/7/2021  12:00:47.056435"), "5/7/2021");
  EXPECT_EQ(DateBefore("12:00:47"), "");
}

TEST(Dates, AreDaysOfTheCalendar) {
  EXPECT_EQ(Days("2024-02-01", "2024-02-03"), 2);
  EXPECT_EQ(Days("2024/02/03", "2024/02/01"), -2);
  EXPECT_EQ(Days("2024-02-28", "2024-03-01"), 2);
  EXPECT_EQ(Days("2023-02-28", "2023-03-01"), 1);
  EXPECT_EQ(Days("2023-12-31", "2024-01-01"), 1);
  // the clock does not change what the dates say
  EXPECT_EQ(OverMidnight("2024-02-28", "2024-03-01"), 2);
  EXPECT_EQ(OverMidnight("2024-02-28", "2024-02-28"), 0);
  EXPECT_EQ(Days("2024-02-28", "2024-02-30"), std::nullopt);
}

TEST(Dates, OfSeveralOrdersCountWhereTheyAgree) {
  // with points the day stands first, and 13 and 31 are no months
  EXPECT_EQ(Days("01.02.2024", "03.02.2024"), 2);
  EXPECT_EQ(Days("12/13/2024", "12/15/2024"), 2);
  EXPECT_EQ(Days("31/12/2023", "01/01/2024"), 1);
  EXPECT_EQ(Days("02/01/2024", "02/03/2024"), std::nullopt);
  EXPECT_EQ(Days("24-05-06", "24-05-07"), std::nullopt);
}

TEST(Dates, AtAMidnightAreOneDayApart) {
  EXPECT_EQ(OverMidnight("02/01/2024", "02/02/2024"), 1);
  EXPECT_EQ(OverMidnight("22-Jan-2015", "23-Jan-2015"), 1);
  EXPECT_EQ(OverMidnight("22-Jan-2015", "22-Jan-2015"), 1);
  EXPECT_EQ(OverMidnight("", ""), 1);
  EXPECT_EQ(OverMidnight("02/01/2024", "02/03/2024"), std::nullopt);
  EXPECT_EQ(Days("22-Jan-2015", "23-Jan-2015"), std::nullopt);
}

TEST(Dates, KeepTheOrderThatAMidnightShowed) {
  DayCount days;
  EXPECT_EQ(days.Take("02/01/2024", kBeforeMidnightS), 0);
  EXPECT_EQ(days.Take("02/02/2024", kBehindMidnightS), 1);
  EXPECT_EQ(days.Take("02/04/2024", kBehindMidnightS), 3);
  EXPECT_EQ(days.date(), "02/04/2024");
}

TEST(Dates, ThatAreLeftOutOfRowsAreThoseBefore) {
  DayCount days;
  EXPECT_EQ(days.Take("2024-02-01", kBeforeMidnightS), 0);
  EXPECT_EQ(days.Take("", kBehindMidnightS), 1);
  EXPECT_EQ(days.Take("2024-02-02", kBehindMidnightS), 1);
}

}  // namespace
}  // namespace haptometer::trial
