// The clock that the lines above a table state, and the rate that its words do.
#include "trial/import/table/stated_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/findings.h"
#include "tests/residual.h"

namespace haptometer::trial {
namespace {

using tests::NumbersOf;

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using Lines = std::initializer_list<const char*>;

std::vector<TableKey> KeysOf(const Lines& lines, char separator) {
  std::vector<TableKey> keys;
  for (const char* line : lines) {
    if (auto key = ReadTableKey(line, separator)) keys.push_back(*key);
  }
  return keys;
}

std::optional<StatedClock> ClockOf(const Lines& lines, char separator = ';') {
  const auto clock = FindStatedClock(KeysOf(lines, separator), "f");
  EXPECT_TRUE(clock) << clock.error().Text();
  return clock ? *clock : std::nullopt;
}

double IntervalOf(const char* line) {
  const auto clock = ClockOf({line});
  return clock ? clock->interval_s : std::numeric_limits<double>::quiet_NaN();
}

// --- keys ----------------------------------------------------------------------------------------

TEST(TableKeys, TheNumberOfAChannelIsTakenOff) {
  const auto values = [](const char* line) { return ReadTableKey(line, ',').value().values; };
  EXPECT_THAT(values("Sample Interval,CH1:0.05"), ElementsAre("0.05"));
  EXPECT_THAT(values("Sample Interval,CH12: 0.05,CH:7"), ElementsAre("0.05", "7"));
  // another word in front of a colon belongs to the value
  EXPECT_THAT(values("Name,CHa:5,CH1b:5,CHAN1:5,AB1:5"),
              ElementsAre("CHa:5", "CH1b:5", "CHAN1:5", "AB1:5"));
}

TEST(TableKeys, AKeyStandsInOneCellOrInSeveral) {
  for (const char* line : {"#CLOCK=20uS", "CLOCK:,20uS", "CLOCK ,20uS,,", "# CLOCK : 20uS"}) {
    const auto key = ReadTableKey(line, ',');
    ASSERT_TRUE(key) << line;
    EXPECT_EQ(key->key, "CLOCK");
    EXPECT_THAT(key->values, ElementsAre("20uS"));
  }
  for (const char* line : {"CLOCK", "CLOCK,", ",20uS", ":,20uS", "CLOCK,,20uS"}) {
    EXPECT_FALSE(ReadTableKey(line, ',')) << line;
  }
}

TEST(TableKeys, AreFoundByTheirLettersAndDigits) {
  const std::vector<TableKey> keys{{.key = "A`{/:@[b 0-9\u00b5~", .values = {"1"}},
                                   {.key = "ab09\u00b5", .values = {"2"}},
                                   {.key = "ab09", .values = {"3"}}};
  EXPECT_THAT(ValuesOf(keys, "aB09\u00b5"), ElementsAre("1"));
  EXPECT_THAT(ValuesOf(keys, "a(b)09"), ElementsAre("3"));
  EXPECT_THAT(ValuesOf(keys, "b09"), ElementsAre());
}

// --- intervals and rates -------------------------------------------------------------------------

struct Stated {
  const char* line;
  double interval_s;
};

TEST(StatedClocks, ARateHasThePrefixOfItsUnit) {
  constexpr Stated kRates[]{
      {"Sample Rate;250", 1 / 250.0},           {"Sample Rate;250 Hz", 1 / 250.0},
      {"Sample Rate;2.5kHz", 1 / 2500.0},       {"Sample Rate;4 KSa/s", 1 / 4e3},
      {"Sampling Rate;5 MS/s", 1 / 5e6},        {"Sample Rate;2GSa/s", 1 / 2e9},
      {"Sampling Frequency (Hz);8000", 1 / 8e3}};
  for (const Stated& stated : kRates) {
    EXPECT_REL(IntervalOf(stated.line), stated.interval_s, 4e-16, "one product and one quotient");
  }
  for (const char* line : {"Sample Rate;0 Hz", "Sample Rate;-5 Hz", "Sample Rate;5 V",
                           "Sample Rate;5 mHz", "Sample Rate;inf", "Sample Rate;often"}) {
    EXPECT_TRUE(std::isnan(IntervalOf(line))) << line;
  }
}

TEST(StatedClocks, AnIntervalHasAUnitOfTimeOrSeconds) {
  constexpr Stated kIntervals[]{{"Sample Interval;20.0uS", 20e-6},
                                {"Sampling Interval;2 ms", 2e-3},
                                {"delta t;0.5", 0.5},
                                {"XInc:;1e-9", 1e-9},
                                {"Increment;8e-5", 8e-5},
                                {"#CLOCK=80ns", 80e-9},
                                {"Time interval : 80.0000uS", 80e-6},
                                {"Sampling Period;4 s", 4},
                                {"HResolution;0.25", 0.25}};
  for (const Stated& stated : kIntervals) {
    EXPECT_REL(IntervalOf(stated.line), stated.interval_s, 4e-16, "one product");
  }
  for (const char* line :
       {"Sample Interval;0", "Sample Interval;-1", "Sample Interval;5 V", "Sample Interval;1e-320",
        "Interval;5", "Sample Interval;often", "Sample Interval;5 parsec"}) {
    EXPECT_TRUE(std::isnan(IntervalOf(line))) << line;
  }
}

TEST(StatedClocks, TwoStatementsAgreeToAMillionth) {
  // 1 ms and 0.99e-6 or 1.01e-6 of it more or less
  for (const char* second :
       {"Sampling Interval;1.00000099e-3", "Sampling Interval;0.99999901e-3"}) {
    const auto clock = ClockOf({"Sample Interval;1e-3", second});
    ASSERT_TRUE(clock);
    EXPECT_EQ(clock->interval_s, 1e-3) << "the first";
  }
  for (const char* second :
       {"Sampling Interval;1.00000101e-3", "Sampling Interval;0.99999899e-3"}) {
    const auto clock = FindStatedClock(KeysOf({"Sample Interval;1e-3", second}, ';'), "f");
    ASSERT_FALSE(clock);
    EXPECT_THAT(clock.error().Text(), HasSubstr("f: states two sample intervals: 0.001 s by"));
  }
}

TEST(StatedClocks, TheFirstRowIsWhereTheTriggerOrAKeyPutsIt) {
  const auto start = [](const Lines& lines) { return ClockOf(lines).value().start_s; };
  EXPECT_EQ(start({"Sample Interval;0.25"}), std::nullopt);
  EXPECT_EQ(start({"Sample Interval;0.25", "Trigger Point;1000"}), -250);
  EXPECT_EQ(start({"Sample Interval;0.25", "Zero Index;2.5"}), -0.625);
  EXPECT_EQ(start({"XInc;0.25", "XOrg;-0.125"}), -0.125);
  EXPECT_EQ(start({"HResolution;0.25", "HOffset;-3"}), -3);
  EXPECT_EQ(start({"HResolution;0.25", "HOffset;-3", "HUnit;ms"}), -3e-3);
  // the trigger counts first, and a number of two meanings not at all
  EXPECT_EQ(start({"XInc;0.25", "XOrg;8", "Trigger Point;4"}), -1);
  EXPECT_EQ(start({"XInc;0.25", "XOrg;-1,000"}), std::nullopt);
  EXPECT_EQ(start({"XInc;0.25", "XOrg;-1,5"}), -1.5);
}

TEST(StatedClocks, AStartWithoutANumberOrAUnitOfTimeIsNone) {
  const auto start = [](const Lines& lines) { return ClockOf(lines).value().start_s; };
  EXPECT_EQ(start({"XInc;0.25", "XOrg;late"}), std::nullopt);
  EXPECT_EQ(start({"XInc;0.25", "XOrg;inf"}), std::nullopt);
  EXPECT_EQ(start({"XInc;0.25", "HOffset;-3", "HUnit;V"}), std::nullopt);
  EXPECT_EQ(start({"XInc;0.25", "HOffset;-3", "HUnit;furlong"}), std::nullopt);
  // an index that is none leaves the start to another key
  EXPECT_EQ(start({"XInc;0.25", "Trigger Point;none", "Zero Index;2"}), -0.5);
  const auto refused = FindStatedClock(KeysOf({"HResolution;0.25", "HUnit;V"}, ';'), "f");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().Text(), HasSubstr("f: has 'HUnit' V, which is no time"));
}

// "100,000 Hz" in a line that commas separate is the number's cell and its thousands
TEST(StatedClocks, ThousandsBehindTheSeparatorBelongToTheNumber) {
  const auto printed = [](const char* line) { return ClockOf({line}, ',').value().printed; };
  EXPECT_EQ(printed("Sample Rate,100,000 Hz"), "100,000");
  EXPECT_EQ(printed("Sample Rate,100,often"), "100");
  EXPECT_EQ(printed("Sample Rate,100 Hz"), "100");
  EXPECT_EQ(ClockOf({"Sample Rate,often,000"}, ','), std::nullopt);
}

TEST(StatedClocks, ANumberMayGroupThousandsByAPointBesideDecimalCommas) {
  const auto clock = [](const char* printed) { return StatedClock{.printed = printed}; };
  EXPECT_TRUE(MayGroupThousands(clock("1,000"), false));
  EXPECT_TRUE(MayGroupThousands(clock("1.000"), true));
  EXPECT_FALSE(MayGroupThousands(clock("1.000"), false));
  EXPECT_FALSE(MayGroupThousands(clock("1000"), true));
}

TEST(StatedClocks, RowsAreAWholeNumberOfAtLeastOne) {
  const auto rows = [](const char* line) { return FindStatedRows(KeysOf({line}, ';')); };
  EXPECT_EQ(rows("Record Length;2500"), 2500U);
  EXPECT_EQ(rows("Record Length;Analog:7000"), 7000U);
  EXPECT_EQ(rows("Samples;1"), 1U);
  EXPECT_EQ(rows("Points;999999999999999"), 999'999'999'999'999U);
  for (const char* line :
       {"Samples;0", "Samples;-5", "Samples;2.5", "Samples;1e15", "Samples;many", "Rows;7"}) {
    EXPECT_EQ(rows(line), std::nullopt) << line;
  }
}

// --- rates in words ------------------------------------------------------------------------------

TEST(StatedRates, ANumberWithHertzInANoteAboutSampling) {
  const auto rate = [](const char* note) {
    Metadata metadata;
    metadata.notes = {note};
    return StatedRate(metadata);
  };
  EXPECT_EQ(rate("sampled at 250 Hz"), 250);
  EXPECT_EQ(rate("Sampling rate: 1.5kHz, 16 bits"), 1500);
  EXPECT_EQ(rate("SAMPLE RATE = 2 MHz"), 2e6);
  EXPECT_EQ(rate("rate 3GHz"), 3e9);
  for (const char* note : {"drive 225 Hz", "sampled often", "Hz sample", "rate -5 Hz", "rate 0 Hz",
                           "rate in Hz", "rate 1e999 Hz"}) {
    EXPECT_EQ(rate(note), std::nullopt) << note;
  }
}

TEST(StatedRates, TheNominalRateThenAFieldThenANote) {
  Metadata metadata;
  metadata.notes = {"sampled at 3 Hz"};
  EXPECT_EQ(StatedRate(metadata), 3);
  metadata.fields["sample_rate_hz"] = "2";
  EXPECT_EQ(StatedRate(metadata), 2);
  metadata.nominal_rate_hz = 1;
  EXPECT_EQ(StatedRate(metadata), 1);
  // a field that ends in _hz holds a number above 0, or words with a unit
  for (const auto& [value, rate_hz] : {std::pair{"2.5 kHz", std::optional(2500.0)},
                                       {"often", std::nullopt},
                                       {"-5", std::nullopt},
                                       {"0", std::nullopt}}) {
    Metadata words;
    words.fields["sample_rate_hz"] = value;
    EXPECT_EQ(StatedRate(words), rate_hz) << value;
  }
}

std::string Contradiction(double rate_hz, double stated_hz) {
  Record record;
  record.stretches = {{.rows = 2, .rate_hz = 77}, {.rows = 3, .rate_hz = rate_hz}};
  record.metadata.nominal_rate_hz = stated_hz;
  Findings findings;
  FindContradictedRate(record, findings);
  return NumbersOf(findings, FindingKind::kTimesInOtherUnit);
}

// a power of a thousand to 0.021 decades, which are 4.954 % more and 4.720 % less
TEST(StatedRates, APowerOfAThousandIsMeantToFivePercent) {
  EXPECT_EQ(Contradiction(1, 1000), "rate_hz=1 stated_hz=1000") << "of the longest stretch";
  EXPECT_EQ(Contradiction(1, 1049), "rate_hz=1 stated_hz=1049");
  EXPECT_EQ(Contradiction(1, 1050), "none");
  EXPECT_EQ(Contradiction(1, 953.5), "rate_hz=1 stated_hz=953.5");
  EXPECT_EQ(Contradiction(1, 952.0), "none");
  EXPECT_EQ(Contradiction(1, 1e6), "rate_hz=1 stated_hz=1e+06");
  EXPECT_EQ(Contradiction(1000, 1), "rate_hz=1000 stated_hz=1");
  EXPECT_EQ(Contradiction(1000, 1000), "none");
  EXPECT_EQ(Contradiction(1, 100), "none");
  EXPECT_EQ(Contradiction(std::numeric_limits<double>::infinity(), 1000), "none");
  Record without;
  without.metadata.nominal_rate_hz = 1000;
  Findings findings;
  FindContradictedRate(without, findings);
  EXPECT_TRUE(findings.list().empty()) << "no rows";
}

}  // namespace
}  // namespace haptometer::trial
