// The ring between the reading and the writing thread.
#include "acquire/recorder/row_ring.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace haptometer::acquire {
namespace {

using trial::RawValue;
using trial::SampleStatus;

constexpr std::size_t kBytesOfARow = 24 + 2 * 9;  // index and two times; bits and status twice

Reading TwoValues(std::int32_t number) {
  Reading reading;
  reading.index = std::int64_t{10} * number;
  reading.time_ns = 1000 + number;
  reading.reply_ns = 2000 + number;
  reading.samples = {{RawValue::Counts(number), SampleStatus::kOk},
                     {RawValue::F64(0.5 * number), SampleStatus::kOver}};
  return reading;
}

TEST(RowRing, HandsOverEveryRowInOrderBetweenTwoThreads) {
  RowRing ring(1000 * kBytesOfARow, 2);
  constexpr std::int32_t kRows = 50'000;
  std::thread writing([&] {
    std::int32_t expected = 0;
    while (ring.Wait()) {
      for (auto row = ring.Front(); row; row = ring.Front()) {
        ASSERT_EQ(row->samples.size(), 2U);
        ASSERT_EQ(row->index, 10 * expected);
        ASSERT_EQ(row->time_ns, expected);
        ASSERT_EQ(row->reply_ns, 1000 + expected);
        ASSERT_EQ(row->samples[0].raw.bits(), static_cast<std::uint64_t>(expected));
        ASSERT_EQ(row->samples[1].raw.Number(trial::Encoding::kF64), 0.5 * expected);
        ASSERT_EQ(row->samples[1].status, SampleStatus::kOver);
        ++expected;
        ring.Pop();
      }
    }
    EXPECT_EQ(expected, kRows);
  });
  for (std::int32_t i = 0; i < kRows; ++i) {
    const Reading reading = TwoValues(i);
    while (!ring.Push(reading, 1000)) std::this_thread::yield();
  }
  ring.Close();
  writing.join();
}

TEST(RowRing, RefusesWhenFullAndTakesAgainAfterwards) {
  RowRing ring(3 * kBytesOfARow, 2);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(ring.Push(TwoValues(i), 0));
  EXPECT_EQ(ring.room(), 0U);
  EXPECT_FALSE(ring.Push(TwoValues(3), 0));
  ring.Pop();
  EXPECT_EQ(ring.room(), 1U);
  EXPECT_TRUE(ring.Push(TwoValues(4), 0));
  EXPECT_EQ(ring.Front()->index, 10) << "what was refused is not in it, what came before is";
}

TEST(RowRing, AnEventStandsBetweenTheRowsItCameBetween) {
  RowRing ring(100 * kBytesOfARow, 2);
  ASSERT_TRUE(ring.Push(TwoValues(0), 0));
  ring.PushEvent({.text = "first"});
  ring.PushEvent({.text = "second"});
  ASSERT_TRUE(ring.Push(TwoValues(1), 0));
  ring.PushEvent({.text = "last"});
  ring.Close();

  std::string order;
  while (ring.Wait()) {
    if (const auto event = ring.TakeEvent()) {
      order += event->text + " ";
    } else if (const auto row = ring.Front()) {
      order += std::to_string(row->index) + " ";
      ring.Pop();
    }
  }
  EXPECT_EQ(order, "0 first second 10 last ");
}

TEST(RowRing, AnEventIsNeverOvertakenByItsRow) {
  // an event before every row, while the other thread takes: none may be missed or late
  RowRing ring(10'000 * kBytesOfARow, 2);
  constexpr std::int32_t kRows = 200'000;
  std::int32_t rows = 0;
  std::int32_t events = 0;
  std::thread writing([&] {
    while (ring.Wait()) {
      while (true) {
        const auto row = ring.Front();
        if (const auto event = ring.TakeEvent()) {
          ++events;
          continue;
        }
        if (!row) break;
        ASSERT_EQ(events, rows + 1) << "the event before this row";
        ++rows;
        ring.Pop();
      }
    }
  });
  for (std::int32_t i = 0; i < kRows; ++i) {
    while (ring.room() == 0) std::this_thread::yield();
    ring.PushEvent({});
    ASSERT_TRUE(ring.Push(TwoValues(i), 0));
  }
  ring.Close();
  writing.join();
  EXPECT_EQ(rows, kRows);
  EXPECT_EQ(events, kRows);
}

TEST(RowRing, HasRoomForOneRowAtLeast) {
  RowRing ring(0, 2);
  EXPECT_TRUE(ring.Push(TwoValues(0), 0));
  EXPECT_FALSE(ring.Push(TwoValues(1), 0));
}

TEST(RowRing, SaysThatTheWriterGaveUp) {
  RowRing ring(1, 1);
  EXPECT_FALSE(ring.given_up());
  ring.GiveUp();
  EXPECT_TRUE(ring.given_up());
}

TEST(RowRing, HoldsTheWholeRowsOfItsBytes) {
  EXPECT_EQ(RowRing(3 * kBytesOfARow, 2).capacity(), 3U);
  EXPECT_EQ(RowRing(3 * kBytesOfARow - 1, 2).capacity(), 2U);
  // two instants, an index, a number and a status: 33 bytes of one channel
  EXPECT_EQ(RowRing(33'000, 1).capacity(), 1000U);
}

TEST(RowRing, TakesNoRowWhileAThousandEventsWait) {
  RowRing ring(10 * kBytesOfARow, 2);
  for (int i = 0; i < 999; ++i) ring.PushEvent({});
  EXPECT_EQ(ring.room(), 10U);
  ring.PushEvent({});
  EXPECT_EQ(ring.room(), 0U);
  EXPECT_TRUE(ring.TakeEvent());
  EXPECT_EQ(ring.room(), 10U);
}

}  // namespace
}  // namespace haptometer::acquire
