// Time columns as exporters print them: which of them are a clock's, and which are not.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

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

TEST(PrintedTimes, ARateThatDriftsIsNoGrid) {
  // 20 ppm over the record bend the line by 0.05 of an interval
  const Record record = Parsed(Table(20'000, [](auto i) {
    const double x = static_cast<double>(i);
    return Float(1e-4 * x * (1 + 1e-9 * x / 2), 12);
  }));
  EXPECT_EQ(record.raw_times_s.size(), 20'000);
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
