#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "trial/block.h"
#include "trial/byte_source.h"
#include "trial/trial_reader.h"

namespace haptometer::trial {

/// A sound block and where it lies.
struct FoundBlock {
  BlockHead head;
  std::uint64_t offset = 0;
};

/// Walks the blocks of a trial.bin, skips what is damaged, and keeps account of it.
///
/// A block whose payload fails its CRC is skipped by its length; a damaged head by looking for the
/// next sound one. Sequence numbers and row counts of the sound blocks tell what lay in between.
class BlockScanner {
 public:
  /// Starts at `offset`; `source` must outlive the scanner.
  BlockScanner(const ByteSource* source, std::uint64_t offset);

  /// The next sound block, its payload in `*payload`; nothing at the end of the file.
  [[nodiscard]] Result<std::optional<FoundBlock>> Next(std::vector<std::byte>* payload);

  /// Where blocks of rows were found to be sound up to byte `end` (trial/checked_blocks.h): their
  /// payloads are neither read nor checked again, and Next() leaves `*payload` empty.
  void Trust(std::uint64_t end) { trusted_end_ = end; }
  [[nodiscard]] std::uint64_t offset() const { return offset_; }

  /// Counts a block that Next() gave as lost after all: "block N " + `why`.
  void Reject(const FoundBlock& block, const std::string& why);

  [[nodiscard]] const std::vector<Loss>& losses() const { return losses_; }
  [[nodiscard]] std::uint32_t next_sequence() const { return next_sequence_; }
  [[nodiscard]] std::uint64_t next_row() const { return next_row_; }

 private:
  [[nodiscard]] Result<std::optional<BlockHead>> HeadAt(std::uint64_t offset);
  [[nodiscard]] Result<std::uint64_t> FindHead(std::uint64_t from);
  [[nodiscard]] Result<bool> LoadPayload(const BlockHead& head, std::vector<std::byte>* payload);
  [[nodiscard]] Result<std::uint64_t> EndOfDamaged(const BlockHead& head);
  [[nodiscard]] Result<void> SkipToNextHead();
  [[nodiscard]] Result<void> SkipBlock(const BlockHead& head);
  [[nodiscard]] bool Follows(const BlockHead& head) const;
  void Settle(const FoundBlock& block);

  const ByteSource* source_;
  std::uint64_t offset_;
  std::uint64_t trusted_end_ = 0;
  std::uint32_t next_sequence_ = 0;
  std::uint64_t next_row_ = 0;
  std::optional<std::size_t> open_loss_;  // the loss whose blocks and rows are not known yet
  std::vector<Loss> losses_;
};

}  // namespace haptometer::trial
