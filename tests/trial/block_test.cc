// Blocks of a trial.bin: their bytes against docs/reference/formats.md, what is sound of a file,
// and how the scanner tells a cut from damage.
#include "trial/block.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "tests/trial/trial_file.h"
#include "trial/byte_io.h"
#include "trial/findings.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

constexpr std::size_t kPayloadBytes = 10;  // less than a head
constexpr std::size_t kWholeBytes = kBlockHeadBytes + kPayloadBytes;

std::string BlockOf(const BlockHead& head) {
  MemoryDisk disk;
  MemorySink sink(&disk);
  EXPECT_TRUE(WriteBlock(&sink, head, BytesOfText(std::string(kPayloadBytes, 'p'))));
  return disk.bytes;
}

// two rows a block
BlockHead RowsHead(std::uint32_t sequence) {
  return {.kind = BlockKind::kRows, .sequence = sequence, .rows = 2, .first_row = 2UL * sequence};
}

std::string BlocksOfRows(std::uint32_t count) {
  std::string bytes;
  for (std::uint32_t k = 0; k < count; ++k) bytes += BlockOf(RowsHead(k));
  return bytes;
}

std::string Flipped(std::string bytes, std::size_t at) {
  bytes.at(at) = static_cast<char>(bytes[at] ^ 1);
  return bytes;
}

struct Scan {
  std::vector<std::uint32_t> found{};  // sequence numbers
  std::vector<Loss> losses{};
};

Scan ScanOf(const ByteSource& source) {
  BlockScanner scanner(&source, 0);
  Scan scan;
  std::vector<std::byte> payload;
  for (;;) {
    const auto block = scanner.Next(&payload);
    EXPECT_TRUE(block);
    if (!block || !*block) break;
    EXPECT_EQ(payload.size(), (*block)->head.payload_bytes);
    scan.found.push_back((*block)->head.sequence);
  }
  scan.losses = scanner.losses();
  return scan;
}

Scan ScanOf(const std::string& bytes) { return ScanOf(*MakeMemorySource(bytes)); }

// a file that has lost its last bytes since it was opened
class ShrunkSource final : public ByteSource {
 public:
  ShrunkSource(const std::string& bytes, std::size_t lost)
      : size_(bytes.size()), left_(MakeMemorySource(bytes.substr(0, bytes.size() - lost))) {}
  std::uint64_t size() const override { return size_; }
  Result<std::size_t> ReadAt(std::uint64_t offset, std::span<std::byte> into) const override {
    return left_->ReadAt(offset, into);
  }

 private:
  std::uint64_t size_;
  std::unique_ptr<ByteSource> left_;
};

// the CRC of the head is zlib's
TEST(BlockHead, HasTheBytesOfTheDocumentation) {
  const BlockHead head{.kind = BlockKind::kEvent,
                       .sequence = 0x04030201,
                       .rows = 0x08070605,
                       .payload_bytes = 0x00030201,
                       .first_row = 0x1817161514131211,
                       .first_index = 0x2827262524232221,
                       .payload_crc = 0x34333231};
  std::string expected =
      "\x93"
      "block\r\n";
  expected += std::string("\x03\0\0\0", 4) + "\x01\x02\x03\x04" + "\x05\x06\x07\x08";
  expected += std::string("\x01\x02\x03\0", 4) + "\x11\x12\x13\x14\x15\x16\x17\x18";
  expected +=
      "\x21\x22\x23\x24\x25\x26\x27\x28"
      "\x31\x32\x33\x34";
  const auto crc = static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(expected.data()), expected.size()));
  for (int k = 0; k < 4; ++k) expected += static_cast<char>(crc >> (8 * k));
  const auto bytes = EncodeBlockHead(head);
  ASSERT_EQ(expected.size(), bytes.size());
  EXPECT_EQ(std::memcmp(bytes.data(), expected.data(), bytes.size()), 0);
  const auto back = DecodeBlockHead(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(EncodeBlockHead(*back), bytes);
  EXPECT_EQ(back->first_index, head.first_index);
}

TEST(BlockHead, StatesAtMostSixteenMebibytesOfPayload) {
  const auto is_read = [](std::uint32_t payload_bytes) {
    return DecodeBlockHead(EncodeBlockHead({.payload_bytes = payload_bytes})).has_value();
  };
  EXPECT_TRUE(is_read(0));
  EXPECT_TRUE(is_read(1U << 24));
  EXPECT_FALSE(is_read((1U << 24) + 1));
}

TEST(BlockHead, ThatIsCutOrChangedIsNone) {
  const auto bytes = EncodeBlockHead({.rows = 3});
  EXPECT_TRUE(DecodeBlockHead(bytes));
  EXPECT_FALSE(DecodeBlockHead(std::span(bytes).first(kBlockHeadBytes - 1)));
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    auto changed = bytes;
    changed[k] ^= std::byte{0x10};
    EXPECT_FALSE(DecodeBlockHead(changed)) << k;
  }
}

TEST(RowLayout, IsTimesThenValuesThenStatuses) {
  TrialHeader header;
  header.channels = {
      {.encoding = Encoding::kI32}, {.encoding = Encoding::kF64}, {.encoding = Encoding::kF32}};
  std::size_t begin = 0;
  for (const Timing timing : {Timing::kUniform, Timing::kArrival, Timing::kPolled}) {
    header.timing = timing;
    const RowLayout layout = LayoutOf(header);
    EXPECT_EQ(layout.time_bytes, begin);
    EXPECT_EQ(layout.value_offsets, (std::vector<std::size_t>{begin, begin + 4, begin + 12}));
    EXPECT_EQ(layout.value_bytes, (std::vector<std::size_t>{4, 8, 4}));
    EXPECT_EQ(layout.status_offset, begin + 16);
    EXPECT_EQ(layout.row_bytes, begin + 19);
    begin += 8;
  }
}

// --- SoundUntil --------------------------------------------------------------------------------

constexpr std::size_t kBefore = 16;  // bytes ahead of the first block

std::uint64_t SoundEnd(const std::string& blocks, int threads) {
  const auto source = MakeMemorySource(std::string(kBefore, 's') + blocks);
  const auto end = SoundUntil(*source, kBefore, threads);
  EXPECT_TRUE(end);
  return end.value_or(0);
}

// 70 blocks are three jobs of 32, the last of them not full
TEST(SoundUntil, IsTheEndOfTheFileWhereAllIsSound) {
  for (const int threads : {1, 3}) {
    for (const std::uint32_t count : {0U, 1U, 31U, 32U, 33U, 70U}) {
      EXPECT_EQ(SoundEnd(BlocksOfRows(count), threads), kBefore + count * kWholeBytes) << count;
    }
  }
}

TEST(SoundUntil, IsWhereTheFirstDamagedBlockBegins) {
  const std::string blocks = BlocksOfRows(70);
  for (const int threads : {1, 3}) {
    for (const std::size_t damaged : {0U, 1U, 31U, 32U, 63U, 69U}) {
      const std::size_t begin = damaged * kWholeBytes;
      const std::string of_payload = Flipped(blocks, begin + kWholeBytes - 1);
      EXPECT_EQ(SoundEnd(of_payload, threads), kBefore + begin) << damaged;
      EXPECT_EQ(SoundEnd(Flipped(blocks, begin + 20), threads), kBefore + begin) << damaged;
      // a later one as well does not matter
      EXPECT_EQ(SoundEnd(Flipped(of_payload, blocks.size() - 2), threads), kBefore + begin);
    }
  }
}

TEST(SoundUntil, IsWhereABlockThatIsCutBegins) {
  const std::string blocks = BlocksOfRows(3);
  for (std::size_t cut = 1; cut <= kWholeBytes; ++cut) {
    EXPECT_EQ(SoundEnd(blocks.substr(0, blocks.size() - cut), 1), kBefore + 2 * kWholeBytes) << cut;
  }
}

TEST(BlockScanner, ReadsNoPayloadThatEndsWhereItTrusts) {
  for (const std::uint64_t end : {kWholeBytes - 1, kWholeBytes, 2 * kWholeBytes - 1}) {
    const auto source = MakeMemorySource(BlocksOfRows(2));
    BlockScanner scanner(source.get(), 0);
    scanner.Trust(end);
    std::vector<std::byte> payload;
    ASSERT_TRUE(scanner.Next(&payload).value());
    EXPECT_EQ(payload.empty(), end >= kWholeBytes) << end;
    ASSERT_TRUE(scanner.Next(&payload).value());
    EXPECT_EQ(payload.size(), kPayloadBytes) << end;
  }
}

// --- losses ------------------------------------------------------------------------------------

void ExpectLoss(const Scan& scan, FindingKind kind, std::uint64_t offset, std::uint64_t bytes) {
  ASSERT_EQ(scan.losses.size(), 1U);
  EXPECT_EQ(scan.losses[0].kind, kind);
  EXPECT_EQ(scan.losses[0].offset, offset);
  EXPECT_EQ(scan.losses[0].bytes, bytes);
}

TEST(BlockScanner, TellsACutPayloadFromADamagedOne) {
  const std::string blocks = BlocksOfRows(3);
  constexpr std::size_t kLast = 2 * kWholeBytes;
  for (const std::size_t missing : {std::size_t{1}, kPayloadBytes}) {
    const Scan cut = ScanOf(blocks.substr(0, blocks.size() - missing));
    EXPECT_EQ(cut.found, (std::vector<std::uint32_t>{0, 1}));
    ExpectLoss(cut, FindingKind::kEndsInBlock, kLast, kWholeBytes - missing);
    EXPECT_EQ(cut.losses.at(0).block, 2U);
    EXPECT_EQ(cut.losses.at(0).first_row, 4U);
    EXPECT_EQ(cut.losses.at(0).rows, 2U);
  }
  const Scan damaged = ScanOf(Flipped(blocks, blocks.size() - 1));
  EXPECT_EQ(damaged.found, (std::vector<std::uint32_t>{0, 1}));
  ExpectLoss(damaged, FindingKind::kBlocksDamaged, kLast, kWholeBytes);
  EXPECT_EQ(damaged.losses.at(0).rows, 2U);
}

// the bytes of the block before are no part of it
TEST(BlockScanner, TakesNoPayloadThatIsShorterThanItWas) {
  const std::string blocks = BlocksOfRows(2);
  for (const std::size_t lost : {std::size_t{1}, kPayloadBytes}) {
    const ShrunkSource source(blocks, lost);
    const Scan scan = ScanOf(source);
    EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0}));
    ExpectLoss(scan, FindingKind::kBlocksDamaged, kWholeBytes, kWholeBytes);
    EXPECT_EQ(scan.losses.at(0).block, 1U);
    EXPECT_EQ(scan.losses.at(0).rows, 2U);
    EXPECT_EQ(SoundUntil(source, 0, 1).value(), kWholeBytes);
  }
}

// what is shorter than a head is the beginning of one
TEST(BlockScanner, TellsACutHeadFromStrangeBytesByItsLength) {
  const std::string blocks = BlocksOfRows(3);
  const Scan cut = ScanOf(blocks + std::string(kBlockHeadBytes - 1, 'x'));
  ExpectLoss(cut, FindingKind::kEndsInBlock, blocks.size(), kBlockHeadBytes - 1);
  EXPECT_EQ(cut.losses.at(0).block, 3U);
  EXPECT_EQ(cut.losses.at(0).first_row, 6U);
  EXPECT_EQ(cut.losses.at(0).rows, std::nullopt);
  const Scan strange = ScanOf(blocks + std::string(kBlockHeadBytes, 'x'));
  ExpectLoss(strange, FindingKind::kDamagedFromBlock, blocks.size(), kBlockHeadBytes);
}

TEST(BlockScanner, FindsTheBlockBehindOneThatLacksItsEnd) {
  const std::string blocks = BlocksOfRows(3);
  const Scan scan = ScanOf(blocks.substr(0, 2 * kWholeBytes - 4) + blocks.substr(2 * kWholeBytes));
  EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0, 2}));
  ExpectLoss(scan, FindingKind::kBlocksDamaged, kWholeBytes, kWholeBytes - 4);
  EXPECT_EQ(scan.losses.at(0).rows, 2U);
}

TEST(BlockScanner, PassesOverAMagicWithoutASoundHead) {
  std::string strange;
  for (int k = 0; k < 9; ++k)
    strange +=
        "\x93"
        "block\r\n";
  const Scan scan = ScanOf(BlockOf(RowsHead(0)) + strange + BlockOf(RowsHead(1)));
  EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0, 1}));
  ExpectLoss(scan, FindingKind::kBlocksDamaged, kWholeBytes, strange.size());
  EXPECT_EQ(scan.losses.at(0).rows, 0U);
}

TEST(BlockScanner, CountsMissingBlocksAndTheirRows) {
  for (const std::uint32_t next : {2U, 3U, 4U}) {
    const Scan scan = ScanOf(BlockOf(RowsHead(0)) + BlockOf(RowsHead(next)));
    EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0, next}));
    ExpectLoss(scan, FindingKind::kBlocksMissing, kWholeBytes, 0);
    const Loss& loss = scan.losses.at(0);
    EXPECT_EQ(loss.block, 1U);
    EXPECT_EQ(loss.last_block, next == 2 ? std::nullopt : std::optional(next - 1)) << next;
    EXPECT_EQ(loss.first_row, 2U);
    EXPECT_EQ(loss.rows, 2UL * (next - 1));
  }
}

TEST(BlockScanner, ABlockMustFollowInNumberAndRow) {
  const BlockHead first = RowsHead(0);
  BlockHead second = RowsHead(1);
  EXPECT_TRUE(ScanOf(BlockOf(first) + BlockOf(second)).losses.empty());
  second.first_row = 1;
  ExpectLoss(ScanOf(BlockOf(first) + BlockOf(second)), FindingKind::kBlockOutOfOrder, kWholeBytes,
             kWholeBytes);
  second = RowsHead(1);
  second.sequence = 0;
  ExpectLoss(ScanOf(BlockOf(first) + BlockOf(second)), FindingKind::kBlockOutOfOrder, kWholeBytes,
             kWholeBytes);
}

// a damaged block that belongs elsewhere does not turn the count back
TEST(BlockScanner, ADamagedBlockThatDoesNotFollowCountsForNothing) {
  const std::string blocks = BlocksOfRows(3);
  const std::string first = blocks.substr(0, kWholeBytes);
  const std::string second = blocks.substr(kWholeBytes, kWholeBytes);
  const Scan scan = ScanOf(first + second + Flipped(first, kWholeBytes - 1) + second +
                           blocks.substr(2 * kWholeBytes));
  EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0, 1, 2}));
  ASSERT_EQ(scan.losses.size(), 2U);
  EXPECT_EQ(scan.losses[0].kind, FindingKind::kBlocksDamaged);
  EXPECT_EQ(scan.losses[0].offset, 2 * kWholeBytes);
  EXPECT_EQ(scan.losses[0].bytes, kWholeBytes);
  EXPECT_EQ(scan.losses[0].block, 0U);
  EXPECT_EQ(scan.losses[1].kind, FindingKind::kBlockOutOfOrder);
  EXPECT_EQ(scan.losses[1].offset, 3 * kWholeBytes);
  EXPECT_EQ(scan.losses[1].block, 1U);
  EXPECT_EQ(scan.losses[1].first_row, 2U);
  EXPECT_EQ(scan.losses[1].rows, 2U);
}

// damage on both sides of a block that is out of order is one loss, from its begin to its end
TEST(BlockScanner, DamageGoesOnBehindABlockThatDoesNotFollow) {
  const std::string blocks = BlocksOfRows(3);
  const std::string first = blocks.substr(0, kWholeBytes);
  const std::string before(60, 'x'), behind(71, 'y');
  const Scan scan = ScanOf(blocks.substr(0, 2 * kWholeBytes) + before + first + behind +
                           blocks.substr(2 * kWholeBytes));
  EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0, 1, 2}));
  ASSERT_EQ(scan.losses.size(), 2U);
  EXPECT_EQ(scan.losses[0].kind, FindingKind::kBlocksDamaged);
  EXPECT_EQ(scan.losses[0].offset, 2 * kWholeBytes);
  EXPECT_EQ(scan.losses[0].bytes, 60 + kWholeBytes + 71);
  EXPECT_EQ(scan.losses[0].first_row, 4U);
  EXPECT_EQ(scan.losses[0].rows, 0U);
  EXPECT_EQ(scan.losses[1].kind, FindingKind::kBlockOutOfOrder);
  EXPECT_EQ(scan.losses[1].offset, 2 * kWholeBytes + 60);
}

// another program appended it, which may have read fewer rows
TEST(BlockScanner, TheRowOfALaterEventCountsForNothing) {
  const BlockHead later{.kind = BlockKind::kLaterEvent, .sequence = 1, .first_row = 0};
  BlockHead third = RowsHead(2);
  third.first_row = 2;
  const Scan scan = ScanOf(BlockOf(RowsHead(0)) + BlockOf(later) + BlockOf(third));
  EXPECT_EQ(scan.found, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(scan.losses.empty());
  // it cannot tell how many rows were lost before it; an event of the recorder can
  BlockHead event{.kind = BlockKind::kLaterEvent, .sequence = 2, .first_row = 5};
  EXPECT_EQ(ScanOf(BlockOf(RowsHead(0)) + BlockOf(event)).losses.at(0).rows, std::nullopt);
  event.kind = BlockKind::kEvent;
  EXPECT_EQ(ScanOf(BlockOf(RowsHead(0)) + BlockOf(event)).losses.at(0).rows, 3U);
}

// what is told of the sink: a block is kept when it is whole, else taken away
class CountingSink final : public ByteSink {
 public:
  explicit CountingSink(std::size_t room) : room_(room) {}
  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    if (room_ == 0) return Failed("", "full");
    const std::size_t count = std::min(bytes.size(), room_);
    room_ -= count;
    return count;
  }
  Result<void> Sync() override { return {}; }
  void Keep() override { ++kept; }
  void CutToKept() override { ++cuts; }
  int kept = 0;
  int cuts = 0;

 private:
  std::size_t room_;
};

TEST(WriteBlock, KeepsAWholeBlockAndTakesAPartAway) {
  for (const std::size_t room : {kWholeBytes, kWholeBytes - 1, kBlockHeadBytes - 1}) {
    CountingSink sink(room);
    const auto done = WriteBlock(&sink, {}, BytesOfText(std::string(kPayloadBytes, 'p')));
    EXPECT_EQ(done.has_value(), room == kWholeBytes) << room;
    EXPECT_EQ(sink.kept, room == kWholeBytes ? 1 : 0) << room;
    EXPECT_EQ(sink.cuts, room == kWholeBytes ? 0 : 1) << room;
  }
}

}  // namespace
}  // namespace haptometer::trial
