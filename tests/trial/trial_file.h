#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "trial/byte_io.h"
#include "trial/trial_reader.h"
#include "trial/trial_writer.h"

namespace haptometer::trial {

/// A directory of its own for one test, removed with everything in it.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "haptometer-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~ScratchDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  [[nodiscard]] std::string File(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// A disk in memory: takes `room` bytes, at most `most_at_once` a write, and counts its syncs.
struct MemoryDisk {
  std::string bytes;
  std::size_t room = SIZE_MAX;
  std::size_t most_at_once = SIZE_MAX;
  int syncs = 0;
};

class MemorySink final : public ByteSink {
 public:
  explicit MemorySink(MemoryDisk* disk) : disk_(disk) {}
  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    const std::size_t left = disk_->room - disk_->bytes.size();
    if (left == 0) return Failed("", "No space left on device");
    const std::size_t count = std::min({bytes.size(), left, disk_->most_at_once});
    disk_->bytes.append(reinterpret_cast<const char*>(bytes.data()), count);
    return count;
  }
  Result<void> Sync() override {
    ++disk_->syncs;
    return {};
  }

 private:
  MemoryDisk* disk_;
};

/// One channel of counts, 1 um a step.
inline TrialHeader CountsHeader(Timing timing) {
  TrialHeader header;
  header.timing = timing;
  header.rate_hz = timing == Timing::kUniform ? 1000 : 0;
  ChannelFormat channel;
  channel.name = "displacement";
  channel.role = ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.encoding = Encoding::kI32;
  channel.scale = 1e-6;
  channel.offset = 0.25;
  header.channels.push_back(channel);
  return header;
}

/// A writer into `disk`; fails the test where it cannot be made.
inline TrialWriter WriterInto(MemoryDisk* disk, const TrialHeader& header, Clock& clock) {
  auto writer =
      TrialWriter::CreateIn(std::make_unique<MemorySink>(disk), "t.bin", header, {}, clock);
  EXPECT_TRUE(writer) << writer.error().Text();
  return std::move(*writer);
}

/// Appends one value of counts.
inline Result<void> AppendCounts(TrialWriter* writer, std::int32_t counts, Row row,
                                 SampleStatus status = SampleStatus::kOk) {
  const Sample sample{RawValue::Counts(counts), status};
  row.samples = {&sample, 1};
  return writer->Append(row);
}

/// A finished uniform trial with blocks of `rows_a_block` rows holding 0, 1, 2, ...
inline std::string CountingTrial(int rows, int rows_a_block) {
  MemoryDisk disk;
  ManualClock clock;
  auto writer = WriterInto(&disk, CountsHeader(Timing::kUniform), clock);
  for (int i = 0; i < rows; ++i) {
    EXPECT_TRUE(AppendCounts(&writer, i, {.index = i}));
    if (i % rows_a_block == rows_a_block - 1) {
      EXPECT_TRUE(writer.Flush());
    }
  }
  EXPECT_TRUE(writer.Finish());
  return disk.bytes;
}

inline Result<Recording> ReadBytes(const std::string& bytes) {
  return ReadRecordFrom(MakeMemorySource(bytes), "t.bin");
}

}  // namespace haptometer::trial
