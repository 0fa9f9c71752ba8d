// What the printed digits of times leave uncertain of the rate.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

// a table of `rows` rows whose times are `print`ed
std::string Table(std::size_t rows, const std::function<std::string(std::size_t)>& print,
                  std::string_view head = "Time (s),CH1 (V)\n") {
  std::string text(head);
  for (std::size_t i = 0; i < rows; ++i) text += print(i) + ",0.25\n";
  return text;
}

Record Parsed(const std::string& text) {
  auto record = ParseCsv(text, "f.csv");
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

double At(std::size_t i, double start_s, double step_s) {
  return start_s + static_cast<double>(i) * step_s;
}

// standard uncertainty of a stretch's rate, relative, as a tone's frequency has it: either end of
// the line by itself
double RateUncertainty(const Stretch& stretch) {
  return std::numbers::sqrt2 * stretch.time_uncertainty_s * stretch.rate_hz /
         static_cast<double>(stretch.rows);
}

struct Printing {
  const char* name;
  std::function<std::string(double)> print;
  double digit_s;  // the coarsest
};

void PrintTo(const Printing& printing, std::ostream* out) { *out << printing.name; }

class RatesOfPrintedTimes : public ::testing::TestWithParam<Printing> {};

TEST_P(RatesOfPrintedTimes, LieWhereTheLinesOfAllDigitsDo) {
  const Printing& printing = GetParam();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> rates(1500, 9000);
  std::uniform_real_distribution<double> spans(0.5, 1.5);
  double missed_square = 0;
  double stated_square = 0;
  for (int file = 0; file < 12; ++file) {
    const double rate_hz = rates(random);
    const double span_s = spans(random);
    const double start_s = 0.3 * spans(random);
    const auto rows = static_cast<std::size_t>(span_s * rate_hz);
    const Record record =
        Parsed(Table(rows, [&](auto i) { return printing.print(At(i, start_s, 1 / rate_hz)); }));
    ASSERT_EQ(record.stretches.size(), 1U);
    const Stretch& stretch = record.stretches[0];
    const double uncertainty = RateUncertainty(stretch);
    const double missed = stretch.rate_hz / rate_hz - 1;
    EXPECT_ABS(missed, 0, std::numbers::sqrt3 * uncertainty + 1e-9,
               "the half-width of a rectangular distribution, and rounding");
    EXPECT_LE(uncertainty, 2 * std::min(printing.digit_s, 1 / rate_hz) / span_s)
        << "digits at the ends alone, or rows, say as much";
    missed_square += missed * missed;
    stated_square += uncertainty * uncertainty;
  }
  EXPECT_LE(std::sqrt(stated_square), 6 * std::sqrt(missed_square)) << "far too wide";
}

INSTANTIATE_TEST_SUITE_P(
    All, RatesOfPrintedTimes,
    ::testing::Values(
        Printing{"two_decimals", [](double time_s) { return fmt::format("{:.2f}", time_s); }, 1e-2},
        Printing{"three_decimals", [](double time_s) { return fmt::format("{:.3f}", time_s); },
                 1e-3},
        Printing{"four_decimals", [](double time_s) { return fmt::format("{:.4f}", time_s); },
                 1e-4},
        Printing{"five_decimals", [](double time_s) { return fmt::format("{:.5f}", time_s); },
                 1e-5},
        Printing{"four_digits", [](double time_s) { return fmt::format("{:.3e}", time_s); }, 1e-3},
        Printing{
            "milliseconds_cut_off",
            [](double time_s) { return fmt::format("{:.3f}", std::floor(time_s * 1e3) * 1e-3); },
            1e-3},
        Printing{
            "ten_microseconds_cut_off",
            [](double time_s) { return fmt::format("{:.5f}", std::floor(time_s * 1e5) * 1e-5); },
            1e-5}),
    [](const auto& printing) { return printing.param.name; });

TEST(PrintedRates, ThatAreExactLeaveNothingUncertain) {
  for (const char* format : {"{:.4f}", "{:.7f}", "{}"}) {
    const Record record = Parsed(
        Table(20'000, [&](auto i) { return fmt::format(fmt::runtime(format), At(i, 0.5, 2e-4)); }));
    ASSERT_EQ(record.stretches.size(), 1U);
    EXPECT_REL(record.stretches[0].rate_hz, 5000, 1e-14, "doubles");
    EXPECT_EQ(record.stretches[0].time_uncertainty_s, 0) << format;
  }
}

// 1000 rows are missing: the runs have the longer one's rate, and starts of their own
TEST(PrintedRates, RunsShareTheRateOfTheLongestAndItsUncertainty) {
  constexpr double kRateHz = 7123.4;
  const Record record = Parsed(Table(9000, [](auto i) {
    return fmt::format("{:.5f}", At(i < 3000 ? i : i + 1000, 0.1, 1 / kRateHz));
  }));
  ASSERT_EQ(record.stretches.size(), 2U);
  const Stretch& longest = record.stretches[1];
  EXPECT_EQ(longest.rows, 6000U);
  for (const Stretch& stretch : record.stretches) {
    EXPECT_EQ(stretch.rate_hz, longest.rate_hz);
    EXPECT_ABS(stretch.rate_hz / kRateHz - 1, 0, std::numbers::sqrt3 * RateUncertainty(longest),
               "the half-width of a rectangular distribution");
    const double start_s = At(stretch.first_row == 0 ? 0 : 4000, 0.1, 1 / kRateHz);
    EXPECT_ABS(stretch.start_s, start_s, std::numbers::sqrt3 * stretch.time_uncertainty_s,
               "the half-width of a rectangular distribution");
    EXPECT_LE(stretch.time_uncertainty_s, 5e-6 / std::numbers::sqrt3) << "half a digit";
    EXPECT_GT(stretch.time_uncertainty_s, 0);
  }
}

TEST(PrintedRates, AGridInPlaceOfRepeatedTimesIsNotedWithItsRate) {
  for (const char* head : {"time_s,voltage_v\n", "Time (s),CH1 (V)\n"}) {
    Findings findings;
    const auto record =
        ParseCsv(Table(
                     6000, [](auto i) { return fmt::format("{:.2f}", At(i, 0, 2e-4)); }, head),
                 "f.csv", {}, &findings);
    ASSERT_TRUE(record) << record.error().Text();
    using tests::NumberOf;
    constexpr auto kKind = FindingKind::kTimesRebuilt;
    EXPECT_EQ(NumberOf<std::int64_t>(findings, kKind, "repeated"), 5879) << head;
    const double rate_hz = NumberOf(findings, kKind, "rate_hz");
    EXPECT_EQ(rate_hz, record->stretches.at(0).rate_hz);
    EXPECT_REL(NumberOf(findings, kKind, "rate_uncertainty_hz"),
               rate_hz * RateUncertainty(record->stretches[0]), 1e-12, "rounding");
  }
}

// a run that the rate of the longest does not fit has its own, or none
TEST(RatesOfRuns, AShorterRunMayHaveARateOfItsOwn) {
  const std::string longest =
      "Time (s),CH1 (V)\n0.000,1\n1.000,1\n2.000,1\n3.000,1\n4.000,1\n5.000,1\n";
  const Record record = Parsed(longest + "100.000,1\n100.500,1\n101.000,1\n101.500,1\n");
  ASSERT_EQ(record.stretches.size(), 2U);
  EXPECT_EQ(record.stretches[0].rows, 6U);
  EXPECT_REL(record.stretches[0].rate_hz, 1, 1e-15, "printed times");
  EXPECT_EQ(record.stretches[1].first_row, 6U);
  EXPECT_EQ(record.stretches[1].rows, 4U);
  EXPECT_EQ(record.stretches[1].start_s, 100);
  EXPECT_REL(record.stretches[1].rate_hz, 2, 1e-15, "printed times");
  EXPECT_TRUE(record.raw_times_s.empty());
  const Record uneven = Parsed(longest + "100.000,1\n100.500,1\n100.900,1\n101.500,1\n");
  EXPECT_EQ(uneven.raw_times_s.size(), 10U);
  EXPECT_TRUE(uneven.times_are_known);
}

}  // namespace
}  // namespace haptometer::trial
