#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "tests/acquire/counting_sensor.h"
#include "trial/trial_reader.h"

namespace haptometer::acquire {

/// A recording into a file of its own directory, on clocks that stand still.
class RecorderTest : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(directory_); }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  trial::TrialWriter Writer(const Sensor& sensor) {
    auto writer = trial::TrialWriter::Create(path_, sensor.header(), {}, writer_clock_);
    EXPECT_TRUE(writer);
    return std::move(*writer);
  }
  Result<RecordingSummary> Run(Sensor& sensor, const RecordingLimits& limits,
                               const std::atomic<bool>& stop = kNeverStop) {
    trial::TrialWriter writer = Writer(sensor);
    SingleTrial sink(writer);
    return Record(sensor, sink, clock_, stop, limits);
  }
  // the counts of the trial, which was closed properly
  std::vector<std::int32_t> Counts(const std::string& path, bool closed = true) {
    auto reader = trial::TrialReader::Open(path);
    EXPECT_TRUE(reader);
    std::vector<std::int32_t> counts;
    while (true) {
      const auto chunk = reader->Next();
      EXPECT_TRUE(chunk);
      if (*chunk == nullptr) break;
      for (std::size_t row = 0; row < (*chunk)->rows(); ++row) {
        counts.push_back(static_cast<std::int32_t>((*chunk)->At(row, 0).raw.bits()));
      }
    }
    EXPECT_EQ(reader->report().closed, closed);
    events_ = reader->report().events;
    return counts;
  }
  static std::vector<std::int32_t> CountTo(std::int32_t n) {
    std::vector<std::int32_t> counts(static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) counts[static_cast<std::size_t>(i)] = i;
    return counts;
  }

  const std::filesystem::path directory_ =
      std::filesystem::path(::testing::TempDir()) / ("recorder_test_" + std::to_string(getpid()));
  const std::string path_ = directory_ / "trial.bin";
  ManualClock clock_;         // the reading thread's
  ManualClock writer_clock_;  // the writing thread's
  std::vector<trial::Event> events_;
};

}  // namespace haptometer::acquire
