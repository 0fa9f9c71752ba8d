#include "trial/checked_blocks.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>
#include <span>
#include <vector>

#include "base/jobs.h"
#include "trial/block.h"
#include "trial/crc32.h"

namespace haptometer::trial {
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
    const auto got = source.ReadAt(offset, bytes);
    if (!got) return std::unexpected(got.error());
    const auto head = DecodeBlockHead(std::span(bytes).first(*got));
    if (!head || source.size() - offset < kBlockHeadBytes + head->payload_bytes) return payloads;
    // a list whose length only the file knows
    payloads.push_back({offset + kBlockHeadBytes, head->payload_bytes, head->payload_crc});
    offset += kBlockHeadBytes + head->payload_bytes;
  }
}

Result<bool> IsSound(const ByteSource& source, const Payload& payload,
                     std::vector<std::byte>& buffer) {
  if (buffer.size() < payload.bytes) buffer.resize(payload.bytes);
  const auto bytes = std::span(buffer).first(payload.bytes);
  const auto got = source.ReadAt(payload.offset, bytes);
  if (!got) return std::unexpected(got.error());
  return *got == bytes.size() && Crc32(bytes) == payload.crc;
}

}  // namespace

Result<std::uint64_t> SoundUntil(const ByteSource& source, std::uint64_t offset, int threads) {
  const auto payloads = FindPayloads(source, offset);
  if (!payloads) return std::unexpected(payloads.error());
  std::size_t sound = payloads->size();  // the first that is damaged
  std::mutex mutex;
  const std::size_t jobs = (payloads->size() + kBlocksPerJob - 1) / kBlocksPerJob;
  const auto checked = RunJobs(jobs, threads, [&]() -> Worker {
    return [&, buffer = std::vector<std::byte>()](std::size_t job) mutable -> Result<void> {
      const std::size_t end = std::min((job + 1) * kBlocksPerJob, payloads->size());
      for (std::size_t k = job * kBlocksPerJob; k < end; ++k) {
        const auto is_sound = IsSound(source, (*payloads)[k], buffer);
        if (!is_sound) return std::unexpected(is_sound.error());
        if (*is_sound) continue;
        const std::scoped_lock lock(mutex);
        sound = std::min(sound, k);
        break;
      }
      return {};
    };
  });
  if (!checked) return std::unexpected(checked.error());
  if (sound < payloads->size()) return (*payloads)[sound].offset - kBlockHeadBytes;
  if (payloads->empty()) return offset;
  return payloads->back().offset + payloads->back().bytes;
}

}  // namespace haptometer::trial
