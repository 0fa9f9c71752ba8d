#include "acquire/sensor/polled_line.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/acquire/scripted_transport.h"
#include "tests/findings.h"

namespace haptometer::acquire {
namespace {

using trial::SampleStatus;

constexpr MonotonicNs kMs = 1'000'000;

// one value polled every `period`; which of the readings are marked
std::vector<bool> Marked(MonotonicNs refresh_ns, MonotonicNs period_ns,
                         const std::vector<std::int32_t>& counts) {
  RepeatMarker marker(refresh_ns);
  std::vector<bool> marked;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    Reading reading;
    reading.time_ns = static_cast<MonotonicNs>(i) * period_ns;
    reading.samples = {{trial::RawValue::Counts(counts[i]), SampleStatus::kOk}};
    marker.Mark(reading);
    marked.push_back(reading.samples[0].status == SampleStatus::kRepeated);
  }
  return marked;
}

using Marks = std::vector<bool>;

TEST(RepeatMarker, AtRestSlowerThanTheRefreshNothingIsRepeated) {
  EXPECT_EQ(Marked(7 * kMs, 8 * kMs, {5, 5, 5, 5}), (Marks{false, false, false, false}));
  EXPECT_EQ(Marked(7 * kMs, 7 * kMs, {5, 5, 5}), (Marks{false, false, false}));
}

TEST(RepeatMarker, FasterThanTheRefreshEqualReadingsAreMarkedUntilItMustHavePassed) {
  EXPECT_EQ(Marked(20 * kMs, 8 * kMs, {5, 5, 5, 5, 5, 5, 5}),
            (Marks{false, true, true, false, true, true, false}));
}

TEST(RepeatMarker, ADifferentReadingIsNewAtAnyTime) {
  EXPECT_EQ(Marked(20 * kMs, 8 * kMs, {5, 6, 6, 5, 5}), (Marks{false, false, true, false, true}));
}

TEST(RepeatMarker, WhatIsNoMeasurementKeepsItsStatus) {
  RepeatMarker marker(20 * kMs);
  for (int i = 0; i < 2; ++i) {
    Reading reading;
    reading.time_ns = 8 * kMs * i;
    reading.samples = {{trial::RawValue::Counts(-99'998), SampleStatus::kInvalid},
                       {trial::RawValue::Counts(3), SampleStatus::kOk}};
    marker.Mark(reading);
    EXPECT_EQ(reading.samples[0].status, SampleStatus::kInvalid);
    EXPECT_EQ(reading.samples[1].status, i == 0 ? SampleStatus::kOk : SampleStatus::kRepeated);
  }
}

TEST(ResponseDeadline, IsTheMakersSecondUntilTheUnitIsKnown) {
  ResponseDeadline deadline;
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  for (int i = 0; i < 63; ++i) deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 50 * kMs);
  deadline.Note(30 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 120 * kMs);
  deadline.Note(900 * kMs);
  EXPECT_EQ(deadline.WaitNs(), kNsPerS);
  for (int i = 0; i < 64; ++i) deadline.Note(8 * kMs);
  EXPECT_EQ(deadline.WaitNs(), 50 * kMs);
}

TEST(ResponseDeadline, AReplyIsTooSoonBelowNineTenthsOfTheFastest) {
  for (const auto& [wire_ns, earliest_ns] :
       {std::pair(5 * kMs, 7'200'000), {7 * kMs, 7'200'000}, {MonotonicNs{7'250'000}, 7'250'000}}) {
    ResponseDeadline deadline(wire_ns);
    for (int i = 0; i < 63; ++i) deadline.Note(10 * kMs);
    EXPECT_EQ(deadline.EarliestNs(), wire_ns) << "63 exchanges are too few";
    deadline.Note(8 * kMs);
    EXPECT_EQ(deadline.EarliestNs(), earliest_ns);
  }
}

TEST(ResponseDeadline, AUsualExchangeIsOneAndAHalfMedians) {
  ResponseDeadline deadline(3 * kMs);
  for (int i = 0; i < 31; ++i) deadline.Note(10 * kMs);
  EXPECT_EQ(deadline.UsualNs(), 3 * kMs) << "31 exchanges are too few";
  for (int i = 0; i < 33; ++i) deadline.Note(20 * kMs);
  EXPECT_EQ(deadline.UsualNs(), 30 * kMs);
  // of 64 the median is 10 ms again
  for (int i = 0; i < 40; ++i) deadline.Note(10 * kMs);
  EXPECT_EQ(deadline.UsualNs(), 15 * kMs);
  // never before a reply can come at all
  ResponseDeadline slow(16 * kMs);
  for (int i = 0; i < 64; ++i) slow.Note(10 * kMs);
  EXPECT_EQ(slow.UsualNs(), 16 * kMs);
}

TEST(DoubtfulReplies, StateTheRateOfTheWire) {
  EXPECT_TRUE(DoubtfulReplies({.taken = 10}, 20 * kMs).list().empty());
  const Findings found = DoubtfulReplies({.taken = 10, .surplus = 3, .too_soon = 2}, 20 * kMs);
  EXPECT_EQ(tests::NumbersOf(found, FindingKind::kSurplusReplies), "replies=3");
  EXPECT_EQ(tests::NumbersOf(found, FindingKind::kRepliesTooSoon),
            "too_soon=2 replies=10 wire_s=0.02 rate_hz=50");
}

// a device whose only reading is P
class OneLetter final : public LineDialect {
 public:
  std::string_view PollRequest() const override { return "P\r"; }
  std::string_view StepRequest() const override { return "S\r"; }
  bool AnswersStep(std::string_view line) const override { return line == "S"; }
  LineMeaning Read(std::string_view line, std::span<trial::Sample> samples) const override {
    if (line != "P") return LineMeaning::kDamaged;
    samples[0] = {trial::RawValue::Counts(1), SampleStatus::kOk};
    return LineMeaning::kReading;
  }
};

// when 100 rows were requested, on a grid of 50 Hz, each answered after `exchange_ns`
std::vector<MonotonicNs> RequestTimes(MonotonicNs exchange_ns) {
  ManualClock clock;
  clock.Advance(123'456'789);
  const OneLetter dialect;
  PolledLine line(std::make_unique<tests::ScriptedTransport>(
                      clock, [=](tests::ScriptedTransport& to,
                                 const std::string& request) { to.Send(request, exchange_ns); }),
                  clock, Delimiter::kCr, 8);
  const MonotonicNs begin_ns = line.Begin(dialect, {.rate_hz = 50});
  std::vector<MonotonicNs> times;
  Reading reading;
  for (int call = 0; call < 1000 && times.size() < 100; ++call) {
    if (line.Next(reading) == Outcome::kReading) times.push_back(reading.time_ns - begin_ns);
  }
  return times;
}

TEST(PolledLine, PollsLieOnTheGridAndNoSlotIsUsedTwice) {
  // a reply at once, within a slot, at the next slot's instant, and just behind it
  for (const auto& [exchange_ns, slots] : {std::pair(MonotonicNs{0}, 1),
                                           {5 * kMs, 1},
                                           {20 * kMs, 1},
                                           {20 * kMs + 1, 2},
                                           {40 * kMs, 2}}) {
    const std::vector<MonotonicNs> times = RequestTimes(exchange_ns);
    ASSERT_EQ(times.size(), 100U);
    for (std::size_t row = 0; row < times.size(); ++row) {
      EXPECT_EQ(times[row], 20 * kMs * slots * static_cast<MonotonicNs>(row)) << exchange_ns;
    }
  }
}

}  // namespace
}  // namespace haptometer::acquire
