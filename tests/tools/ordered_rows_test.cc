#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "base/clock.h"
#include "tools/sweep/sweep.h"

namespace haptometer::tools {
namespace {

std::string Row(std::uint64_t row) { return std::to_string(row) + "\n"; }

std::string Expected(std::uint64_t first, std::uint64_t end) {
  std::string text;
  for (std::uint64_t row = first; row < end; ++row) text += Row(row);
  return text;
}

void Spend(int microseconds) {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
}

TEST(OrderedRows, ComeInOrderHoweverLongEachTakes) {
  for (const int threads : {1, 2, 7}) {
    for (const std::uint64_t first : {0U, 13U, 400U}) {
      const std::atomic<bool> stop = false;
      std::string text;
      std::uint64_t done = first;
      const auto made = MakeRowsInOrder(
          {.first = first,
           .count = 400,
           .threads = threads,
           .make =
               [](std::uint64_t row) {
                 Spend(row % 7 == 0 ? 300 : 0);
                 return Row(row);
               },
           .write = [&](std::string_view rows, std::uint64_t there) -> Result<void> {
             text += rows;
             EXPECT_GT(there, done);
             done = there;
             EXPECT_EQ(text, Expected(first, there));
             return {};
           },
           .stop = &stop});
      ASSERT_TRUE(made);
      EXPECT_EQ(*made, 400U);
      EXPECT_EQ(text, Expected(first, 400));
    }
  }
}

// the first row is as slow as fifty others: they are made meanwhile, not after it
TEST(OrderedRows, AreNotHeldUpByASlowOne) {
  const std::atomic<bool> stop = false;
  std::atomic<int> made_rows = 0;
  bool others_came = false;
  std::string text;
  const auto made = MakeRowsInOrder(
      {.count = 1000,
       .threads = 2,
       .make =
           [&](std::uint64_t row) {
             SystemClock clock;
             const MonotonicNs begun_ns = clock.Now();
             while (row == 0 && made_rows < 50 && clock.Now() - begun_ns < 20 * kNsPerS) Spend(100);
             if (row == 0) others_came = made_rows >= 50;
             ++made_rows;
             return Row(row);
           },
       .write = [&](std::string_view rows, std::uint64_t) -> Result<void> {
         text += rows;
         return {};
       },
       .stop = &stop});
  ASSERT_TRUE(made);
  EXPECT_TRUE(others_came);
  EXPECT_EQ(text, Expected(0, 1000));
}

TEST(OrderedRows, EndWholeWhereTheyAreStopped) {
  for (const int threads : {1, 3}) {
    std::atomic<bool> stop = false;
    std::string text;
    std::uint64_t there = 0;
    const auto made =
        MakeRowsInOrder({.count = 100'000,
                         .threads = threads,
                         .make =
                             [&](std::uint64_t row) {
                               Spend(10);
                               if (row == 150) stop = true;
                               return Row(row);
                             },
                         .write = [&](std::string_view rows, std::uint64_t done) -> Result<void> {
                           text += rows;
                           there = done;
                           return {};
                         },
                         .stop = &stop});
    ASSERT_TRUE(made);
    EXPECT_EQ(*made, there);
    EXPECT_LT(there, 20'000U);
    EXPECT_EQ(text, Expected(0, there));
  }
}

TEST(OrderedRows, StopWhereTheFileFails) {
  const std::atomic<bool> stop = false;
  int calls = 0;
  std::atomic<std::uint64_t> made_rows = 0;
  const auto made = MakeRowsInOrder({.count = 100'000,
                                     .threads = 2,
                                     .make =
                                         [&](std::uint64_t row) {
                                           ++made_rows;
                                           Spend(10);
                                           return Row(row);
                                         },
                                     .write = [&](std::string_view, std::uint64_t) -> Result<void> {
                                       ++calls;
                                       return Failed("t.csv", "is full");
                                     },
                                     .stop = &stop});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().what, "is full");
  EXPECT_EQ(calls, 1);
  EXPECT_LT(made_rows, 20'000U);
}

}  // namespace
}  // namespace haptometer::tools
