// What the live view shows, on readings made here: closed forms where the filter passes a tone as
// it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/residual.h"
#include "tools/acquire/live_view.h"

namespace haptometer::tools {
namespace {

using ::testing::HasSubstr;
using trial::SampleStatus;

constexpr double kRate_hz = 10e3;
constexpr double kStep_m = 1e-9;

trial::TrialHeader Header(trial::Timing timing = trial::Timing::kArrival) {
  trial::TrialHeader header;
  header.timing = timing;
  header.rate_hz = timing == trial::Timing::kUniform ? kRate_hz : 0;
  header.channels = {{.name = "displacement",
                      .role = trial::ChannelRole::kDisplacement,
                      .unit = "m",
                      .encoding = trial::Encoding::kI32,
                      .scale = kStep_m}};
  return header;
}

// row `n` of a target 2 mm off that moves by `amplitude_m` at `frequency_hz`
acquire::Reading Row(std::int64_t n, double amplitude_m, double frequency_hz,
                     double rate_hz = kRate_hz) {
  const double t_s = static_cast<double>(n) / rate_hz;
  const double x_m = 2e-3 + amplitude_m * std::sin(2 * std::numbers::pi * frequency_hz * t_s);
  acquire::Reading reading;
  reading.index = n;
  reading.time_ns = NsFromSeconds(t_s);
  reading.reply_ns = reading.time_ns;
  reading.samples = {
      {trial::RawValue::Counts(static_cast<std::int32_t>(std::lround(x_m / kStep_m))),
       SampleStatus::kOk}};
  return reading;
}

acquire::Reading Bad(std::int64_t n, SampleStatus status) {
  acquire::Reading reading = Row(n, 0, 0);
  // a number that would be seen if it were taken for a value
  reading.samples[0] = {trial::RawValue::Counts(99'999'999), status};
  return reading;
}

TEST(LiveMeter, ShowsBandRmsAndFrequencyOfATone) {
  for (const auto timing : {trial::Timing::kArrival, trial::Timing::kUniform}) {
    LiveMeter meter(Header(timing), dsp::BandPass{});
    for (int n = 0; n < 40'000; ++n) meter.Add(Row(n, 100e-6, 225));
    const LiveFigures figures = meter.Figures();
    ASSERT_TRUE(figures.band_rms && figures.tone_hz) << figures.no_band_because;
    // 1.64 s hold 368.6 periods, so at most half a period of sin^2 too many: 1/(4 pi 368) = 2e-4;
    // |H| is 1 - 1e-6 at 225 Hz
    EXPECT_REL(*figures.band_rms, 100e-6 / std::numbers::sqrt2, 4e-4, "no whole periods");
    EXPECT_ABS(*figures.tone_hz, 225, 1e-3, "steps of 1 nm, and what the start left: 1e-3 of it");
    EXPECT_REL(*figures.rate_hz, kRate_hz, 1e-9, "times are whole nanoseconds");
    EXPECT_EQ(figures.readings, 40'000U);
    EXPECT_EQ(figures.bad, 0U);
    EXPECT_EQ(figures.unit, "m");
  }
}

TEST(LiveMeter, AConstantDistanceDoesNotRing) {
  LiveMeter meter(Header(), dsp::BandPass{});
  for (int n = 0; n < 40'000; ++n) meter.Add(Row(n, 0, 0));
  const LiveFigures figures = meter.Figures();
  ASSERT_TRUE(figures.band_rms);
  EXPECT_EQ(*figures.band_rms, 0);
  EXPECT_FALSE(figures.tone_hz);
  EXPECT_DOUBLE_EQ(*figures.level, 2e-3);
}

TEST(LiveMeter, TheLevelIsLessTheTare) {
  trial::TrialHeader header = Header();
  header.metadata.tare_m = 2e-3;
  LiveMeter meter(header, dsp::BandPass{});
  meter.Add(Row(0, 0, 0));
  EXPECT_NEAR(*meter.Figures().level, 0, 1e-15);
}

TEST(LiveMeter, SaysSoWhereTheBandCannotBeObserved) {
  LiveMeter meter(Header(trial::Timing::kPolled), dsp::BandPass{});
  for (int n = 0; n < 150; ++n) meter.Add(Row(n, 100e-6, 10, 48.4));
  const LiveFigures figures = meter.Figures();
  EXPECT_FALSE(figures.band_rms);
  EXPECT_EQ(figures.no_band_because, "20-500 Hz needs 1280 new readings/s, 48.4 come");
  EXPECT_THAT(LiveLine(figures, dsp::BandPass{}), HasSubstr("20-500 Hz: 20-500 Hz needs"));
}

TEST(LiveMeter, ReadingsHandedOutAgainAreNoNewOnes) {
  LiveMeter meter(Header(), {.order = 4, .lower_hz = 20, .upper_hz = 3000});
  for (int n = 0; n < 20'000; ++n) {
    acquire::Reading row = Row(n - n % 2, 100e-6, 225);
    row.time_ns = NsFromSeconds(n / kRate_hz);
    if (n % 2 == 1) row.samples[0].status = SampleStatus::kRepeated;
    meter.Add(row);
  }
  EXPECT_THAT(meter.Figures().no_band_because, HasSubstr("7680 new readings/s, 5000 come"));
}

TEST(LiveMeter, CountsWhatIsNoMeasurementAndDoesNotFeedIt) {
  LiveMeter meter(Header(), dsp::BandPass{});
  std::int64_t n = 0;
  for (; n < 40'000; ++n) meter.Add(Row(n, 0, 0));
  // three in a row leave the filter as it stands: of a constant nothing changes
  for (const auto status : {SampleStatus::kOver, SampleStatus::kLate, SampleStatus::kClipped}) {
    meter.Add(Bad(n++, status));
  }
  for (int more = 0; more < 1000; ++more) meter.Add(Row(n++, 0, 0));
  const LiveFigures figures = meter.Figures();
  EXPECT_EQ(figures.bad, 3U);
  EXPECT_EQ(figures.clipped, 2U);
  ASSERT_TRUE(figures.band_rms);
  EXPECT_EQ(*figures.band_rms, 0);
  for (const LiveExtremes& slot : meter.Extremes()) EXPECT_NEAR(slot.greatest, 2e-3, 1e-12);
}

TEST(LiveMeter, StartsAnewAfterAHole) {
  LiveMeter meter(Header(), dsp::BandPass{});
  std::int64_t n = 0;
  for (; n < 40'000; ++n) meter.Add(Row(n, 100e-6, 225));
  for (int more = 0; more < 4; ++more) meter.Add(Bad(n++, SampleStatus::kInvalid));
  meter.Add(Row(n++, 100e-6, 225));
  EXPECT_EQ(meter.Figures().no_band_because, "settling");
  EXPECT_FALSE(meter.Figures().band_rms);
  for (int more = 0; more < 40'000; ++more) meter.Add(Row(n++, 100e-6, 225));
  EXPECT_REL(*meter.Figures().band_rms, 100e-6 / std::numbers::sqrt2, 4e-4, "as above");
}

TEST(LiveMeter, AHoleInAGridIsOneToo) {
  LiveMeter meter(Header(trial::Timing::kUniform), dsp::BandPass{});
  std::int64_t n = 0;
  for (; n < 40'000; ++n) meter.Add(Row(n, 100e-6, 225));
  meter.Add(Row(n + 3, 100e-6, 225));
  EXPECT_TRUE(meter.Figures().band_rms) << "three are missing";
  meter.Add(Row(n + 8, 100e-6, 225));
  EXPECT_FALSE(meter.Figures().band_rms) << "four are missing";
}

TEST(LiveMeter, KeepsTheExtremesOfTheLastFiveSeconds) {
  LiveMeter meter(Header(), dsp::BandPass{});
  EXPECT_TRUE(meter.Extremes().empty());
  for (int n = 0; n < 120'000; ++n) meter.Add(Row(n, 100e-6, 225));
  const auto extremes = meter.Extremes();
  ASSERT_EQ(extremes.size(), LiveMeter::kSlots);
  EXPECT_NEAR(extremes.front().time_s, 12 - 5, 1e-9);
  EXPECT_NEAR(extremes.back().time_s, 12 - 0.05, 1e-9);
  for (const LiveExtremes& slot : extremes) {
    // 44 samples a period: the nearest to the crest is within pi/44 of it, 1 - cos = 2.5e-3
    EXPECT_ABS(slot.least, 2e-3 - 100e-6, 0.3e-6, "the crest lies between two samples");
    EXPECT_ABS(slot.greatest, 2e-3 + 100e-6, 0.3e-6, "the crest lies between two samples");
  }
}

TEST(LiveMeter, OtherChannelsAreShownInTheirUnit) {
  trial::TrialHeader header = Header();
  header.channels[0].role = trial::ChannelRole::kVoltage;
  header.channels[0].unit = "V";
  LiveMeter meter(header, dsp::BandPass{});
  EXPECT_THAT(LiveLine(meter.Figures(), dsp::BandPass{}), HasSubstr("no measurement"));
  meter.Add(Row(0, 0, 0));
  EXPECT_THAT(LiveLine(meter.Figures(), dsp::BandPass{}), HasSubstr("0.002 V"));
}

}  // namespace
}  // namespace haptometer::tools
