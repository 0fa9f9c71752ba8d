#include "trial/block.h"

#include <fmt/core.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "base/jobs.h"

namespace haptometer::trial {
namespace {

// offsets in a block head, as in docs/reference/formats.md
constexpr std::size_t kKindAt = 8;
constexpr std::size_t kSequenceAt = 12;
constexpr std::size_t kRowsAt = 16;
constexpr std::size_t kPayloadBytesAt = 20;
constexpr std::size_t kFirstRowAt = 24;
constexpr std::size_t kFirstIndexAt = 32;
constexpr std::size_t kPayloadCrcAt = 40;
constexpr std::size_t kHeadCrcAt = 44;

}  // namespace

std::array<std::byte, kBlockHeadBytes> EncodeBlockHead(const BlockHead& head) {
  std::array<std::byte, kBlockHeadBytes> bytes{};
  std::memcpy(bytes.data(), kBlockMagic.data(), kBlockMagic.size());
  StoreLittleEndian(static_cast<std::uint32_t>(head.kind), &bytes[kKindAt]);
  StoreLittleEndian(head.sequence, &bytes[kSequenceAt]);
  StoreLittleEndian(head.rows, &bytes[kRowsAt]);
  StoreLittleEndian(head.payload_bytes, &bytes[kPayloadBytesAt]);
  StoreLittleEndian(head.first_row, &bytes[kFirstRowAt]);
  StoreLittleEndian(head.first_index, &bytes[kFirstIndexAt]);
  StoreLittleEndian(head.payload_crc, &bytes[kPayloadCrcAt]);
  // CRC over the 44 bytes before it
  StoreLittleEndian(Crc32(std::span(bytes).first<kHeadCrcAt>()), &bytes[kHeadCrcAt]);
  return bytes;
}

std::optional<BlockHead> DecodeBlockHead(std::span<const std::byte> bytes) {
  // a head is valid if it is whole and both magic and CRC are right
  if (bytes.size() < kBlockHeadBytes) return std::nullopt;
  if (std::memcmp(bytes.data(), kBlockMagic.data(), kBlockMagic.size()) != 0) return std::nullopt;
  const auto stored_crc = LoadLittleEndian<std::uint32_t>(&bytes[kHeadCrcAt]);
  if (stored_crc != Crc32(bytes.first<kHeadCrcAt>())) return std::nullopt;
  BlockHead head;
  head.kind = static_cast<BlockKind>(LoadLittleEndian<std::uint32_t>(&bytes[kKindAt]));
  head.sequence = LoadLittleEndian<std::uint32_t>(&bytes[kSequenceAt]);
  head.rows = LoadLittleEndian<std::uint32_t>(&bytes[kRowsAt]);
  head.payload_bytes = LoadLittleEndian<std::uint32_t>(&bytes[kPayloadBytesAt]);
  head.first_row = LoadLittleEndian<std::uint64_t>(&bytes[kFirstRowAt]);
  head.first_index = LoadLittleEndian<std::int64_t>(&bytes[kFirstIndexAt]);
  head.payload_crc = LoadLittleEndian<std::uint32_t>(&bytes[kPayloadCrcAt]);
  // at most 2^24 bytes (docs/reference/formats.md), so that no larger payload is allocated
  if (head.payload_bytes > kMaxPayloadBytes) return std::nullopt;
  return head;
}

Result<void> WriteAll(ByteSink* sink, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    HAPTOMETER_LET(const auto written, sink->WriteSome(bytes));
    bytes = bytes.subspan(written);
  }
  return {};
}

// a block is whole in the file or not there at all
Result<void> WriteBlock(ByteSink* sink, BlockHead head, std::span<const std::byte> payload) {
  HAPTOMETER_CHECK(payload.size() <= kMaxPayloadBytes, "payload of {} bytes", payload.size());
  head.payload_bytes = static_cast<std::uint32_t>(payload.size());
  head.payload_crc = Crc32(payload);
  auto done = WriteAll(sink, EncodeBlockHead(head));
  if (done) done = WriteAll(sink, payload);
  if (done) {
    sink->Keep();
  } else {
    sink->CutToKept();
  }
  return done;
}

// offsets in a packed row: time (0, 8 or 16 bytes), raw values, one status byte a channel
RowLayout LayoutOf(const TrialHeader& header) {
  RowLayout layout;
  if (header.timing == Timing::kArrival) layout.time_bytes = 8;
  if (header.timing == Timing::kPolled) layout.time_bytes = 16;
  std::size_t offset = layout.time_bytes;
  for (const ChannelFormat& channel : header.channels) {
    layout.value_offsets.push_back(offset);
    layout.value_bytes.push_back(BytesOf(channel.encoding));
    offset += BytesOf(channel.encoding);
  }
  layout.status_offset = offset;
  layout.row_bytes = offset + header.channels.size();
  return layout;
}

namespace {

// bytes that are searched for a magic at once
constexpr std::size_t kSearchBytes = 1U << 16;

// rows that a block adds to the recording's count
std::uint64_t RowsOf(const BlockHead& head) {
  return head.kind == BlockKind::kRows ? head.rows : 0;
}

}  // namespace

BlockScanner::BlockScanner(const ByteSource* source, std::uint64_t offset)
    : source_(source), offset_(offset) {}

Result<std::optional<FoundBlock>> BlockScanner::Next(std::vector<std::byte>* payload) {
  while (offset_ < source_->size()) {
    HAPTOMETER_LET(const auto head, HeadAt(offset_));
    // no sound head here: bytes up to the next sound one are lost
    if (!head) {
      HAPTOMETER_TRY(SkipToNextHead());
      continue;
    }
    HAPTOMETER_LET(const auto sound, LoadPayload(*head, payload));
    // the head is right and the payload is not: only this block is lost
    if (!sound) {
      HAPTOMETER_TRY(SkipBlock(*head));
      continue;
    }
    const FoundBlock block{*head, offset_};
    offset_ += kBlockHeadBytes + head->payload_bytes;
    // a sequence number or row that does not increase: the block does not belong here
    if (!Follows(block.head)) {
      Reject(block, FindingKind::kBlockOutOfOrder);
      continue;
    }
    Settle(block);
    return block;
  }
  return std::nullopt;
}

void BlockScanner::Reject(const FoundBlock& block, FindingKind why) {
  const std::uint64_t rows = RowsOf(block.head);
  losses_.push_back({.offset = block.offset,
                     .bytes = kBlockHeadBytes + block.head.payload_bytes,
                     .kind = why,
                     .block = block.head.sequence,
                     .first_row = block.head.first_row,
                     .rows = rows});
}

Result<std::optional<BlockHead>> BlockScanner::HeadAt(std::uint64_t offset) {
  std::array<std::byte, kBlockHeadBytes> bytes;
  HAPTOMETER_LET(const auto got, source_->ReadAt(offset, bytes));
  return DecodeBlockHead(std::span(bytes).first(got));
}

Result<std::uint64_t> BlockScanner::FindHead(std::uint64_t from) {
  std::vector<std::byte> window(kSearchBytes);
  const auto magic = std::as_bytes(std::span(kBlockMagic));
  while (from < source_->size()) {
    HAPTOMETER_LET(const auto got, source_->ReadAt(from, window));
    const std::span seen = std::span(window).first(got);
    for (auto at = seen.begin();;) {
      at = std::search(at, seen.end(), magic.begin(), magic.end());
      if (at == seen.end()) break;
      const std::uint64_t place = from + static_cast<std::uint64_t>(at - seen.begin());
      // payloads may contain the magic by chance: only a sound head counts
      HAPTOMETER_LET(const auto head, HeadAt(place));
      if (head) return place;
      ++at;
    }
    // windows overlap, because a magic may lie across their border
    if (got < window.size()) break;
    from += window.size() - magic.size() + 1;
  }
  return source_->size();
}

Result<bool> BlockScanner::LoadPayload(const BlockHead& head, std::vector<std::byte>* payload) {
  // the file ends within the payload
  if (source_->size() - offset_ < kBlockHeadBytes + head.payload_bytes) return false;
  // rows whose CRC was checked before (Trust) need no reading here
  if (head.kind == BlockKind::kRows &&
      offset_ + kBlockHeadBytes + head.payload_bytes <= trusted_end_) {
    payload->clear();
    return true;
  }
  payload->resize(head.payload_bytes);
  HAPTOMETER_LET(const auto got, source_->ReadAt(offset_ + kBlockHeadBytes, *payload));
  return got == payload->size() && Crc32(*payload) == head.payload_crc;
}

// a damaged payload ends where its head states if a block or the file's end is there; otherwise it
// was cut and another block appended to it
Result<std::uint64_t> BlockScanner::EndOfDamaged(const BlockHead& head) {
  const std::uint64_t end = offset_ + kBlockHeadBytes + head.payload_bytes;
  if (end == source_->size()) return end;
  HAPTOMETER_LET(const auto next, HeadAt(end));
  if (next) return end;
  return FindHead(offset_ + kBlockHeadBytes);
}

Result<void> BlockScanner::SkipBlock(const BlockHead& head) {
  HAPTOMETER_LET(const auto end, EndOfDamaged(head));
  const bool is_cut =
      end == source_->size() && end - offset_ < kBlockHeadBytes + head.payload_bytes;
  // its head is sound, so the rows that it held are known
  if (Follows(head)) Settle({head, offset_});
  losses_.push_back({.offset = offset_,
                     .bytes = end - offset_,
                     .kind = is_cut ? FindingKind::kEndsInBlock : FindingKind::kBlocksDamaged,
                     .block = head.sequence,
                     .first_row = head.first_row,
                     .rows = RowsOf(head)});
  offset_ = end;
  return {};
}

Result<void> BlockScanner::SkipToNextHead() {
  HAPTOMETER_LET(const auto next, FindHead(offset_ + 1));
  // the last bytes are shorter than a head: the file ends in one
  const bool is_cut = next == source_->size() && next - offset_ < kBlockHeadBytes;
  // damage in several places without a sound head between them is one loss
  if (open_loss_) {
    losses_[*open_loss_].bytes = next - losses_[*open_loss_].offset;
  } else {
    losses_.push_back({.offset = offset_,
                       .bytes = next - offset_,
                       .kind = is_cut ? FindingKind::kEndsInBlock : FindingKind::kDamagedFromBlock,
                       .block = next_sequence_,
                       .first_row = next_row_,
                       // the next sound head gives the number of rows
                       .rows = std::nullopt});
    open_loss_ = losses_.size() - 1;
  }
  offset_ = next;
  return {};
}

// sequence numbers increase; so do rows, except for events that another program appended
bool BlockScanner::Follows(const BlockHead& head) const {
  if (head.sequence < next_sequence_) return false;
  return head.kind == BlockKind::kLaterEvent || head.first_row >= next_row_;
}

// completes the loss between the last sound head and this one, and sets what may follow
void BlockScanner::Settle(const FoundBlock& block) {
  const BlockHead& head = block.head;
  // a jump of the sequence number without damaged bytes: blocks are missing altogether
  if (!open_loss_ && head.sequence > next_sequence_) {
    losses_.push_back({.offset = block.offset,
                       .bytes = 0,
                       .kind = FindingKind::kBlocksMissing,
                       .block = next_sequence_,
                       .first_row = next_row_,
                       .rows = std::nullopt});
    open_loss_ = losses_.size() - 1;
  }
  // a later event has the rows that its writer could read, so it gives no number of lost rows
  if (open_loss_ && head.kind != BlockKind::kLaterEvent) {
    Loss& loss = losses_[*open_loss_];
    loss.kind = loss.bytes > 0 ? FindingKind::kBlocksDamaged : FindingKind::kBlocksMissing;
    loss.block = next_sequence_;
    if (head.sequence > next_sequence_ + 1) loss.last_block = head.sequence - 1;
    // rows lost = first row here - next row expected
    loss.rows = head.first_row - next_row_;
  }
  open_loss_.reset();
  next_sequence_ = head.sequence + 1;
  if (head.kind != BlockKind::kLaterEvent) next_row_ = head.first_row + RowsOf(head);
}

namespace {

// blocks whose payloads are checked in one go
constexpr std::size_t kBlocksPerJob = 32;

struct Payload {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;
};

// where payloads lie, by the heads alone, up to the first that is damaged
Result<std::vector<Payload>> FindPayloads(const ByteSource& source, std::uint64_t offset) {
  std::vector<Payload> payloads;
  std::array<std::byte, kBlockHeadBytes> bytes;
  for (;;) {
    HAPTOMETER_LET(const auto got, source.ReadAt(offset, bytes));
    const auto head = DecodeBlockHead(std::span(bytes).first(got));
    if (!head || source.size() - offset < kBlockHeadBytes + head->payload_bytes) return payloads;
    // the length of the list is in the file alone
    payloads.push_back({offset + kBlockHeadBytes, head->payload_bytes, head->payload_crc});
    offset += kBlockHeadBytes + head->payload_bytes;
  }
}

Result<bool> IsSound(const ByteSource& source, const Payload& payload,
                     std::vector<std::byte>& buffer) {
  if (buffer.size() < payload.bytes) buffer.resize(payload.bytes);
  const auto bytes = std::span(buffer).first(payload.bytes);
  HAPTOMETER_LET(const auto got, source.ReadAt(payload.offset, bytes));
  return got == bytes.size() && Crc32(bytes) == payload.crc;
}

}  // namespace

// CRCs in jobs of 32 blocks by several threads; the answer is the first damaged block of all
Result<std::uint64_t> SoundUntil(const ByteSource& source, std::uint64_t offset, int threads) {
  HAPTOMETER_LET(const auto payloads, FindPayloads(source, offset));
  std::size_t sound = payloads.size();  // the first that is damaged
  std::mutex mutex;
  const std::size_t jobs = (payloads.size() + kBlocksPerJob - 1) / kBlocksPerJob;
  HAPTOMETER_TRY(RunJobs(jobs, threads, [&]() -> Worker {
    return [&, buffer = std::vector<std::byte>()](std::size_t job) mutable -> Result<void> {
      const std::size_t end = std::min((job + 1) * kBlocksPerJob, payloads.size());
      for (std::size_t k = job * kBlocksPerJob; k < end; ++k) {
        HAPTOMETER_LET(const auto is_sound, IsSound(source, payloads[k], buffer));
        // a job ends at its first damaged block; the least over all jobs counts
        if (is_sound) continue;
        const std::scoped_lock lock(mutex);
        sound = std::min(sound, k);
        break;
      }
      return {};
    };
  }));
  // sound up to the head of the first damaged block
  if (sound < payloads.size()) return payloads[sound].offset - kBlockHeadBytes;
  if (payloads.empty()) return offset;
  return payloads.back().offset + payloads.back().bytes;
}

}  // namespace haptometer::trial
