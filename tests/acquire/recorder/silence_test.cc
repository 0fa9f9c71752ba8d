// A source that gives no reading to the end of a recording, with the connection still open.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/acquire/recorder_fixture.h"
#include "tests/findings.h"

namespace haptometer::acquire {
namespace {

using tests::NumbersOf;
using trial::SampleStatus;
using trial::Timing;

// A row every period for some time, each when the clock shows its time, then rows of another
// status, or none.
class SilentSensor final : public Sensor {
 public:
  struct Setup {
    Timing timing = Timing::kArrival;
    MonotonicNs period_ns = 10 * kMs;
    MonotonicNs first_ns = 0;           // the first row's time
    MonotonicNs talks_ns = 2500 * kMs;  // readings come before this time
    std::optional<SampleStatus> then{};
    MonotonicNs back_ns = 3600 * kNsPerS;  // and from this time on
    MonotonicNs lost_reply_ns = 0;
  };

  SilentSensor(Clock& clock, Setup setup)
      : clock_(clock), setup_(setup), header_(OneChannel(setup.timing)) {}

  Result<void> Start(const std::atomic<bool>& /*stop*/) override { return {}; }
  const trial::TrialHeader& header() const override { return header_; }
  Findings Found() const override { return {}; }
  MonotonicNs Begin() override { return origin_ns_ = clock_.Now(); }
  MonotonicNs LostReplyNs() const override { return setup_.lost_reply_ns; }
  std::uint64_t discarded_bytes() const override { return 0; }
  Outcome Next(Reading& reading) override {
    const MonotonicNs time_ns = setup_.first_ns + rows_ * setup_.period_ns;
    const bool talks = time_ns < setup_.talks_ns || time_ns >= setup_.back_ns;
    clock_.SleepUntil(origin_ns_ + time_ns);
    ++rows_;
    if (!talks && !setup_.then) return Outcome::kNothing;
    reading.time_ns = origin_ns_ + time_ns;
    reading.reply_ns = reading.time_ns;
    reading.index = rows_ - 1;
    reading.samples = {{trial::RawValue::Counts(1), talks ? SampleStatus::kOk : *setup_.then}};
    if (stop_at_ns && time_ns >= *stop_at_ns) stop->store(true);
    return Outcome::kReading;
  }

  std::optional<MonotonicNs> stop_at_ns{};
  std::atomic<bool>* stop = nullptr;

 private:
  Clock& clock_;
  Setup setup_;
  trial::TrialHeader header_;
  MonotonicNs origin_ns_ = 0;
  std::int64_t rows_ = 0;
};

class Silence : public RecorderTest {
 protected:
  RecordingSummary Recorded(const SilentSensor::Setup& setup, RecordingLimits limits = {}) {
    std::filesystem::remove(path_);
    clock_.Advance(100 * kMs);
    SilentSensor sensor(clock_, setup);
    if (limits.until_ns) *limits.until_ns += clock_.Now();
    trial::TrialWriter writer = Writer(sensor);
    SingleTrial sink(writer);
    auto summary = Record(sensor, sink, clock_, kNeverStop, limits,
                          {.say = [](const Finding&) { return "silent"; }});
    EXPECT_TRUE(summary);
    Counts(path_);
    const auto has = [&](std::string_view text) {
      return std::ranges::any_of(events_, [&](const auto& at) { return at.text == text; });
    };
    EXPECT_EQ(has("doubt: silent"), summary->fell_silent) << "the trial holds it";
    EXPECT_EQ(has(trial::kInterruptedText), summary->interrupted);
    EXPECT_EQ(summary->fell_silent, summary->found.Has(FindingKind::kFellSilent));
    EXPECT_EQ(summary->fell_silent, summary->interrupted);
    return *summary;
  }
  bool FallsSilent(const SilentSensor::Setup& setup, MonotonicNs duration_ns = 8 * kNsPerS) {
    return Recorded(setup, {.duration_ns = duration_ns}).fell_silent;
  }
};

TEST_F(Silence, ToTheEndIsADoubtWithItsTimes) {
  for (const auto then :
       {std::optional<SampleStatus>(), {SampleStatus::kLate}, {SampleStatus::kBadFrame}}) {
    for (const RecordingLimits& limits :
         {RecordingLimits{.duration_ns = 8 * kNsPerS}, RecordingLimits{.until_ns = 8 * kNsPerS}}) {
      const auto summary = Recorded({.then = then}, limits);
      EXPECT_TRUE(summary.source_ended);
      ASSERT_TRUE(summary.fell_silent);
      EXPECT_EQ(NumbersOf(summary.found, FindingKind::kFellSilent),
                "last_reading_s=2.49 length_s=8");
    }
  }
}

// an answer without a value is an answer
TEST_F(Silence, IsNoneOfASourceThatAnswers) {
  for (const SampleStatus then : {SampleStatus::kOver, SampleStatus::kInvalid,
                                  SampleStatus::kDeviceError, SampleStatus::kRepeated}) {
    EXPECT_FALSE(FallsSilent({.then = then}));
  }
}

// 1.5 periods of 10 ms and 0.25 s, where that is more than 1 % of the length
TEST_F(Silence, IsLongerThanThePaceOfTheSource) {
  EXPECT_FALSE(FallsSilent({.talks_ns = 7750 * kMs}));
  EXPECT_TRUE(FallsSilent({.talks_ns = 7730 * kMs}));
  EXPECT_FALSE(FallsSilent({.talks_ns = 99'100 * kMs}, 100 * kNsPerS));
  EXPECT_TRUE(FallsSilent({.talks_ns = 98'900 * kMs}, 100 * kNsPerS));
  // a reading in 2 s, the first after 1.9 s
  EXPECT_FALSE(FallsSilent(
      {.period_ns = 2000 * kMs, .first_ns = 1900 * kMs, .talks_ns = 9 * kNsPerS}, 5 * kNsPerS));
  EXPECT_FALSE(FallsSilent(
      {.period_ns = 2000 * kMs, .first_ns = 1900 * kMs, .talks_ns = 9 * kNsPerS}, 3 * kNsPerS));
  EXPECT_TRUE(FallsSilent(
      {.period_ns = 2000 * kMs, .first_ns = 1900 * kMs, .talks_ns = 6 * kNsPerS}, 20 * kNsPerS));
}

// the second that a lost reply costs
TEST_F(Silence, IsLongerThanALostReplyExplains) {
  const auto falls_silent = [&](MonotonicNs talks_ns) {
    return FallsSilent({.timing = Timing::kPolled,
                        .talks_ns = talks_ns,
                        .then = SampleStatus::kLate,
                        .lost_reply_ns = kNsPerS});
  };
  EXPECT_FALSE(falls_silent(6800 * kMs));
  EXPECT_TRUE(falls_silent(6700 * kMs));
}

TEST_F(Silence, ThatTheFirstReadingBehindTheEndBreaksIsOne) {
  EXPECT_TRUE(FallsSilent({.back_ns = 8 * kNsPerS}));
  EXPECT_FALSE(FallsSilent({.back_ns = 7 * kNsPerS})) << "a gap";
}

TEST_F(Silence, OfAShotCountsFromItsTrigger) {
  const auto summary =
      Recorded({.talks_ns = 2500 * kMs},
               {.duration_ns = 4 * kNsPerS, .trigger = TriggerSetup{.kind = TriggerKind::kAbove}});
  ASSERT_TRUE(summary.fell_silent);
  // the trigger is the first row
  EXPECT_EQ(NumbersOf(summary.found, FindingKind::kFellSilent), "last_reading_s=2.49 length_s=4");
}

// Ctrl-C: no end was asked for; silence of 3 s and more is a note
TEST_F(Silence, BeforeAStopIsANote) {
  for (const MonotonicNs stop_ns : {5000 * kMs, 6000 * kMs}) {
    std::filesystem::remove(path_);
    std::atomic<bool> stop{false};
    SilentSensor sensor(clock_, {.then = SampleStatus::kLate});
    sensor.stop_at_ns = stop_ns;
    sensor.stop = &stop;
    const auto summary = Run(sensor, {}, stop);
    ASSERT_TRUE(summary);
    EXPECT_FALSE(summary->interrupted);
    EXPECT_FALSE(summary->fell_silent);
    ASSERT_EQ(summary->found.list().size(), stop_ns == 6000 * kMs ? 1U : 0U);
    if (stop_ns == 6000 * kMs) {
      EXPECT_EQ(summary->found.list()[0].severity, Severity::kNote);
    }
  }
}

}  // namespace
}  // namespace haptometer::acquire
