// A sensor that goes away and comes back.
#include "acquire/sensor/reconnecting_sensor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <utility>
#include <vector>

#include "tests/acquire/recorder_fixture.h"
#include "tests/findings.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;

using ::testing::HasSubstr;
using trial::Timing;

/// A port that is there or not.
class Plug {
 public:
  explicit Plug(Clock& clock) : clock_(clock) {}
  ReconnectingSensor::Open Opener() {
    return [this]() -> Result<std::unique_ptr<Sensor>> {
      tries_ns.push_back(clock_.Now());
      if (clock_.Now() < absent_until_ns)
        return CannotAnswer("./port", "is not there", "plug it in");
      absent_until_ns = clock_.Now() + away_ns;
      auto sensor = std::make_unique<CountingSensor>(clock_, timing, rows, Outcome::kGone);
      sensor->metadata().averages = averages;
      if (change) change(*sensor);
      return sensor;
    };
  }
  MonotonicNs away_ns = 0;  ///< how long it is absent after each opening
  std::uint64_t rows = 10;
  Timing timing = Timing::kPolled;
  int averages = 1;
  std::function<void(CountingSensor&)> change{};  ///< of what is plugged in
  std::vector<MonotonicNs> tries_ns;
  MonotonicNs absent_until_ns = 0;

 private:
  Clock& clock_;
};

class ReconnectingTest : public RecorderTest {
 protected:
  Plug plug_{clock_};
};

TEST_F(ReconnectingTest, ReadingsGoOnAndTheTrialSaysWhatHappened) {
  plug_.away_ns = 5000 * kMs;
  ReconnectingSensor sensor(plug_.Opener(), {}, clock_);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  const auto summary = Run(sensor, {.readings = 25});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 25U);
  EXPECT_EQ(summary->reconnects, 2U);
  EXPECT_EQ(summary->gaps, 2U) << "each absence is one, not two";
  EXPECT_EQ(summary->discarded_bytes, 3 * 17U);
  EXPECT_FALSE(summary->connection_lost);
  Counts(path_);
  ASSERT_EQ(events_.size(), 4U);
  EXPECT_EQ(events_[0].text, "the connection was lost");
  EXPECT_EQ(events_[0].row, 10U);
  EXPECT_EQ(events_[1].kind, trial::EventKind::kReconnect);
  EXPECT_EQ(events_[1].row, 10U);
  // lost at 0.1 s; the first try behind 5 s is the 22nd: 50 + 100 + 200 + 19 * 250 ms
  EXPECT_EQ(events_[1].text, "the device is back after 5.100 s");
}

TEST_F(ReconnectingTest, ATryComesAtLeastEveryQuarterOfASecondAndNotMoreOften) {
  plug_.away_ns = 20'000 * kMs;
  ReconnectingSensor sensor(plug_.Opener(), {}, clock_);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  ASSERT_TRUE(Run(sensor, {.readings = 11}));
  ASSERT_GT(plug_.tries_ns.size(), 20U);
  EXPECT_EQ(plug_.tries_ns[2] - plug_.tries_ns[1], 100 * kMs) << "50 ms after the loss, then 100";
  for (std::size_t i = 5; i < plug_.tries_ns.size(); ++i) {
    EXPECT_EQ(plug_.tries_ns[i] - plug_.tries_ns[i - 1], 250 * kMs);
  }
}

TEST_F(ReconnectingTest, WhileItIsAwayItCanBeAskedAndBegunAgain) {
  plug_.away_ns = 5000 * kMs;
  ReconnectingSensor sensor(plug_.Opener(), {}, clock_);
  EXPECT_TRUE(sensor.Found().list().empty()) << "before the start";
  ASSERT_TRUE(sensor.Start(kNeverStop));
  EXPECT_EQ(sensor.Begin(), 0);
  Reading reading;
  Outcome outcome = Outcome::kReading;
  while (outcome == Outcome::kReading) outcome = sensor.Next(reading);
  ASSERT_EQ(outcome, Outcome::kAway);
  EXPECT_EQ(sensor.Begin(), clock_.Now());
  EXPECT_EQ(NumbersOf(sensor.Found(), FindingKind::kLinesNumbered), "last=99")
      << "what it found last";
}

TEST_F(ReconnectingTest, ARefusalIsForgottenOnceTheDeviceIsBack) {
  plug_.away_ns = 1000 * kMs;
  ReconnectingSensor sensor(plug_.Opener(), {}, clock_);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  Reading reading;
  Outcome outcome = Outcome::kReading;
  for (int call = 0; call < 1000 && outcome != Outcome::kBack; ++call) {
    outcome = sensor.Next(reading);
    if (clock_.Now() > 500 * kMs && outcome == Outcome::kNothing) {
      EXPECT_NE(sensor.last_refusal(), "");
    }
  }
  ASSERT_EQ(outcome, Outcome::kBack);
  EXPECT_EQ(sensor.last_refusal(), "");
}

TEST_F(ReconnectingTest, IsGivenUpWhenItStaysAway) {
  plug_.away_ns = 1'000'000 * kMs;
  ReconnectingSensor sensor(plug_.Opener(), 3000 * kMs, clock_);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  const auto summary = Run(sensor, {});
  ASSERT_TRUE(summary);
  EXPECT_TRUE(summary->connection_lost);
  EXPECT_EQ(summary->readings, 10U);
  EXPECT_THAT(sensor.last_refusal(), HasSubstr("./port: is not there"));
  Counts(path_);
  ASSERT_EQ(events_.size(), 2U);
  EXPECT_EQ(events_[0].text, "the connection was lost");
  EXPECT_EQ(events_[1].text, "waiting for the device ended");
}

// `sensor` is asked until it is one of the two
Outcome AskUntil(Sensor& sensor, Outcome one, Outcome other) {
  Reading reading;
  for (int call = 0; call < 10'000; ++call) {
    const Outcome outcome = sensor.Next(reading);
    if (outcome == one || outcome == other) return outcome;
  }
  ADD_FAILURE() << "neither came";
  return Outcome::kNothing;
}

TEST_F(ReconnectingTest, TheLongestAbsenceCountsFromTheLoss) {
  // tries 50, 150, 350, 600 ms after the loss, and so on to 2850 and 3100; looks every 100 ms
  // behind each of them
  for (const auto& [longest_ns, given_up_ns] :
       {std::pair(3050 * kMs, 3050 * kMs), {3050 * kMs + 1, 3100 * kMs}}) {
    Plug plug(clock_);
    plug.away_ns = 1'000'000 * kMs;
    ReconnectingSensor sensor(plug.Opener(), longest_ns, clock_);
    ASSERT_TRUE(sensor.Start(kNeverStop));
    ASSERT_EQ(AskUntil(sensor, Outcome::kAway, Outcome::kGone), Outcome::kAway);
    const MonotonicNs lost_ns = clock_.Now();
    ASSERT_EQ(AskUntil(sensor, Outcome::kBack, Outcome::kGone), Outcome::kGone);
    EXPECT_EQ(clock_.Now() - lost_ns, given_up_ns);
  }
}

using Change = std::function<void(CountingSensor&)>;

// whether what was `before` is taken where it comes back as `after`
bool IsTakenAgain(const Change& before, const Change& after) {
  ManualClock clock;
  Plug plug(clock);
  plug.change = before;
  ReconnectingSensor sensor(plug.Opener(), 2000 * kMs, clock);
  EXPECT_TRUE(sensor.Start(kNeverStop));
  plug.change = after;
  EXPECT_EQ(AskUntil(sensor, Outcome::kAway, Outcome::kGone), Outcome::kAway);
  return AskUntil(sensor, Outcome::kBack, Outcome::kGone) == Outcome::kBack;
}

TEST(Reconnecting, TheSameDeviceSendsTheSameChannels) {
  const Change as_it_is = [](CountingSensor&) {};
  EXPECT_TRUE(IsTakenAgain(as_it_is, as_it_is));
  for (const Change& other :
       {Change([](CountingSensor& sensor) { sensor.channel().name = "displacement_2"; }),
        Change([](CountingSensor& sensor) { sensor.channel().scale = 1.01e-7; }),
        Change([](CountingSensor& sensor) { sensor.channel().offset = 1e-9; }),
        Change(
            [](CountingSensor& sensor) { sensor.channel().encoding = trial::Encoding::kF64; })}) {
    EXPECT_FALSE(IsTakenAgain(as_it_is, other));
    EXPECT_TRUE(IsTakenAgain(other, other));
  }
}

TEST(Reconnecting, WhatIsNotKnownOfTheAveragingIsNoDifference) {
  const auto head = [](std::string name) {
    return Change(
        [name = std::move(name)](CountingSensor& sensor) { sensor.metadata().head = name; });
  };
  const auto sampling = [](std::optional<double> sampling_s) {
    return Change([=](CountingSensor& sensor) { sensor.metadata().sampling_s = sampling_s; });
  };
  const auto averages = [](std::optional<int> number) {
    return Change([=](CountingSensor& sensor) { sensor.metadata().averages = number; });
  };
  EXPECT_FALSE(IsTakenAgain(head("IL-030"), head("IL-065")));
  EXPECT_TRUE(IsTakenAgain(head("IL-030"), head("IL-030")));
  EXPECT_TRUE(IsTakenAgain(head("IL-030"), head("")));
  EXPECT_TRUE(IsTakenAgain(head(""), head("IL-065")));
  EXPECT_FALSE(IsTakenAgain(sampling(1e-3), sampling(2e-3)));
  EXPECT_TRUE(IsTakenAgain(sampling(1e-3), sampling({})));
  EXPECT_TRUE(IsTakenAgain(sampling({}), sampling(2e-3)));
  EXPECT_FALSE(IsTakenAgain(averages(16), averages(15)));
  EXPECT_TRUE(IsTakenAgain(averages(16), averages({})));
  EXPECT_TRUE(IsTakenAgain(averages({}), averages(15)));
}

TEST_F(ReconnectingTest, AnotherDeviceInItsPlaceIsNotTaken) {
  ReconnectingSensor sensor(plug_.Opener(), 2000 * kMs, clock_);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  plug_.timing = Timing::kArrival;
  const auto summary = Run(sensor, {});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 10U);
  EXPECT_THAT(sensor.last_refusal(), HasSubstr("what came back sends other channels"));
}

// the rows behind it have another gain than the trial's header states
TEST_F(ReconnectingTest, OtherAveragingEndsTheRecording) {
  ReconnectingSensor sensor(plug_.Opener(), 2000 * kMs, clock_);
  ASSERT_TRUE(sensor.Start(kNeverStop));
  plug_.averages = 64;
  const auto summary = Run(sensor, {.readings = 25});
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->readings, 10U);
  EXPECT_TRUE(summary->connection_lost);
  EXPECT_THAT(sensor.last_refusal(), HasSubstr("another averaging"));
  EXPECT_TRUE(sensor.Found().Has(FindingKind::kOtherSettings)) << "the trial says why";
}

TEST_F(ReconnectingTest, WhatIsNotThereAtTheBeginningIsAnError) {
  plug_.absent_until_ns = 1;
  ReconnectingSensor sensor(plug_.Opener(), {}, clock_);
  EXPECT_EQ(sensor.Start(kNeverStop).error().cause, Cause::kCannotAnswer);
}

}  // namespace
}  // namespace haptometer::acquire
