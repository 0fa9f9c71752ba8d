#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/byte_io.h"
#include "trial/trial_format.h"
#include "trial/trial_reader.h"

/// The bytes of a trial.bin as docs/reference/formats.md gives them: signature, block heads, rows.
namespace haptometer::trial {

static_assert(std::endian::native == std::endian::little,
              "trial files are little-endian and are copied as they lie in memory");

inline constexpr std::uint8_t kFormatVersion = 1;

/// 16 bytes at the start. A byte above 127, CR LF and LF show a transfer that changed text; the
/// version stands beside its complement, so that one flipped bit is no newer version.
inline constexpr std::array<std::uint8_t, 16> kSignature{
    0x93, 'h', 'a', 'p', 't', 'r', 'i', 'a', 'l', '\r', '\n', 0x1a, '\n', 1, 0xfe, 0};
static_assert(kSignature[13] == kFormatVersion && kSignature[14] == 0xff - kFormatVersion);

/// 8 bytes at the start of every block; a reader that lost its way looks for them.
inline constexpr std::array<std::uint8_t, 8> kBlockMagic{0x93, 'b', 'l', 'o', 'c', 'k', '\r', '\n'};

inline constexpr std::size_t kBlockHeadBytes = 48;

/// No block carries more, so a reader's memory is bounded whatever a file claims.
inline constexpr std::uint32_t kMaxPayloadBytes = 1U << 24;

/// What a block's payload is.
enum class BlockKind : std::uint32_t {
  kHeader = 1,  ///< JSON; written twice, so that one damaged block does not cost the trial
  kRows = 2,    ///< a rectangle of rows of one size
  kEvent = 3,   ///< JSON
  kClose = 4,   ///< JSON with the totals
  kLaterEvent =
      5,  ///< JSON, appended by another than the recorder: its first_row counts for nothing
};

/// The 48 bytes before a payload, except the magic and the head's own CRC-32.
struct BlockHead {
  BlockKind kind = BlockKind::kRows;
  std::uint32_t sequence = 0;  ///< 0, 1, 2, ... in the order of writing
  std::uint32_t rows = 0;      ///< in this block
  std::uint32_t payload_bytes = 0;
  std::uint64_t first_row = 0;   ///< rows written before this block
  std::int64_t first_index = 0;  ///< kUniform: place of the first row on the grid; else first_row
  std::uint32_t payload_crc = 0;
};

/// The 48 bytes of `head`, with magic and CRC.
[[nodiscard]] std::array<std::byte, kBlockHeadBytes> EncodeBlockHead(const BlockHead& head);

/// What `bytes` hold, or nothing when they are no sound block head (too few, wrong magic or CRC, a
/// payload beyond kMaxPayloadBytes).
[[nodiscard]] std::optional<BlockHead> DecodeBlockHead(std::span<const std::byte> bytes);

/// Writes all of `bytes`, however few the sink takes at a time.
[[nodiscard]] Result<void> WriteAll(ByteSink* sink, std::span<const std::byte> bytes);

/// Writes `head`, with length and CRC of `payload` filled in, and `payload`; or nothing of them,
/// where the sink does not take all.
[[nodiscard]] Result<void> WriteBlock(ByteSink* sink, BlockHead head,
                                      std::span<const std::byte> payload);

/// Where the parts of a row lie. A row is packed: times, raw values, one status byte a value.
struct RowLayout {
  std::size_t time_bytes = 0;              ///< 0 (kUniform), 8 (kArrival), 16 (kPolled)
  std::vector<std::size_t> value_offsets;  ///< per channel
  std::vector<std::size_t> value_bytes;    ///< per channel: 4 or 8
  std::size_t status_offset = 0;           ///< of channel 0's status
  std::size_t row_bytes = 0;
};

[[nodiscard]] RowLayout LayoutOf(const TrialHeader& header);

/// Copies a number to or from bytes; the caller keeps `bytes` long enough.
template <typename T>
void StoreLittleEndian(T value, std::byte* bytes) {
  std::memcpy(bytes, &value, sizeof value);
}
template <typename T>
[[nodiscard]] T LoadLittleEndian(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Adds the bytes of a number to `bytes`.
template <typename T>
void AppendLittleEndian(T value, std::string* bytes) {
  bytes->resize(bytes->size() + sizeof value);
  StoreLittleEndian(value,
                    reinterpret_cast<std::byte*>(bytes->data() + bytes->size() - sizeof value));
}

/// The bytes of `text`.
[[nodiscard]] inline std::span<const std::byte> BytesOfText(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

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

  /// Where blocks of rows were found to be sound up to byte `end` (trial/block.h): their
  /// payloads are neither read nor checked again, and Next() leaves `*payload` empty.
  void Trust(std::uint64_t end) { trusted_end_ = end; }
  [[nodiscard]] std::uint64_t offset() const { return offset_; }

  /// Counts a block that Next() gave as lost after all: "block N " + `why`.
  void Reject(const FoundBlock& block, FindingKind why);

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

/// Up to which byte blocks follow each other from `offset` on, each with a sound head and a sound
/// payload: the end of the file, or where the first damaged block begins.
///
/// The payloads' CRCs are computed on `threads` threads. Errors: as ByteSource::ReadAt. Memory: a
/// payload a thread, 16 B a block.
[[nodiscard]] Result<std::uint64_t> SoundUntil(const ByteSource& source, std::uint64_t offset,
                                               int threads);

}  // namespace haptometer::trial
