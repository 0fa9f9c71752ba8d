#include "dsp/analysis/record_doubts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tests/dsp/records.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kRateHz = 5000;
constexpr std::size_t kRows = 10'000;

BandAnalysis Answer(const trial::Record& record) { return AnalyzeBand(record, {}).value(); }

// 20 um at 225 Hz, 30 mm away, all times `scale`
trial::Record Tone(double scale) {
  return RecordOf(Samples(kRateHz, kRows, 0.03 * scale, {{20e-6 * scale, 225}}), kRateHz);
}

TEST(RecordDoubts, AFewOtherReadingsDoNotMakeAStuckSensorVibrate) {
  std::vector<double> values(kRows, 0.03);
  values[4000] = 0.0301;
  values[6000] = values[6001] = 0.0299;
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
  EXPECT_FALSE(analysis.answered);
  EXPECT_FALSE(analysis.numbers);
  EXPECT_THAT(analysis.reasons, Contains(HasSubstr("a stuck sensor, held readings")));
}

TEST(RecordDoubts, AShortBurstOnCoarseStepsIsNoStuckSensor) {
  std::vector<double> values(kRows, 6000 * 5e-6);
  const auto burst = Samples(kRateHz, 2000, 0.03, {{20e-6, 225}});
  for (std::size_t k = 0; k < burst.size(); ++k) {
    values[4000 + k] = std::round(burst[k] / 5e-6) * 5e-6;  // steps of 5 um
  }
  const BandAnalysis analysis = Answer(RecordOf(values, kRateHz));
  EXPECT_TRUE(analysis.answered);
}

TEST(RecordDoubts, LengthsOffByAThousandAreDoubted) {
  EXPECT_THAT(Answer(Tone(1)).remarks, Each(Not(HasSubstr("is the column in"))));
  EXPECT_THAT(Answer(Tone(1e3)).remarks, Contains(HasSubstr("readings reach 30 m, farther than")));
  trial::Record tared = RecordOf(Samples(kRateHz, kRows, 0, {{20e-3, 225}}), kRateHz);
  EXPECT_THAT(Answer(tared).remarks, Contains(HasSubstr("14.1 mm RMS is more than any tactile")));
  EXPECT_THAT(Answer(Tone(1e-6)).remarks, Contains(HasSubstr("0.014 nm RMS is less than any")));
}

TEST(RecordDoubts, MoreReadingsThanTheSamplingPeriodAllowsAreNamed) {
  trial::Record record = Tone(1);
  record.metadata.averages = 4;
  record.metadata.sampling_s = 1 / kRateHz;
  EXPECT_THAT(Answer(record).remarks, Each(Not(HasSubstr("one of them is wrong"))));
  record.metadata.sampling_s = 1e-3;
  EXPECT_THAT(Answer(record).remarks,
              Contains(HasSubstr("every 1 ms, 1000 times a second, but 5000 new readings")));
}

TEST(RecordDoubts, MillisecondsReadAsSecondsAreGuessed) {
  trial::Record record = Tone(1);
  record.metadata.source = "imported";
  EXPECT_THAT(Answer(record).remarks, Each(Not(HasSubstr("read as time_"))));
  record.stretches.front().rate_hz = kRateHz / 1000;
  const BandAnalysis analysis = Answer(record);
  EXPECT_FALSE(analysis.answered);
  EXPECT_THAT(analysis.remarks,
              Contains(AllOf(HasSubstr("read as time_ms, the times would be 5000 readings"),
                             Not(HasSubstr("displacement_")))));
  record.metadata.nominal_rate_hz = kRateHz / 1000;  // somebody said so
  EXPECT_THAT(Answer(record).remarks, Each(Not(HasSubstr("read as time_"))));
  record.metadata.nominal_rate_hz.reset();
  record.metadata.sensor = "keyence-il";  // that is a slow one
  EXPECT_THAT(Answer(record).remarks, Each(Not(HasSubstr("read as time_"))));
}

}  // namespace
}  // namespace haptometer::dsp
