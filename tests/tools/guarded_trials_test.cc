#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tools/daemon/sensor_loop.h"

namespace haptometer::tools {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// writes down what it is handed
class Recorded final : public acquire::RowSink {
 public:
  Result<void> Append(const trial::Row& row) override {
    return Note("row " + std::to_string(row.index));
  }
  Result<void> AddEvent(trial::Event event) override { return Note(event.text); }
  Result<void> FlushIfDue() override { return {}; }
  Result<void> Finish() override { return Note("end"); }
  std::vector<std::string> calls;

 private:
  Result<void> Note(std::string call) {
    calls.push_back(std::move(call));
    return {};
  }
};

struct Guard {
  explicit Guard(std::uint64_t reserve_bytes)
      : trials(sink,
               {.directory = ::testing::TempDir(),
                .reserve_bytes = reserve_bytes,
                .stop = stop,
                .pulse = pulse},
               clock) {}
  Recorded sink;
  std::atomic<bool> stop{false};
  Pulse pulse;
  ManualClock clock;
  GuardedTrials trials;
};

constexpr std::uint64_t kMoreThanThereIs = std::numeric_limits<std::uint64_t>::max();

TEST(GuardedTrials, HandOnWhatComesAsLongAsThereIsRoom) {
  Guard guard(1);
  ASSERT_TRUE(guard.trials.Append({.index = 7}));
  ASSERT_TRUE(guard.trials.AddEvent({.text = "event"}));
  ASSERT_TRUE(guard.trials.FlushIfDue());
  ASSERT_TRUE(guard.trials.Finish());
  EXPECT_THAT(guard.sink.calls, ElementsAre("row 7", "event", "end"));
  EXPECT_FALSE(guard.stop.load());
}

TEST(GuardedTrials, EndTheRecordingWithARemarkBeforeTheDiskIsFull) {
  Guard guard(kMoreThanThereIs);
  ASSERT_TRUE(guard.trials.FlushIfDue());
  EXPECT_TRUE(guard.stop.load());
  EXPECT_TRUE(guard.trials.disk_is_low());
  // what still waits is not thrown away
  ASSERT_TRUE(guard.trials.Append({.index = 8}));
  ASSERT_TRUE(guard.trials.Finish());
  EXPECT_THAT(guard.sink.calls, ElementsAre("row 8", HasSubstr("bytes are free"), "end"));
}

TEST(GuardedTrials, LookWhileRowsComeWithoutAPause) {
  Guard guard(kMoreThanThereIs);
  ASSERT_TRUE(guard.trials.Append({.index = 0}));
  EXPECT_TRUE(guard.stop.load());
}

TEST(GuardedTrials, AnUnknownDiskIsNoFullOne) {
  EXPECT_FALSE(FreeBytes("/no/such/directory"));
  EXPECT_TRUE(FreeBytes(::testing::TempDir()));
}

TEST(Pulse, IsMissedOnlyAfterABeat) {
  Pulse pulse;
  EXPECT_TRUE(pulse.IsAlive(1'000, 10)) << "nobody began";
  pulse.Beat(1'000);
  EXPECT_TRUE(pulse.IsAlive(1'010, 10));
  EXPECT_FALSE(pulse.IsAlive(1'011, 10));
  pulse.Rest();
  EXPECT_TRUE(pulse.IsAlive(1'000'000, 10));
}

TEST(GuardedTrials, BeatWithEveryLook) {
  Guard guard(1);
  guard.clock.Advance(1'000);
  guard.pulse.Beat(0);
  ASSERT_TRUE(guard.trials.FlushIfDue());
  EXPECT_TRUE(guard.pulse.IsAlive(guard.clock.Now(), 10));
}

}  // namespace
}  // namespace haptometer::tools
