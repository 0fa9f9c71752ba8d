#include "acquire/sensor/polled_line.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

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

}  // namespace
}  // namespace haptometer::acquire
