// Records that hold little or nothing: an answer of finite numbers, or a refusal that says why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/findings.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

using trial::SampleStatus;

constexpr double kRateHz = 10e3;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// every number that a reader would see
void ExpectNumbers(const BandAnalysis& analysis) {
  EXPECT_TRUE(analysis.numbers || !analysis.answered);
  EXPECT_EQ(analysis.answered, !analysis.findings.Refused());
  EXPECT_TRUE(std::isfinite(analysis.record.offset_m));
  EXPECT_TRUE(std::isfinite(analysis.record.peak_to_peak_m));
  if (!analysis.numbers) return;
  const BandNumbers& numbers = *analysis.numbers;
  EXPECT_LE(numbers.rms.lower_m, numbers.rms.rms_m);
  EXPECT_LE(numbers.rms.rms_m, numbers.rms.upper_m);
  for (const double number :
       {numbers.rms.rms_m, numbers.rms.lower_m, numbers.rms.upper_m, numbers.rms.at_most_m,
        numbers.rms.standard_uncertainty_m, numbers.peak_to_peak_m, numbers.residual_rms_m}) {
    EXPECT_TRUE(std::isfinite(number)) << number;
  }
  for (const UncertaintyLine& line : numbers.rms.budget) {
    EXPECT_TRUE(std::isfinite(line.standard_uncertainty_m)) << static_cast<int>(line.cause);
  }
  if (!numbers.tone) return;
  for (const double number : {numbers.tone->amplitude_m, numbers.tone->amplitude_uncertainty_m,
                              numbers.tone->share_of_rms, numbers.tone->frequency_upper_hz}) {
    EXPECT_TRUE(std::isfinite(number)) << number;
  }
}

BandAnalysis Answer(std::vector<double> values, const BandQuestion& question = {}) {
  auto analysis = AnalyzeBand(RecordOf(std::move(values), kRateHz), question);
  EXPECT_TRUE(analysis) << (analysis ? "" : analysis.error().Text());
  if (!analysis) return {};
  ExpectNumbers(*analysis);
  return *analysis;
}

std::string Refusal(std::vector<double> values) {
  const auto analysis = AnalyzeBand(RecordOf(std::move(values), kRateHz), {});
  EXPECT_FALSE(analysis);
  return analysis ? "" : analysis.error().Text();
}

TEST(HardRecords, NoReadingsSayIs) {
  EXPECT_EQ(Refusal({}), "holds no readings; record again");
  trial::Record none = RecordOf({}, kRateHz);
  none.stretches.clear();
  EXPECT_EQ(AnalyzeBand(none, {}).error().Text(), "holds no readings; record again");
}

TEST(HardRecords, ReadingsThatAreNoNumbersAreCounted) {
  EXPECT_EQ(Refusal(std::vector<double>(500, kNaN)),
            "none of its 500 readings is a measurement (without a value 500); check the target and "
            "the sensor's range");
  EXPECT_EQ(Refusal(std::vector<double>(3, -kInf)),
            "none of its 3 readings is a measurement (without a value 3); check the target and the "
            "sensor's range");
}

TEST(HardRecords, OneReadingToFiveAreTooShort) {
  for (std::size_t count = 1; count <= 5; ++count) {
    const BandAnalysis analysis = Answer(Samples(kRateHz, count, 0.03, {{1e-6, 100}}));
    EXPECT_FALSE(analysis.answered) << count;
    EXPECT_THAT(RefusalsIn(analysis.findings), ::testing::ElementsAre(FindingKind::kTooShort));
  }
}

TEST(HardRecords, OneReadingAmongNoNumbersIsTooShort) {
  std::vector<double> values(20'000, kNaN);
  values[777] = 0.03;
  const BandAnalysis analysis = Answer(values);
  EXPECT_FALSE(analysis.answered);
  EXPECT_EQ(analysis.record.measured, 1U);
  EXPECT_EQ(analysis.record.offset_m, 0.03);
}

TEST(HardRecords, AConstantIsAStuckSensorAndNoSilence) {
  for (const double constant : {0.0, 0.03, -1e-300, 5e-324, 1e30}) {
    const BandAnalysis analysis = Answer(std::vector<double>(30'000, constant));
    EXPECT_FALSE(analysis.answered) << constant;
    EXPECT_FALSE(analysis.numbers) << "0 um would be an invented number";
    EXPECT_THAT(RefusalsIn(analysis.findings), ::testing::ElementsAre(FindingKind::kStuck));
    EXPECT_EQ(NumberOf(analysis.findings, FindingKind::kStuck, "readings"), 30'000);
    EXPECT_EQ(analysis.record.peak_to_peak_m, 0);
  }
}

TEST(HardRecords, EveryOtherReadingBadLeavesNoPiece) {
  std::vector<double> values = Samples(kRateHz, 30'000, 0.03, {{1e-6, 100}});
  for (std::size_t k = 0; k < values.size(); k += 2) values[k] = k % 4 == 0 ? kNaN : kInf;
  EXPECT_FALSE(Answer(values).answered);
}

TEST(HardRecords, NumbersWhoseSquaresUnderflowAreNotTold) {
  // 1e-310 m and its square: nothing divides by the RMS that is left
  for (const double amplitude_m : {1e-310, 1e-170}) {
    const BandAnalysis analysis = Answer(Samples(kRateHz, 30'000, 0, {{amplitude_m, 100}}));
    EXPECT_FALSE(analysis.answered) << amplitude_m;
    ASSERT_TRUE(analysis.numbers) << amplitude_m;
    EXPECT_EQ(analysis.numbers->rms.rms_m, 0) << amplitude_m;
  }
}

TEST(HardRecords, NumbersWhoseSquaresAreSmallAreTold) {
  const BandAnalysis analysis = Answer(Samples(kRateHz, 30'000, 0, {{1e-150, 100}}));
  ASSERT_TRUE(analysis.answered);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-150 / std::numbers::sqrt2, 1e-4,
             "|H|^2 of the filter; squares of 1e-300 keep their digits");
}

TEST(HardRecords, NumbersWhoseSquaresOverflowAreRefused) {
  for (const double amplitude_m : {1e160, 1e300}) {
    const auto analysis =
        AnalyzeBand(RecordOf(Samples(kRateHz, 30'000, 0, {{amplitude_m, 100}}), kRateHz), {});
    ASSERT_FALSE(analysis);
    EXPECT_EQ(analysis.error().cause, Cause::kCannotAnswer);
    EXPECT_THAT(analysis.error().what, ::testing::HasSubstr("not a displacement"));
  }
}

TEST(HardRecords, OneImpossibleReadingIsExcluded) {
  std::vector<double> values = Samples(kRateHz, 30'000, 0.03, {{1e-6, 100}});
  values[12'345] = -std::numeric_limits<double>::max();
  const BandAnalysis analysis = Answer(std::move(values));
  ASSERT_TRUE(analysis.answered);
  EXPECT_EQ(analysis.record.bridged, 1U);
  EXPECT_REL(analysis.numbers->rms.rms_m, 1e-6 / std::numbers::sqrt2, 1e-4,
             "|H|^2 of the filter and one interpolated row");
}

}  // namespace
}  // namespace haptometer::dsp
