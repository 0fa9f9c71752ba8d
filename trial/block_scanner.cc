#include "trial/block_scanner.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "trial/crc32.h"

namespace haptometer::trial {
namespace {

constexpr std::size_t kSearchBytes = 1U << 16;

std::uint64_t RowsOf(const BlockHead& head) {
  return head.kind == BlockKind::kRows ? head.rows : 0;
}

// "block 5 is", "blocks 5 to 7 are"
std::string BlocksAre(std::uint32_t first, std::uint32_t end) {
  if (end <= first + 1) return fmt::format("block {} is", first);
  return fmt::format("blocks {} to {} are", first, end - 1);
}

}  // namespace

BlockScanner::BlockScanner(const ByteSource* source, std::uint64_t offset)
    : source_(source), offset_(offset) {}

Result<std::optional<FoundBlock>> BlockScanner::Next(std::vector<std::byte>* payload) {
  while (offset_ < source_->size()) {
    const auto head = HeadAt(offset_);
    if (!head) return std::unexpected(head.error());
    if (!*head) {
      if (auto done = SkipToNextHead(); !done) return std::unexpected(done.error());
      continue;
    }
    const auto sound = LoadPayload(**head, payload);
    if (!sound) return std::unexpected(sound.error());
    if (!*sound) {
      if (auto done = SkipBlock(**head); !done) return std::unexpected(done.error());
      continue;
    }
    const FoundBlock block{**head, offset_};
    offset_ += kBlockHeadBytes + (*head)->payload_bytes;
    if (!Follows(block.head)) {
      Reject(block, "is out of its order");
      continue;
    }
    Settle(block);
    return block;
  }
  return std::nullopt;
}

void BlockScanner::Reject(const FoundBlock& block, const std::string& why) {
  const std::uint64_t rows = RowsOf(block.head);
  losses_.push_back({.offset = block.offset,
                     .bytes = kBlockHeadBytes + block.head.payload_bytes,
                     .what = fmt::format("block {} {}", block.head.sequence, why),
                     .first_row = block.head.first_row,
                     .rows = rows});
}

Result<std::optional<BlockHead>> BlockScanner::HeadAt(std::uint64_t offset) {
  std::array<std::byte, kBlockHeadBytes> bytes;
  const auto got = source_->ReadAt(offset, bytes);
  if (!got) return std::unexpected(got.error());
  return DecodeBlockHead(std::span(bytes).first(*got));
}

Result<std::uint64_t> BlockScanner::FindHead(std::uint64_t from) {
  std::vector<std::byte> window(kSearchBytes);
  const auto magic = std::as_bytes(std::span(kBlockMagic));
  while (from < source_->size()) {
    const auto got = source_->ReadAt(from, window);
    if (!got) return std::unexpected(got.error());
    const std::span seen = std::span(window).first(*got);
    for (auto at = seen.begin();;) {
      at = std::search(at, seen.end(), magic.begin(), magic.end());
      if (at == seen.end()) break;
      const std::uint64_t place = from + static_cast<std::uint64_t>(at - seen.begin());
      const auto head = HeadAt(place);
      if (!head) return std::unexpected(head.error());
      if (*head) return place;
      ++at;
    }
    // windows overlap, because a magic may lie across their border
    if (*got < window.size()) break;
    from += window.size() - magic.size() + 1;
  }
  return source_->size();
}

Result<bool> BlockScanner::LoadPayload(const BlockHead& head, std::vector<std::byte>* payload) {
  if (source_->size() - offset_ < kBlockHeadBytes + head.payload_bytes) return false;
  if (head.kind == BlockKind::kRows &&
      offset_ + kBlockHeadBytes + head.payload_bytes <= trusted_end_) {
    payload->clear();
    return true;
  }
  payload->resize(head.payload_bytes);
  const auto got = source_->ReadAt(offset_ + kBlockHeadBytes, *payload);
  if (!got) return std::unexpected(got.error());
  return *got == payload->size() && Crc32(*payload) == head.payload_crc;
}

// a damaged payload ends where its head says if a block or the file's end is there; otherwise it
// was cut and something appended to it
Result<std::uint64_t> BlockScanner::EndOfDamaged(const BlockHead& head) {
  const std::uint64_t end = offset_ + kBlockHeadBytes + head.payload_bytes;
  if (end == source_->size()) return end;
  const auto next = HeadAt(end);
  if (!next) return std::unexpected(next.error());
  if (*next) return end;
  return FindHead(offset_ + kBlockHeadBytes);
}

Result<void> BlockScanner::SkipBlock(const BlockHead& head) {
  const auto end = EndOfDamaged(head);
  if (!end) return std::unexpected(end.error());
  const bool is_cut =
      *end == source_->size() && *end - offset_ < kBlockHeadBytes + head.payload_bytes;
  // its head is sound, so what it held is known
  if (Follows(head)) Settle({head, offset_});
  losses_.push_back({.offset = offset_,
                     .bytes = *end - offset_,
                     .what = is_cut ? fmt::format("the file ends inside block {}", head.sequence)
                                    : fmt::format("block {} is damaged", head.sequence),
                     .first_row = head.first_row,
                     .rows = RowsOf(head)});
  offset_ = *end;
  return {};
}

Result<void> BlockScanner::SkipToNextHead() {
  const auto next = FindHead(offset_ + 1);
  if (!next) return std::unexpected(next.error());
  const bool is_cut = *next == source_->size() && *next - offset_ < kBlockHeadBytes;
  if (open_loss_) {
    losses_[*open_loss_].bytes = *next - losses_[*open_loss_].offset;
  } else {
    losses_.push_back(
        {.offset = offset_,
         .bytes = *next - offset_,
         .what = is_cut ? fmt::format("the file ends inside block {}", next_sequence_)
                        : fmt::format("the file is damaged from block {} on", next_sequence_),
         .first_row = next_row_,
         .rows = std::nullopt});
    open_loss_ = losses_.size() - 1;
  }
  offset_ = *next;
  return {};
}

bool BlockScanner::Follows(const BlockHead& head) const {
  if (head.sequence < next_sequence_) return false;
  return head.kind == BlockKind::kLaterEvent || head.first_row >= next_row_;
}

// what lay between the last sound head and this one
void BlockScanner::Settle(const FoundBlock& block) {
  const BlockHead& head = block.head;
  if (!open_loss_ && head.sequence > next_sequence_) {
    losses_.push_back({.offset = block.offset,
                       .bytes = 0,
                       .what = "",
                       .first_row = next_row_,
                       .rows = std::nullopt});
    open_loss_ = losses_.size() - 1;
  }
  if (open_loss_ && head.kind != BlockKind::kLaterEvent) {
    Loss& loss = losses_[*open_loss_];
    loss.what =
        BlocksAre(next_sequence_, head.sequence) + (loss.bytes > 0 ? " damaged" : " missing");
    loss.rows = head.first_row - next_row_;
  }
  open_loss_.reset();
  next_sequence_ = head.sequence + 1;
  if (head.kind != BlockKind::kLaterEvent) next_row_ = head.first_row + RowsOf(head);
}

}  // namespace haptometer::trial
