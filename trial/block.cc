#include "trial/block.h"

#include "base/error.h"
#include "trial/crc32.h"

namespace haptometer::trial {
namespace {

// offsets in a block head, as in docs/formats.md
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
  StoreLittleEndian(Crc32(std::span(bytes).first<kHeadCrcAt>()), &bytes[kHeadCrcAt]);
  return bytes;
}

std::optional<BlockHead> DecodeBlockHead(std::span<const std::byte> bytes) {
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
  if (head.payload_bytes > kMaxPayloadBytes) return std::nullopt;
  return head;
}

Result<void> WriteAll(ByteSink* sink, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto written = sink->WriteSome(bytes);
    if (!written) return std::unexpected(written.error());
    bytes = bytes.subspan(*written);
  }
  return {};
}

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

}  // namespace haptometer::trial
