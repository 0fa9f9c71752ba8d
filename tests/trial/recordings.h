#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/trial_format.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A polled trial with bad values, events and a lost block
inline Recording Polled() {
  MemoryDisk disk;
  ManualClock clock;
  TrialHeader header = CountsHeader(Timing::kPolled);
  header.metadata.labels = {{"subject", "\xc3\xa4"}};
  header.metadata.notes = {"a", "b"};
  header.channels[0].range_max = 0.3;
  auto writer = WriterInto(&disk, header, clock);
  std::size_t second_block = 0;
  for (int i = 0; i < 30; ++i) {
    const std::int64_t t_ns = i * std::int64_t{20'000'000};
    const auto status = i % 7 == 3 ? SampleStatus::kLate : SampleStatus::kOk;
    EXPECT_TRUE(
        AppendCounts(&writer, i * i, {.time_ns = t_ns, .reply_ns = t_ns + 9'000'123}, status));
    if (i % 10 == 9) {
      EXPECT_TRUE(writer.Flush());
    }
    if (i == 9) second_block = disk.bytes.size();
  }
  EXPECT_TRUE(writer.AddEvent({.kind = EventKind::kReconnect, .time_ns = 77, .text = "back"}));
  EXPECT_TRUE(writer.Finish());
  disk.bytes[second_block + kBlockHeadBytes] ^= 1;
  auto read = ReadBytes(disk.bytes);
  EXPECT_TRUE(read);
  return std::move(*read);
}

/// Whether both hold the same bytes, NaN too.
template <typename T>
bool SameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// Bits of times and values, statuses, and all that the header says.
inline void ExpectSame(const Record& a, const Record& b) {
  EXPECT_EQ(a.rows, b.rows);
  EXPECT_TRUE(SameBits(a.raw_times_s, b.raw_times_s));
  ASSERT_EQ(a.stretches.size(), b.stretches.size());
  for (std::size_t i = 0; i < a.stretches.size(); ++i) {
    EXPECT_EQ(a.stretches[i].first_row, b.stretches[i].first_row);
    EXPECT_EQ(a.stretches[i].rows, b.stretches[i].rows);
    EXPECT_EQ(a.stretches[i].start_s, b.stretches[i].start_s);
    EXPECT_EQ(a.stretches[i].rate_hz, b.stretches[i].rate_hz);
    EXPECT_EQ(a.stretches[i].time_uncertainty_s, b.stretches[i].time_uncertainty_s);
  }
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    EXPECT_TRUE(SameBits(a.channels[c].values, b.channels[c].values)) << c;
    EXPECT_EQ(a.channels[c].statuses, b.channels[c].statuses);
  }
  // names, units, ranges, metadata
  EXPECT_EQ(HeaderToJson(HeaderOf(a)), HeaderToJson(HeaderOf(b)));
}

}  // namespace haptometer::trial
