// The mean of the second before a recording, from a sensor that is scripted, on a clock that stands
// still.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "tests/residual.h"
#include "tools/acquire/check.h"

namespace haptometer::tools {
namespace {

using acquire::Outcome;
using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;
const std::atomic<bool> kNeverStop{false};

// a row every 10 ms, whose counts go up by one, until `then`
class Scripted final : public acquire::Sensor {
 public:
  explicit Scripted(Clock& clock) : clock_(clock) {
    header_.timing = trial::Timing::kPolled;
    header_.channels = {{.name = "voltage", .role = trial::ChannelRole::kVoltage, .unit = "V"},
                        {.name = "displacement",
                         .role = trial::ChannelRole::kDisplacement,
                         .unit = "m",
                         .encoding = trial::Encoding::kI32,
                         .scale = 1e-6}};
  }
  Result<void> Start(const std::atomic<bool>& /*stop*/) override { return {}; }
  const trial::TrialHeader& header() const override { return header_; }
  acquire::Findings Found() const override { return {}; }
  MonotonicNs Begin() override { return clock_.Now(); }
  Outcome Next(acquire::Reading& reading) override {
    clock_.SleepUntil(clock_.Now() + 10 * kMs);
    if (is_slow) clock_.SleepUntil(clock_.Now() + 990 * kMs);
    reading.index = asked;
    ++asked;
    if (then && asked > rows) return *then;
    const auto status =
        bad_every > 0 && asked % bad_every == 0 ? SampleStatus::kInvalid : SampleStatus::kOk;
    // what is no measurement holds a number that would be seen
    const int counts = status == SampleStatus::kOk ? asked : -99'998;
    reading.samples = {{trial::RawValue::F64(7), SampleStatus::kOk},
                       {trial::RawValue::Counts(counts), status}};
    last_was_bad = status != SampleStatus::kOk;
    return Outcome::kReading;
  }
  std::uint64_t discarded_bytes() const override { return 0; }

  int asked = 0;
  int rows = 0;
  int bad_every = 0;
  bool is_slow = false;  ///< a row takes a second to come
  bool last_was_bad = false;
  std::optional<Outcome> then;
  trial::TrialHeader header_;

 private:
  Clock& clock_;
};

TEST(Tare, IsTheMeanOverASecond) {
  ManualClock clock;
  Scripted sensor(clock);
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_TRUE(tare_m) << tare_m.error().Text();
  EXPECT_EQ(sensor.asked, 100);
  EXPECT_REL(*tare_m, 50.5e-6, 1e-14, "1 to 100 counts of 1 um; rounding");
}

TEST(Tare, LeavesOutWhatIsNoMeasurementAndEndsBehindOneThatIs) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.bad_every = 2;  // the 100th is bad: one more is asked for
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_TRUE(tare_m);
  EXPECT_EQ(sensor.asked, 101);
  EXPECT_FALSE(sensor.last_was_bad) << "a late reply may be outstanding";
  EXPECT_REL(*tare_m, 51e-6, 1e-14, "the mean of 1, 3, ... 101; rounding");
}

TEST(Tare, WithoutAMeasurementThereIsNone) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.bad_every = 1;
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_FALSE(tare_m);
  EXPECT_EQ(tare_m.error().cause, Cause::kCannotAnswer);
  EXPECT_EQ(clock.Now(), 3 * kNsPerS) << "no longer than that";
}

TEST(Tare, ASensorThatGoesAwayIsAnError) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.rows = 5;
  sensor.then = Outcome::kGone;
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_FALSE(tare_m);
  EXPECT_EQ(tare_m.error().cause, Cause::kFailed);
}

TEST(Tare, OneThatWouldBeWaitedForIsLostToo) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.rows = 5;
  sensor.then = Outcome::kAway;
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_FALSE(tare_m);
  EXPECT_EQ(tare_m.error().cause, Cause::kFailed);
  EXPECT_THAT(tare_m.error().Text(), ::testing::HasSubstr("connection was lost during --tare"));
  EXPECT_EQ(sensor.asked, 6) << "at once";
}

TEST(Tare, InputThatEndsIsNoCable) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.rows = 5;
  sensor.then = Outcome::kEnd;
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_FALSE(tare_m);
  EXPECT_EQ(tare_m.error().cause, Cause::kCannotAnswer);
  EXPECT_THAT(tare_m.error().Text(), ::testing::HasSubstr("ended during --tare"));
  EXPECT_THAT(tare_m.error().Text(), ::testing::Not(::testing::HasSubstr("cable")));
}

// rows on a grid may come all at once, or at their leisure
TEST(Tare, OfAUniformSourceIsASecondOfItsOwn) {
  for (const bool is_slow : {false, true}) {
    ManualClock clock;
    Scripted sensor(clock);
    sensor.header_.timing = trial::Timing::kUniform;
    sensor.header_.rate_hz = 20;
    sensor.is_slow = is_slow;
    const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
    ASSERT_TRUE(tare_m) << tare_m.error().Text();
    EXPECT_EQ(sensor.asked, 20);
    EXPECT_REL(*tare_m, 10.5e-6, 1e-14, "1 to 20 counts of 1 um; rounding");
  }
}

TEST(Tare, OfAUniformSourceCountsBadRowsAsTime) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.header_.timing = trial::Timing::kUniform;
  sensor.header_.rate_hz = 20;
  sensor.bad_every = 2;
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_TRUE(tare_m);
  EXPECT_EQ(sensor.asked, 20);
  EXPECT_REL(*tare_m, 10e-6, 1e-14, "the mean of 1, 3, ... 19; rounding");
}

TEST(Tare, AUniformSourceThatFallsSilentIsNotWaitedForForEver) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.header_.timing = trial::Timing::kUniform;
  sensor.header_.rate_hz = 20;
  sensor.rows = 5;
  sensor.then = Outcome::kNothing;
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_FALSE(tare_m);
  EXPECT_EQ(tare_m.error().cause, Cause::kCannotAnswer);
  EXPECT_LT(clock.Now(), 4 * kNsPerS);
}

TEST(Tare, NeedsADisplacement) {
  ManualClock clock;
  Scripted sensor(clock);
  sensor.header_.channels.pop_back();
  const auto tare_m = MeasureTare(sensor, clock, kNeverStop, "port");
  ASSERT_FALSE(tare_m);
  EXPECT_THAT(tare_m.error().Text(), ::testing::HasSubstr("no displacement to tare"));
}

TEST(Tare, EndsWhenItIsStopped) {
  ManualClock clock;
  Scripted sensor(clock);
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(MeasureTare(sensor, clock, stop, "port"));
  EXPECT_EQ(sensor.asked, 0);
}

}  // namespace
}  // namespace haptometer::tools
