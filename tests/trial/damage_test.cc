// A small trial with everything in it (polled, three encodings, events, labels given later): cut at
// every byte, each bit flipped. What is still read must be true, and what is not must be stated.
// And blocks whose CRCs are right, but which do not fit.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/trial/trial_file.h"
#include "trial/block.h"
#include "trial/trial_format.h"
#include "trial/trial_writer.h"

namespace haptometer::trial {
namespace {

ChannelFormat Channel(const char* name, Encoding encoding) {
  ChannelFormat channel;
  channel.name = name;
  channel.encoding = encoding;
  return channel;
}

// three blocks of four rows, an event before the last, labels given after the end
std::string RichTrial() {
  const ScratchDirectory directory;
  const std::string path = directory.File("t.bin");
  TrialHeader header;
  header.timing = Timing::kPolled;
  header.channels = {Channel("a", Encoding::kI32), Channel("b", Encoding::kF32),
                     Channel("c", Encoding::kF64)};
  ManualClock clock;
  auto writer = TrialWriter::Create(path, header, {}, clock);
  EXPECT_TRUE(writer);
  for (int i = 0; i < 12; ++i) {
    const std::array<Sample, 3> samples{
        Sample{RawValue::Counts(1000 + i), SampleStatus::kOk},
        Sample{RawValue::F32(static_cast<float>(i) / 3), SampleStatus::kRepeated},
        Sample{RawValue::F64(i / 7.0), i % 5 == 4 ? SampleStatus::kOver : SampleStatus::kOk}};
    const std::int64_t t_ns = 10'000'000LL * i;
    EXPECT_TRUE(writer->Append({.time_ns = t_ns, .reply_ns = t_ns + 5, .samples = samples}));
    if (i == 7) {
      EXPECT_TRUE(writer->AddEvent({.kind = EventKind::kRemark, .text = "knocked"}));
    }
    if (i % 4 == 3) {
      EXPECT_TRUE(writer->Flush());
    }
  }
  EXPECT_TRUE(writer->Finish());
  EXPECT_TRUE(AppendEvent(path, {.kind = EventKind::kLabels, .labels = {{"subject", "4"}}}));
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Block {
  std::size_t begin = 0;
  std::size_t end = 0;
  BlockKind kind = BlockKind::kHeader;
};

std::vector<Block> BlocksOf(const std::string& bytes) {
  std::vector<Block> blocks;
  for (std::size_t at = kSignature.size(); at < bytes.size();) {
    const auto head = DecodeBlockHead(BytesOfText(bytes).subspan(at, kBlockHeadBytes));
    blocks.push_back({at, at + kBlockHeadBytes + head->payload_bytes, head->kind});
    at = blocks.back().end;
  }
  return blocks;
}

// what a reader hands out, raw
struct Read {
  bool opened = false;
  std::vector<std::int64_t> request_ns;
  std::vector<std::string> events;
  ReadReport report;
};

Read ReadRaw(const std::string& bytes) {
  Read read;
  auto reader = TrialReader::OpenFrom(MakeMemorySource(bytes), "t.bin");
  if (!reader) return read;
  read.opened = true;
  for (;;) {
    const auto chunk = reader->Next();
    EXPECT_TRUE(chunk);
    if (!chunk || *chunk == nullptr) break;
    for (std::size_t row = 0; row < (*chunk)->rows(); ++row) {
      // every value, status and time is that of its row
      const auto i = static_cast<int>((*chunk)->first_row() + row);
      EXPECT_EQ((*chunk)->TimeNs(row), 10'000'000LL * i);
      EXPECT_EQ((*chunk)->ReplyNs(row), 10'000'000LL * i + 5);
      EXPECT_EQ((*chunk)->At(row, 0).raw.bits(), RawValue::Counts(1000 + i).bits());
      EXPECT_EQ((*chunk)->At(row, 1).raw.bits(), RawValue::F32(static_cast<float>(i) / 3).bits());
      EXPECT_EQ((*chunk)->At(row, 2).raw.bits(), RawValue::F64(i / 7.0).bits());
      EXPECT_EQ((*chunk)->At(row, 0).status, SampleStatus::kOk);
      EXPECT_EQ((*chunk)->At(row, 1).status, SampleStatus::kRepeated);
      EXPECT_EQ((*chunk)->At(row, 2).status, i % 5 == 4 ? SampleStatus::kOver : SampleStatus::kOk);
      read.request_ns.push_back((*chunk)->TimeNs(row));
    }
  }
  read.report = reader->report();
  for (const Event& event : read.report.events) read.events.push_back(EventToJson(event));
  return read;
}

std::size_t CountBefore(const std::vector<Block>& blocks, BlockKind kind, std::size_t cut) {
  return static_cast<std::size_t>(std::ranges::count_if(
      blocks, [&](const Block& block) { return block.kind == kind && block.end <= cut; }));
}

TEST(Damage, CutAtEveryByteEveryWholeBlockBeforeIsRead) {
  const std::string whole = RichTrial();
  const auto blocks = BlocksOf(whole);
  ASSERT_EQ(CountBefore(blocks, BlockKind::kRows, whole.size()), 3);
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    SCOPED_TRACE(cut);
    const Read read = ReadRaw(whole.substr(0, cut));
    ASSERT_EQ(read.opened, CountBefore(blocks, BlockKind::kHeader, cut) > 0);
    if (!read.opened) continue;
    EXPECT_EQ(read.request_ns.size(), 4 * CountBefore(blocks, BlockKind::kRows, cut));
    EXPECT_EQ(read.events.size(), CountBefore(blocks, BlockKind::kEvent, cut) +
                                      CountBefore(blocks, BlockKind::kLaterEvent, cut));
    EXPECT_EQ(read.report.closed, CountBefore(blocks, BlockKind::kClose, cut) > 0);
    const bool is_between =
        cut == whole.size() ||
        std::ranges::any_of(blocks, [&](const Block& block) { return block.begin == cut; });
    EXPECT_EQ(read.report.losses.empty(), is_between);
  }
}

// No byte is harmless: signature, heads and payloads are all checked, so each of the flips is
// found.
TEST(Damage, EachFlippedBitIsStatedAndCostsItsBlockAlone) {
  const std::string whole = RichTrial();
  const auto blocks = BlocksOf(whole);
  const Read sound = ReadRaw(whole);
  ASSERT_TRUE(sound.report.losses.empty());
  ASSERT_EQ(sound.events.size(), 2);
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    SCOPED_TRACE(bit);
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    const Read read = ReadRaw(flipped);
    ASSERT_TRUE(read.opened);
    ASSERT_EQ(read.report.losses.size(), 1);
    const auto hit = std::ranges::find_if(
        blocks, [&](const Block& block) { return block.begin <= bit / 8 && bit / 8 < block.end; });
    const BlockKind kind = hit == blocks.end() ? BlockKind::kHeader : hit->kind;
    EXPECT_EQ(read.request_ns.size(), kind == BlockKind::kRows ? 8U : 12U);
    const bool hit_event = kind == BlockKind::kEvent || kind == BlockKind::kLaterEvent;
    EXPECT_EQ(read.events.size(), hit_event ? 1U : 2U);
    for (const std::string& event : read.events) {
      EXPECT_NE(std::ranges::find(sound.events, event), sound.events.end()) << event;
    }
    EXPECT_EQ(read.report.closed, kind != BlockKind::kClose);
  }
}

// --- sound blocks that do not fit --------------------------------------------------------------

std::string BlockWith(const BlockHead& head, const std::string& payload) {
  MemoryDisk disk;
  MemorySink sink(&disk);
  EXPECT_TRUE(WriteBlock(&sink, head, BytesOfText(payload)));
  return disk.bytes;
}

// signature and header; a row of counts has 5 bytes with the timing kUniform, 13 with kArrival
std::string Begun(const std::string& header, BlockKind kind = BlockKind::kHeader) {
  const std::string signature(kSignature.begin(), kSignature.end());
  return signature + BlockWith({.kind = kind}, header);
}

std::string Begun(Timing timing) { return Begun(HeaderToJson(CountsHeader(timing))); }

// a block of zeros; of those behind it the sequence number and row follow
std::string RowsBlock(std::uint32_t sequence, std::uint64_t first_row, std::uint32_t rows,
                      std::int64_t first_index, std::size_t bytes) {
  return BlockWith({.kind = BlockKind::kRows,
                    .sequence = sequence,
                    .rows = rows,
                    .first_row = first_row,
                    .first_index = first_index},
                   std::string(bytes, '\0'));
}

void ExpectLosses(const ReadReport& report, FindingKind kind, std::vector<std::uint32_t> blocks) {
  std::vector<std::uint32_t> found;
  for (const Loss& loss : report.losses) {
    EXPECT_EQ(loss.kind, kind);
    found.push_back(loss.block.value_or(UINT32_MAX));
  }
  EXPECT_EQ(found, blocks);
}

TEST(UnfitBlocks, OfRowsHoldWholeRowsOnTheGrid) {
  constexpr std::int64_t kLast = 1LL << 53;  // behind it a double skips places
  struct Case {
    Timing timing;
    std::uint32_t rows;
    std::int64_t first_index;
    std::size_t bytes;
    bool fits;
  };
  for (const Case& at :
       {Case{Timing::kUniform, 2, 0, 10, true}, Case{Timing::kUniform, 2, 0, 9, false},
        Case{Timing::kUniform, 2, 0, 11, false}, Case{Timing::kUniform, 3, 0, 10, false},
        Case{Timing::kUniform, 0, 0, 0, false}, Case{Timing::kUniform, 1, -1, 5, false},
        Case{Timing::kUniform, 1, kLast, 5, true}, Case{Timing::kUniform, 1, kLast + 1, 5, false},
        Case{Timing::kArrival, 2, -1, 26, true}, Case{Timing::kArrival, 2, kLast + 1, 26, true},
        Case{Timing::kArrival, 2, 0, 10, false}}) {
    SCOPED_TRACE(at.first_index);
    const auto read =
        ReadBytes(Begun(at.timing) + RowsBlock(1, 0, at.rows, at.first_index, at.bytes));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->record.rows, at.fits ? at.rows : 0) << at.bytes;
    ExpectLosses(read->report, FindingKind::kBlockUnfit,
                 at.fits ? std::vector<std::uint32_t>{} : std::vector<std::uint32_t>{1});
    if (at.fits) continue;
    EXPECT_EQ(read->report.losses[0].bytes, kBlockHeadBytes + at.bytes);
    EXPECT_EQ(read->report.losses[0].rows, at.rows);
  }
}

TEST(UnfitBlocks, OfRowsDoNotGoBackOnTheGrid) {
  const std::string first = Begun(Timing::kUniform) + RowsBlock(1, 0, 2, 5, 10);
  for (const std::int64_t next : {6, 7, 8}) {
    // an unfit block turns nothing back: the next follows on the first
    const auto read =
        ReadBytes(first + RowsBlock(2, 2, 1, next, 5) + RowsBlock(3, 3, 1, next + 1, 5));
    ASSERT_TRUE(read);
    EXPECT_EQ(read->record.rows, next == 6 ? 3U : 4U);
    ExpectLosses(read->report, FindingKind::kBlockUnfit,
                 next == 6 ? std::vector<std::uint32_t>{2} : std::vector<std::uint32_t>{});
    EXPECT_EQ(read->record.stretches.size(), next == 8 ? 2U : 1U);
    EXPECT_EQ(read->record.stretches[0].start_s, 0.005);
  }
}

TEST(UnfitBlocks, OfEventsThatAreNoneAreLost) {
  const std::string good = EventToJson({.kind = EventKind::kRemark, .text = "good"});
  std::string bytes = Begun(Timing::kUniform);
  std::uint32_t sequence = 1;
  for (const std::string& text : {std::string("not JSON"), std::string(R"({"event": 3})"),
                                  std::string(R"({"row": 3})"), good}) {
    bytes += BlockWith({.kind = BlockKind::kEvent, .sequence = sequence++}, text);
  }
  bytes += BlockWith({.kind = BlockKind::kLaterEvent, .sequence = sequence++}, "{");
  const auto read = ReadBytes(bytes);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->report.events.size(), 1U);
  EXPECT_EQ(read->report.events[0].text, "good");
  ExpectLosses(read->report, FindingKind::kBlockNoEvent, {1, 2, 3, 5});
  EXPECT_EQ(read->report.RowsLost(), 0U);
}

TEST(UnfitBlocks, OfAHeaderThatIsNoneLeaveNothingToRead) {
  const std::string header = HeaderToJson(CountsHeader(Timing::kUniform));
  EXPECT_TRUE(ReadBytes(Begun(header)));
  for (const std::string& bytes :
       {Begun("{}"), Begun("not JSON"), Begun(header, BlockKind::kEvent),
        Begun(header, BlockKind::kRows), Begun("{}") + Begun(header).substr(kSignature.size())}) {
    const auto read = ReadBytes(bytes);
    ASSERT_FALSE(read);
    EXPECT_EQ(read.error().cause, Cause::kCannotAnswer);
    EXPECT_TRUE(read.error().what.starts_with("both copies of its header are damaged"));
  }
}

}  // namespace
}  // namespace haptometer::trial
