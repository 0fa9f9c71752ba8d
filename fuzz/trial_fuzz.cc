// Any bytes as a trial.bin: no crash, and whatever is read keeps the promises of a record. The
// first byte chooses whether the checksums are made right first, so that what lies behind them is
// reached.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "base/error.h"
#include "trial/block.h"
#include "trial/byte_io.h"
#include "trial/trial_reader.h"

namespace {

using namespace haptometer::trial;

// writes the right CRCs into every block from the signature on
void RepairChecksums(std::string* bytes) {
  std::size_t at = kSignature.size();
  if (bytes->size() < at) return;
  std::memcpy(bytes->data(), kSignature.data(), kSignature.size());
  while (at + kBlockHeadBytes <= bytes->size()) {
    auto* head = reinterpret_cast<std::byte*>(bytes->data() + at);
    std::memcpy(head, kBlockMagic.data(), kBlockMagic.size());
    const std::size_t left = bytes->size() - at - kBlockHeadBytes;
    const std::uint32_t size = LoadLittleEndian<std::uint32_t>(head + 20) % (left + 1);
    StoreLittleEndian(size, head + 20);
    StoreLittleEndian(Crc32({head + kBlockHeadBytes, size}), head + 40);
    StoreLittleEndian(Crc32({head, 44}), head + 44);
    at += kBlockHeadBytes + size;
  }
}

void CheckRecord(const Recording& recording) {
  std::size_t covered = 0;
  for (const Stretch& stretch : recording.record.stretches) {
    HAPTOMETER_CHECK(stretch.first_row == covered && stretch.rows > 0 && stretch.rate_hz > 0,
                     "stretch at row {} of {}", stretch.first_row, covered);
    covered += stretch.rows;
  }
  HAPTOMETER_CHECK(covered == recording.record.rows, "{} of {} rows", covered,
                   recording.record.rows);
  for (const Channel& channel : recording.record.channels) {
    HAPTOMETER_CHECK(channel.values.size() == covered && channel.statuses.size() == covered,
                     "{} values", channel.values.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 1) RepairChecksums(&bytes);
  if (const auto read = ReadRecordFrom(MakeMemorySource(std::move(bytes)), "fuzz")) {
    CheckRecord(*read);
  }
  return 0;
}
