// Time columns as exporters print them: which of them are a clock's, and which are not.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"
#include "trial/import/readers.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;

Record Parsed(std::string_view text, const ImportOptions& options = {}) {
  auto record = ParseCsv(text, "f.csv", options);
  EXPECT_TRUE(record) << record.error().Text();
  return record ? std::move(*record) : Record{};
}

// a table of `rows` rows whose times are `print`ed
std::string Table(std::size_t rows, const std::function<std::string(std::size_t)>& print,
                  std::string_view head = "Source,CH1\nSecond,Volt\n") {
  std::string text(head);
  for (std::size_t i = 0; i < rows; ++i) text += print(i) + ",0.25\n";
  return text;
}

// the exact decimals of a 32-bit float
std::string Float(double time_s, int decimals) {
  return fmt::format("{:.{}f}", static_cast<double>(static_cast<float>(time_s)), decimals);
}

double At(std::size_t i, double start_s, double step_s) {
  return start_s + static_cast<double>(i) * step_s;
}

struct FloatTimes {
  const char* name;
  std::function<std::string(std::size_t)> print;
  double start_s;
  double step_s;
};

void PrintTo(const FloatTimes& times, std::ostream* out) { *out << times.name; }

class TimesOf32BitFloats : public ::testing::TestWithParam<FloatTimes> {};

TEST_P(TimesOf32BitFloats, AreAGridWhateverTheirDigits) {
  const FloatTimes& times = GetParam();
  constexpr std::size_t kRows = 30'000;
  const Record record = Parsed(Table(kRows, times.print));
  ASSERT_EQ(record.stretches.size(), 1);
  EXPECT_TRUE(record.raw_times_s.empty()) << "not on a grid";
  EXPECT_REL(record.stretches[0].rate_hz, 1 / times.step_s, 5e-7,
             "a float's rounding (6e-8) of either end, over a span of at least a quarter of it");
  EXPECT_ABS(record.stretches[0].start_s, times.start_s, 1e-7 * std::abs(times.start_s) + 1e-12,
             "a float's rounding");
}

INSTANTIATE_TEST_SUITE_P(
    All, TimesOf32BitFloats,
    ::testing::Values(
        FloatTimes{"eleven_decimals", [](auto i) { return Float(At(i, -0.031, 2.5e-5), 11); },
                   -0.031, 2.5e-5},
        FloatTimes{"twenty_decimals", [](auto i) { return Float(At(i, -0.031, 2.5e-5), 20); },
                   -0.031, 2.5e-5},
        FloatTimes{"nine_digits",
                   [](auto i) {
                     return fmt::format("{:.8e}",
                                        static_cast<double>(static_cast<float>(At(i, -7, 1e-3))));
                   },
                   -7, 1e-3},
        FloatTimes{"fewest_digits",
                   [](auto i) { return fmt::format("{}", static_cast<float>(At(i, -0.4, 4e-5))); },
                   -0.4, 4e-5},
        // a step that is no decimal number: the digits alone say less than the fewest that give
        // the float back
        FloatTimes{"fewest_digits_of_fractions",
                   [](auto i) {
                     return fmt::format("{}", static_cast<float>(At(i, -7.0 / 17, 1.0 / 24'000)));
                   },
                   -7.0 / 17, 1.0 / 24'000},
        // row times interval is rounded before the offset is added
        FloatTimes{"offset_in_floats",
                   [](auto i) {
                     const float product = static_cast<float>(i) * 4e-5F;
                     return fmt::format("{:.12f}", static_cast<double>(product + -0.6F));
                   },
                   -0.6, 4e-5},
        FloatTimes{"offset_in_doubles",
                   [](auto i) {
                     const float product = static_cast<float>(i) * 4e-5F;
                     return fmt::format("{:.12f}", static_cast<double>(product) - 0.6);
                   },
                   -0.6, 4e-5},
        FloatTimes{"microseconds_divided",
                   [](auto i) {
                     const auto us = static_cast<float>(At(i, -3.1e5, 40));
                     return fmt::format("{:.14f}", static_cast<double>(us) / 1e6);
                   },
                   -0.31, 4e-5}),
    [](const auto& times) { return times.param.name; });

TEST(PrintedTimes, FloatsAgreeWithAStatedClock) {
  std::string head = "Sample Interval,CH1:0.0000200000\nSource,CH1\nSecond,Volt\n";
  const Record record =
      Parsed(Table(40'000, [](auto i) { return Float(At(i, -0.3, 2e-5), 11); }, head));
  ASSERT_EQ(record.stretches.size(), 1);
  EXPECT_DOUBLE_EQ(record.stretches[0].rate_hz, 50'000) << "the stated clock";
}

// --- rows that were written twice ---------------------------------------------------------------

// readings that all differ
double Reading(std::size_t i) { return 10 + std::sin(0.2 * static_cast<double>(i)); }

// 15000 rows at `rate_hz` with times of `decimals`, every `twice`th of them written twice
std::string WithRowsTwice(double rate_hz, int decimals, std::size_t twice,
                          const std::function<double(std::size_t)>& reading) {
  std::string text = "Time (s),Laser (mm)\n";
  for (std::size_t i = 0; i < 15'000; ++i) {
    const std::string row =
        fmt::format("{:.{}f},{:.6f}\n", static_cast<double>(i) / rate_hz, decimals, reading(i));
    text += row;
    if (i % twice == twice - 1) text += row;
  }
  return text;
}

std::string ErrorOf(const std::string& text) {
  const auto record = ParseCsv(text, "f.csv", {});
  return record ? "was read" : record.error().Text();
}

TEST(RowsWrittenTwice, AreNoTimesOfTooFewDigits) {
  // digits finer than an interval, as fine, and coarser
  for (const auto& [rate_hz, decimals] : {std::pair{5000.0, 4}, {10'000.0, 4}, {5000.0, 3}}) {
    EXPECT_EQ(
        ErrorOf(WithRowsTwice(rate_hz, decimals, 51, Reading)),
        "f.csv: 294 of 15294 rows repeat the time and the values of the row before (first row "
        "52), as if they were written twice; remove these rows")
        << rate_hz << " Hz, " << decimals << " decimals";
  }
}

TEST(RowsWrittenTwice, AreLeftOutWhereTheyAreFew) {
  const Record record = Parsed(WithRowsTwice(10'000, 4, 200, Reading));
  EXPECT_EQ(record.rows, 15'000);
  EXPECT_REL(record.stretches.at(0).rate_hz, 10'000, 1e-9, "printed times");
  EXPECT_REL(record.channels.at(0).values.back(), 1e-3 * Reading(14'999), 1e-6, "printed digits");
}

TEST(RowsWrittenTwice, InATableOfOurOwn) {
  std::string text = WithRowsTwice(5000, 4, 51, Reading);
  text.replace(0, text.find('\n'), "time_s,displacement_mm");
  EXPECT_THAT(ErrorOf(text), HasSubstr("294 of 15294 rows repeat the time and the values"));
}

TEST(RowsWrittenTwice, ReadingsThatHardlyVaryAreNoSuchRows) {
  const auto rest = [](std::size_t) { return 10.0; };
  // two of three neighbours are equal
  const auto slow = [](std::size_t i) { return 10 + 0.01 * static_cast<double>(i / 3 % 2); };
  for (const std::function<double(std::size_t)>& reading :
       {std::function<double(std::size_t)>(rest), {slow}}) {
    const Record record = Parsed(WithRowsTwice(5000, 3, 1'000'000, reading));
    EXPECT_EQ(record.rows, 15'000);
    EXPECT_REL(record.stretches.at(0).rate_hz, 5000, 1e-5, "the last digit of 3 s");
  }
}

// an interval is two units of the last digit, so that no rounding makes times equal
TEST(RowsWrittenTwice, AreFoundByTheirTimesAloneWhereTheDigitsAreFiner) {
  const auto rest = [](std::size_t) { return 10.0; };
  EXPECT_THAT(ErrorOf(WithRowsTwice(5000, 4, 51, rest)),
              HasSubstr("294 of 15294 rows have the time of the row before"));
  const Record record = Parsed(WithRowsTwice(5000, 4, 10'000, rest));
  EXPECT_EQ(record.rows, 15'000);
  EXPECT_REL(record.stretches.at(0).rate_hz, 5000, 1e-9, "printed times");
}

// readings that rest where the digits become coarser than an interval do so by themselves
TEST(RowsWrittenTwice, AreJudgedByTheReadingsBesideThem) {
  std::string text = "Time (s),Laser (mm)\n";
  for (std::size_t i = 0; i < 15'000; ++i) {
    text +=
        fmt::format("{:.4g},{:.6f}\n", static_cast<double>(i) / 5000, i < 5000 ? Reading(i) : 10.0);
  }
  const Record record = Parsed(text);
  EXPECT_EQ(record.rows, 15'000);
  EXPECT_REL(record.stretches.at(0).rate_hz, 5000, 1e-4, "the last digit of 3 s");
}

// --- what no grid explains is found -------------------------------------------------------------

class Decimals : public ::testing::TestWithParam<int> {};

// 9 decimals are coarser than floats here, 11 and 16 finer
INSTANTIATE_TEST_SUITE_P(All, Decimals, ::testing::Values(9, 11, 16));

TEST_P(Decimals, AMissingRowBeginsAStretch) {
  const Record record = Parsed(Table(
      20'000, [](auto i) { return Float(At(i + (i >= 13'000 ? 1 : 0), -0.1, 3e-5), GetParam()); }));
  EXPECT_TRUE(record.raw_times_s.empty());
  ASSERT_EQ(record.stretches.size(), 2);
  EXPECT_EQ(record.stretches[1].first_row, 13'000);
  EXPECT_ABS(record.stretches[1].start_s, At(13'001, -0.1, 3e-5), 2e-8, "a float's rounding");
}

TEST_P(Decimals, ADoubledRowIsLeftOutAndSaid) {
  Findings findings;
  const auto text = Table(
      20'000, [](auto i) { return Float(At(i - (i >= 700 ? 1 : 0), -0.1, 3e-5), GetParam()); });
  const auto record = ParseCsv(text, "f.csv", {}, &findings);
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->rows, 19'999);
  EXPECT_EQ(record->channels.at(0).values.size(), 19'999);
  EXPECT_EQ(record->channels[0].statuses.size(), 19'999);
  EXPECT_EQ(record->stretches.size(), 1);
  EXPECT_TRUE(record->raw_times_s.empty());
  EXPECT_EQ(NumbersOf(findings, FindingKind::kRowsExcluded), "excluded=1 rows=20000 line=703");
}

TEST_P(Decimals, JitterOfAHundredthOfAnIntervalIsKept) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> jitter(-0.01, 0.01);
  const Record record = Parsed(Table(20'000, [&](auto i) {
    return Float(-0.1 + 3e-5 * (static_cast<double>(i) + jitter(random)), GetParam());
  }));
  EXPECT_EQ(record.raw_times_s.size(), 20'000);
  EXPECT_TRUE(record.times_are_known);
  EXPECT_REL(record.stretches.at(0).time_uncertainty_s, 3e-5 * 0.01 / std::sqrt(3.0), 0.05,
             "uniform jitter of 20 000 rows");
}

// 500 us of a clock of 1 MHz, printed as 1.23456e-04: the last place is 1 ns, and not 10 us
TEST(PrintedTimes, AnExponentMovesTheLastPrintedPlace) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-0.2e-6, 0.2e-6);
  const auto text = [&](double size) {
    return Table(500, [&](auto i) {
      return fmt::format("{:.5e}", At(i, 1e-4, 1e-6) + size * jitter(random));
    });
  };
  EXPECT_EQ(Parsed(text(1)).raw_times_s.size(), 500);
  EXPECT_TRUE(Parsed(text(0)).raw_times_s.empty());
}

TEST(PrintedTimes, JitterOfDoublesIsFoundToTheirLastDigit) {
  // far beyond what floats could hold: 400 000 rows, a fortieth of an interval is 2^-24 of the span
  std::mt19937 random(6);
  std::uniform_real_distribution<double> jitter(-0.01, 0.01);
  const auto text = [&](double size) {
    return Table(400'000, [&](auto i) {
      return fmt::format("{:.12f}", 1e-4 * (static_cast<double>(i) + size * jitter(random)));
    });
  };
  EXPECT_EQ(Parsed(text(1)).raw_times_s.size(), 400'000);
  EXPECT_TRUE(Parsed(text(0)).raw_times_s.empty());
}

// Doubles of Unix seconds are 0.24 us apart: jitter of 0.7 us is not explained by nine decimals,
// nor by floats of the time since the first row. (Floats of 1.7e9 s, 128 s apart, explained it
// once.)
TEST(PrintedTimes, JitterBeyondTheDigitsOfUnixSecondsIsKept) {
  for (const std::size_t rows : {2000U, 60'000U}) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> jitter(-0.7e-6, 0.7e-6);
    const Record record = Parsed(Table(rows, [&](auto i) {
      return fmt::format("{:.9f}", 1.7e9 + 333e-6 * static_cast<double>(i) + jitter(random));
    }));
    EXPECT_EQ(record.raw_times_s.size(), rows);
    EXPECT_LT(record.stretches.at(0).time_uncertainty_s, 1e-6) << rows;
  }
}

// `names` above 300 rows that are `step` apart, from `first` on
Record CountedSince1970(const char* names, std::int64_t first, std::int64_t step,
                        std::size_t missing = 300) {
  std::string text = std::string(names) + "\n";
  for (std::size_t i = 0; i < 300; ++i) {
    const std::int64_t row = static_cast<std::int64_t>(i < missing ? i : i + 1);
    text += fmt::format("{},{}\n", first + row * step, i % 7);
  }
  const auto record = ParseCsv(text, "f.csv");
  EXPECT_TRUE(record) << record.error().Text();
  return record.value_or(Record{});
}

// a double of as many nanoseconds leaves out up to 128 of them, one of Unix seconds 120 ns
TEST(PrintedTimes, CountsSince1970HaveAllTheirDigits) {
  constexpr double kStartS = 1'682'935'200.123456;
  constexpr std::int64_t kNs = 1'682'935'200'123'456'789;
  for (const char* names : {"time_ns,voltage_v", "Time (ns),Coil (V)"}) {
    const Record ns = CountedSince1970(names, kNs, 125'000);
    EXPECT_TRUE(ns.raw_times_s.empty());
    ASSERT_EQ(ns.stretches.size(), 1U);
    EXPECT_REL(ns.stretches[0].rate_hz, 8000, 1e-14, "whole numbers");
    EXPECT_NEAR(ns.stretches[0].start_s, kStartS, 1e-6);
  }
  const Record us = CountedSince1970("time_us,voltage_v", kNs / 1000, 125);
  EXPECT_REL(us.stretches.at(0).rate_hz, 8000, 1e-14, "whole numbers");
  const Record s = CountedSince1970("time_s,voltage_v", kNs / 1'000'000'000, 2);
  EXPECT_REL(s.stretches.at(0).rate_hz, 0.5, 1e-14, "whole numbers");
  EXPECT_EQ(s.stretches[0].start_s, 1'682'935'200);
  const Record gap = CountedSince1970("time_ns,voltage_v", kNs, 125'000, 100);
  ASSERT_EQ(gap.stretches.size(), 2U);
  EXPECT_NEAR(gap.stretches[1].start_s, kStartS + 101 / 8000.0, 1e-6);
}

TEST(PrintedTimes, DecimalsSince1970HaveAllTheirDigits) {
  for (const int decimals : {4, 5, 6}) {
    const auto record = ParseCsv(Table(
                                     10'000,
                                     [&](auto i) {
                                       const std::string fraction = fmt::format(
                                           "{:.{}f}", 1e-4 * static_cast<double>(i), decimals);
                                       return "168293520" + fraction;
                                     },
                                     "time_s,voltage_v\n"),
                                 "f.csv");
    ASSERT_TRUE(record) << record.error().Text();
    EXPECT_REL(record->stretches.at(0).rate_hz, 10'000, 1e-12, "decimals");
  }
  // doubles of Unix seconds with all their digits lie on a grid as before
  const Record doubles = Parsed(Table(
      300, [](auto i) { return fmt::format("{}", 1682935200 + 125e-6 * static_cast<double>(i)); }));
  EXPECT_TRUE(doubles.raw_times_s.empty());
}

TEST(PrintedTimes, UnevenCountsSince1970AreKept) {
  std::string text = "time_us,voltage_v\n";
  for (std::int64_t i = 0; i < 300; ++i) {
    text += fmt::format("{},{}\n", 1'682'935'200'123'456 + 125 * i + i * i % 11, i % 7);
  }
  const auto record = ParseCsv(text, "f.csv");
  ASSERT_TRUE(record) << record.error().Text();
  ASSERT_EQ(record->raw_times_s.size(), 300U);
  EXPECT_NEAR(record->raw_times_s[1], 1'682'935'200.123456 + 126e-6, 1e-6);
  EXPECT_NEAR(record->stretches.at(0).start_s, 1'682'935'200.123456, 1e-5);
  const auto falling = ParseCsv("time_us,voltage_v\n1682935200000002,1\n1682935200000001,2\n", "f");
  ASSERT_FALSE(falling);
  EXPECT_THAT(falling.error().Text(), ::testing::HasSubstr("time 1682935200.000001 s does not"));
}

TEST(PrintedTimes, ARateThatDriftsIsNoGrid) {
  // 20 ppm over the record bend the line by 0.05 of an interval
  const Record record = Parsed(Table(20'000, [](auto i) {
    const double x = static_cast<double>(i);
    return Float(1e-4 * x * (1 + 1e-9 * x / 2), 12);
  }));
  EXPECT_EQ(record.raw_times_s.size(), 20'000);
}

// --- where a bound lies --------------------------------------------------------------------------
//
// A float leaves 2^-24 (largest + span) out, which counts here whatever the digits, because it is
// below a thousandth of an interval; half a unit of the ninth decimal comes on top.

double Resolution(double largest_s, double span_s) {
  return 0x1p-24 * (largest_s + span_s) + 0.5e-9;
}

std::string Rows(const std::vector<double>& times_s, std::string_view head) {
  return Table(times_s.size(), [&](auto i) { return fmt::format("{:.9f}", times_s[i]); }, head);
}

// two rows a second apart: each may be off by 1.0001 resolutions and a millionth of the interval
TEST(PrintedTimeBounds, AStatedIntervalIsTakenToTheResolutionOfBothRows) {
  constexpr const char* kHead = "Sample Interval,1\nTime (s),CH1 (V)\n";
  const double most_s = 2 * (1.0001 * Resolution(1, 1) + 1e-6);
  EXPECT_EQ(Parsed(Rows({0, 1 + 0.995 * most_s}, kHead)).stretches.at(0).rate_hz, 1);
  EXPECT_EQ(Parsed(Rows({0, 1 - 0.995 * most_s}, kHead)).stretches.at(0).rate_hz, 1);
  for (const double late_s : {1.005 * most_s, -1.005 * most_s}) {
    EXPECT_REL(Parsed(Rows({0, 1 + late_s}, kHead)).stretches.at(0).rate_hz, 1 / (1 + late_s),
               0.6e-9, "the ninth decimal");
  }
}

// the start may differ by twice the resolution and a millionth of the interval more than that
TEST(PrintedTimeBounds, AStatedStartIsTakenToThreeResolutionsAndTwoMillionths) {
  const auto start_s = [](double stated_s) {
    const std::string head =
        fmt::format("Sample Interval,1\nXOrg,{:.12f}\nTime (s),CH1 (V)\n", stated_s);
    return Parsed(Rows({0, 1}, head)).stretches.at(0).start_s;
  };
  const double most_s = 3.0001 * Resolution(1, 1) + 2e-6;
  for (const double sign : {1.0, -1.0}) {
    const double within_s = sign * 0.995 * most_s;
    EXPECT_ABS(start_s(within_s), within_s, 1e-12, "the twelfth decimal");
    EXPECT_EQ(start_s(sign * 1.005 * most_s), 0) << "the first row's own time";
  }
}

// without a stated start the first row has its own time, or the middle of what the rows allow
TEST(PrintedTimeBounds, WithoutAStartTheFirstRowsTimeOrTheMiddleOfWhatAllRowsAllow) {
  constexpr const char* kHead = "Sample Interval,1\nTime (s),CH1 (V)\n";
  EXPECT_EQ(Parsed(Rows({0.25, 1.25}, kHead)).stretches.at(0).start_s, 0.25);
  // the second row allows starts from -bound + late to bound + late, the first from -bound to bound
  const double bound_s = 1.0001 * Resolution(1, 1) + 1e-6;
  const double late_s = 1.5 * bound_s;
  EXPECT_ABS(Parsed(Rows({0, 1 + late_s}, kHead)).stretches.at(0).start_s, late_s / 2, 1e-9,
             "the ninth decimal");
}

// three rows, of which the middle one is late: its digits count, those of the ends, and a millionth
TEST(PrintedTimeBounds, AGridIsTakenToTwoResolutionsAndAMillionth) {
  constexpr const char* kHead = "Time (s),CH1 (V)\n";
  const double most_s = 2 * Resolution(2, 2) + 1e-6;
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(Parsed(Rows({0, 1 + sign * 0.995 * most_s, 2}, kHead)).raw_times_s.empty());
    EXPECT_EQ(Parsed(Rows({0, 1 + sign * 1.005 * most_s, 2}, kHead)).raw_times_s.size(), 3U);
  }
}

// Five digits from 0.5 s to 19.5 s: half a unit of the last one is 50 us below 10 s and 500 us from
// there on, and 2^-24 of 38.5 s come on top. The bound of the row at 9.5 s is 556 us, and that of
// the row at 10.5 s is 1006 us.
TEST(PrintedTimeBounds, DigitsCountForTheirOwnRowAndAtTheEndsForAll) {
  const auto is_grid = [](double late_s, std::size_t late_row) {
    std::string text = "Time (s),CH1 (V)\n";
    for (std::size_t i = 0; i < 20; ++i) {
      text += fmt::format("{:.4e},1\n", At(i, 0.5, 1) + (i == late_row ? late_s : 0));
    }
    return Parsed(text).raw_times_s.empty();
  };
  // the last row's half digit counts for all, each row's own beside it
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(is_grid(sign * 5e-4, 9));
    EXPECT_FALSE(is_grid(sign * 6e-4, 9)) << "the row behind it is coarser";
    EXPECT_TRUE(is_grid(sign * 1e-3, 10));
    EXPECT_FALSE(is_grid(sign * 2e-3, 10));
  }
}

// the first row is the coarsest: from -19.5 s to -0.5 s the bound of the row at -4.5 s is 556 us
TEST(PrintedTimeBounds, TheCoarserEndCounts) {
  const auto is_grid = [](double late_s) {
    std::string text = "Time (s),CH1 (V)\n";
    for (std::size_t i = 0; i < 20; ++i) {
      text += fmt::format("{:.4e},1\n", At(i, -19.5, 1) + (i == 15 ? late_s : 0));
    }
    return Parsed(text).raw_times_s.empty();
  };
  for (const double sign : {1.0, -1.0}) {
    EXPECT_TRUE(is_grid(sign * 5e-4));
    EXPECT_FALSE(is_grid(sign * 6e-4));
  }
}

TEST(PrintedTimeBounds, AnIntervalOfOneAndAHalfPeriodsBeginsAStretch) {
  const auto with_interval = [](double interval_s) {
    std::vector<double> times_s;
    for (int i = 0; i < 60; ++i) times_s.push_back(i < 40 ? i : 39 + interval_s + (i - 40));
    return Parsed(Rows(times_s, "Time (s),CH1 (V)\n"));
  };
  // rounding adds 2^-24 of 240 s to the bound, 14 us
  EXPECT_EQ(with_interval(1.499).raw_times_s.size(), 60U);
  const Record apart = with_interval(1.501);
  EXPECT_TRUE(apart.raw_times_s.empty());
  ASSERT_EQ(apart.stretches.size(), 2U);
  EXPECT_EQ(apart.stretches[1].first_row, 40U);
  EXPECT_EQ(apart.stretches[1].rows, 20U);
  EXPECT_EQ(apart.stretches[1].start_s, 40.501);
}

// half a unit of either time is a whole period: without a limit no missing row would be seen
TEST(PrintedTimeBounds, AMissingRowIsSeenWhereAPeriodIsOneUnitOfTheLastDigit) {
  std::string text = "Time (s),CH1 (V)\n";
  for (int i = 0; i < 40; ++i) text += fmt::format("{},0.5\n", i < 20 ? i : i + 1);
  const Record record = Parsed(text);
  ASSERT_EQ(record.stretches.size(), 2U);
  EXPECT_EQ(record.stretches[1].first_row, 20U);
  EXPECT_EQ(record.stretches[1].start_s, 21);
  EXPECT_EQ(record.stretches[0].rate_hz, 1);
}

// n rows from 0 on: 2^-23 (n - 1) intervals are a thousandth of (n - 1) / n up to n = 8388
TEST(PrintedTimeBounds, AFloatsRoundingCountsUpToAThousandthOfAnInterval) {
  const auto raw_times = [](std::size_t rows) {
    // digits of no float, and one row late by 1.5 thousandths
    const auto print = [](std::size_t i) {
      return fmt::format("{:.12f}", At(i, 0, 1e-4) + (i == 4000 ? 1.5e-7 : 0));
    };
    return Parsed(Table(rows, print)).raw_times_s.size();
  };
  EXPECT_EQ(raw_times(8388), 0U);
  EXPECT_EQ(raw_times(8389), 8389U);
}

// --- times coarser than a period -----------------------------------------------------------------

TEST(CoarseTimes, SixteenRowsProveAGrid) {
  const auto text = [](int rows) {
    std::string lines = "Time (s),CH1 (V)\n";
    for (int i = 0; i < rows; ++i) lines += fmt::format("{},{}.5\n", i / 2, i);
    return lines;
  };
  const Record record = Parsed(text(16));
  EXPECT_TRUE(record.raw_times_s.empty());
  ASSERT_EQ(record.stretches.size(), 1U);
  EXPECT_EQ(record.stretches[0].rows, 16U);
  // pairs at 0, 1, ..., 7: the longest period is of the line through rows 1 and 14, off by half a
  // digit at either, and the shortest of that through rows 0 and 15: 6 to 8 s over 13 to 15 rows
  EXPECT_REL(record.stretches[0].rate_hz, 2 / (8.0 / 15 + 6.0 / 13), 1e-5,
             "a millionth of a period");
  EXPECT_THAT(ErrorOf(text(15)), HasSubstr("no uniform grid explains it"));
}

// the rate of 2e307 Hz is a number, and that of 2e309 Hz is none
TEST(CoarseTimes, AnIntervalHasAFiniteInverse) {
  const auto text = [](int exponent) {
    std::string lines = "Time (s),CH1 (V)\n";
    for (int i = 0; i < 16; ++i) lines += fmt::format("{}e{},{}.5\n", i / 2, exponent, i);
    return lines;
  };
  EXPECT_REL(Parsed(text(-307)).stretches.at(0).rate_hz, 2 / (8.0 / 15 + 6.0 / 13) * 1e307, 1e-3,
             "sums of subnormal numbers");
  EXPECT_THAT(ErrorOf(text(-309)), HasSubstr("no uniform grid explains it"));
}

// four digits of times that end at 0: the last rows are the finest, and the line goes through them
TEST(CoarseTimes, TheFinestRowsCountMost) {
  constexpr int kRows = 1500;
  constexpr double kPeriodS = 9e-6;
  std::string text = "Time (s),CH1 (V)\n";
  for (int k = 0; k < kRows; ++k) text += fmt::format("{:.3e},1\n", (k - kRows + 1) * kPeriodS);
  const Record record = Parsed(text);
  EXPECT_TRUE(record.raw_times_s.empty());
  ASSERT_EQ(record.stretches.size(), 1U);
  EXPECT_REL(record.stretches[0].rate_hz, 1 / kPeriodS, 2e-6,
             "half a unit of 1 ns at the row before the last, and of 10 ns at the hundredth");
  EXPECT_ABS(TimeOf(record, kRows - 1), 0, 4.3e-9,
             "twice half a unit of the ninth decimal and 2^-24 of twice 13.5 ms");
}

// The first row is finer than the others, and its bound is 2 (0.05 ns + 2^-24 27 ms) = 3.3 ns. The
// line may follow it by 5.2 ns: 4.2 ns above the second row (0.5 ns is half of its last digit), it
// falls to 103 ns below row 111 (50 ns).
TEST(CoarseTimes, ARowOffItsDigitsLiesOnNoLine) {
  const auto text = [](const char* first) {
    std::string lines = fmt::format("Time (s),CH1 (V)\n{},1\n", first);
    for (int k = 1; k < 1500; ++k) lines += fmt::format("{:.3e},1\n", k * 9e-6);
    return lines;
  };
  EXPECT_TRUE(Parsed(text("8.4e-09")).raw_times_s.empty());
  EXPECT_THAT(ErrorOf(text("8.6e-09")), HasSubstr("no uniform grid explains it"));
}

// --- stated stretches ----------------------------------------------------------------------------

// a table of our own with a stretch of 1 Hz from 0 s on, whose uncertainty shows that it was taken
Record OfStretch(const std::string& head, const std::vector<double>& times_s) {
  return Parsed(head + Rows(times_s, "time_s,voltage_v\n"));
}

TEST(StatedStretches, DescribeTimesOnTheirGridToAMillionth) {
  constexpr const char* kHead = "# stretch = 0 3 0 1 0.25\n";
  EXPECT_EQ(OfStretch(kHead, {0, 1, 2 + 0.995e-6}).stretches.at(0).time_uncertainty_s, 0.25);
  EXPECT_EQ(OfStretch(kHead, {0, 1, 2 - 0.995e-6}).stretches.at(0).time_uncertainty_s, 0.25);
  EXPECT_EQ(OfStretch(kHead, {0, 1, 2 + 1.005e-6}).stretches.at(0).time_uncertainty_s, 0);
  EXPECT_EQ(OfStretch(kHead, {0, 1, 2 - 1.005e-6}).stretches.at(0).time_uncertainty_s, 0);
}

// rows are below 10^15, and a start may be later
TEST(StatedStretches, MayBeginAtAnyTime) {
  const Record record = OfStretch("# stretch = 0 3 2e15 1 0.25\n", {2e15, 2e15 + 1, 2e15 + 2});
  EXPECT_EQ(record.stretches.at(0).time_uncertainty_s, 0.25);
  EXPECT_EQ(record.stretches[0].start_s, 2e15);
}

TEST(StatedStretches, DescribePolledTimesToASecond) {
  constexpr const char* kHead = "# times = polled\n# stretch = 0 3 2 1 0.25\n";
  EXPECT_EQ(OfStretch(kHead, {2, 3, 4.995}).stretches.at(0).time_uncertainty_s, 0.25);
  EXPECT_NE(OfStretch(kHead, {2, 3, 5.005}).stretches.at(0).time_uncertainty_s, 0.25);
  EXPECT_EQ(OfStretch(kHead, {1.005, 3, 4}).stretches.at(0).time_uncertainty_s, 0.25);
  EXPECT_NE(OfStretch(kHead, {0.995, 3, 4}).stretches.at(0).time_uncertainty_s, 0.25);
}

// a host that stalls may hold half of the lines for more than a second, and lets none come early
TEST(StatedStretches, DescribeArrivalsOfWhichHalfWereHeld) {
  constexpr const char* kHead = "# times = arrived\n# stretch = 0 4 2 1 0.25\n";
  const auto uncertainty_s = [&](const std::vector<double>& times_s) {
    return OfStretch(kHead, times_s).stretches.at(0).time_uncertainty_s;
  };
  EXPECT_EQ(uncertainty_s({2, 3.995, 5.005, 6.005}), 0.25);
  EXPECT_NE(uncertainty_s({2, 4.005, 5.005, 6.005}), 0.25);
  EXPECT_EQ(uncertainty_s({1.005, 3, 4, 5}), 0.25);
  EXPECT_NE(uncertainty_s({0.995, 3, 4, 5}), 0.25);
}

TEST(StatedStretches, CoverAllRowsInOrder) {
  const std::vector<double> times_s{0, 1, 2, 3};
  for (const char* good :
       {"# stretch = 0 4 0 1 0.25\n", "# stretch = 0 2 0 1 0.25\n# stretch = 2 2 2 1 0.25\n"}) {
    EXPECT_EQ(OfStretch(good, times_s).stretches.at(0).time_uncertainty_s, 0.25) << good;
  }
  for (const char* bad :
       {"# stretch = 0 3 0 1 0.25\n", "# stretch = 0 5 0 1 0.25\n", "# stretch = 1 3 1 1 0.25\n",
        "# stretch = 0 2 0 1 0.25\n# stretch = 3 1 3 1 0.25\n",
        "# stretch = 0 2 0 1 0.25\n# stretch = 2 3 2 1 0.25\n", "# stretch = 0 4 0 1\n",
        "# stretch = 0 4 0 1 0.25 7\n", "# stretch = 0 4 0 -1 0.25\n",
        "# stretch = 0 4 0 1 -0.25\n", "# stretch = 0 4 x 1 0.25\n"}) {
    const Record record = OfStretch(bad, times_s);
    ASSERT_EQ(record.stretches.size(), 1U) << bad;
    EXPECT_EQ(record.stretches[0].rows, 4U) << bad;
    EXPECT_EQ(record.stretches[0].time_uncertainty_s, 0) << bad;
  }
}

// --- times that repeat ---------------------------------------------------------------------------

TEST(PrintedTimes, TheFewRowsThatRepeatATimeOfUnevenOnesAreLeftOut) {
  // a phone: 10 ms with jitter, one reading in 2000 with its neighbour's time
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-1e-3, 1e-3);
  Findings findings;
  std::string last;
  const auto print = [&](std::size_t i) {
    if (i != 1234) last = fmt::format("{:.9f}", At(i, 0.5, 0.01) + jitter(random));
    return last;
  };
  const auto record =
      ParseCsv(Table(2000, print, "Time (s),Acceleration (m/s^2)\n"), "f.csv", {}, &findings);
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->rows, 1999);
  EXPECT_EQ(record->raw_times_s.size(), 1999);
  EXPECT_REL(record->stretches.at(0).rate_hz, 100, 1e-3, "a row in 2000 is missing");
  EXPECT_EQ(NumbersOf(findings, FindingKind::kRowsExcluded), "excluded=1 rows=2000 line=1236");
}

TEST(PrintedTimes, OneRowInAHundredMayRepeatATime) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> jitter(-1e-3, 1e-3);
  const auto text = [&](std::size_t rows) {
    std::string last;
    return Table(
        rows,
        [&](std::size_t i) {
          if (i != 50) last = fmt::format("{:.9f}", At(i, 0.5, 0.01) + jitter(random));
          return last;
        },
        "Time (s),Acceleration (m/s^2)\n");
  };
  EXPECT_EQ(Parsed(text(100)).rows, 99U);
  EXPECT_THAT(ErrorOf(text(99)), HasSubstr("1 of 99 rows has the time of the row before"));
}

TEST(PrintedTimes, OurOwnColumnsAreTreatedAlike) {
  Findings findings;
  std::string text = "time_s,displacement_mm,status\n";
  for (int i = 0; i < 300; ++i) {
    text += fmt::format("{},{},{}\n", (i - (i > 200 ? 1 : 0)) * 0.001, i, i == 299 ? "late" : "ok");
  }
  const auto record = ParseCsv(text, "f.csv", {}, &findings);
  ASSERT_TRUE(record) << record.error().Text();
  EXPECT_EQ(record->rows, 299);
  EXPECT_EQ(record->channels.at(0).statuses.back(), SampleStatus::kLate);
  EXPECT_DOUBLE_EQ(record->channels[0].values.at(200), 0.2);
  EXPECT_DOUBLE_EQ(record->channels[0].values.at(201), 0.202);
  EXPECT_EQ(NumbersOf(findings, FindingKind::kRowsExcluded), "excluded=1 rows=300 line=203");
}

TEST(PrintedTimes, ManyRowsThatRepeatATimeAreRefusedWithTheFirstLine) {
  std::string text = "time_s,voltage_v\n";
  for (int i = 0; i < 300; ++i) {
    const int place = i - i / 37;
    text += fmt::format("{},0\n", place * 0.01);
  }
  const auto record = ParseCsv(text, "f.csv");
  ASSERT_FALSE(record);
  EXPECT_THAT(record.error().Text(),
              HasSubstr("8 of 300 rows have the time of the row before (first in line 39)"));
}

}  // namespace
}  // namespace haptometer::trial
