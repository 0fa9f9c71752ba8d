// A pipe's bytes in any of its forms: any split gives the same rows, and no byte is lost: each is
// in a row, in a bad row, or waits.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "acquire/protocol/sample_format.h"
#include "fuzz/require.h"

namespace {

using namespace haptometer::acquire;
using namespace haptometer::fuzz;
using haptometer::trial::RawLimits;
using haptometer::trial::Sample;
using haptometer::trial::SampleStatus;

// bits and status of every sample
using Rows = std::vector<std::pair<std::uint64_t, SampleStatus>>;

Rows Parse(SampleFormat format, const std::vector<RawLimits>& limits, std::string_view bytes,
           std::size_t piece) {
  SampleParser parser(format, limits);
  std::vector<Sample> row(limits.size());
  Rows rows;
  const std::size_t size = bytes.size();
  while (!bytes.empty()) {
    parser.Feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    while (parser.Next(row) != RowState::kNeedMore) {
      for (const Sample& sample : row) rows.emplace_back(sample.raw.bits(), sample.status);
    }
  }
  Require(parser.waiting_bytes() + parser.discarded_bytes() <= size);
  if (format != SampleFormat::kText) {
    const std::size_t width = format == SampleFormat::kF64   ? 8
                              : format == SampleFormat::kF32 ? 4
                                                             : 2;
    Require(rows.size() * width + parser.waiting_bytes() == size);
  }
  return rows;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const auto format = static_cast<SampleFormat>(data[0] % 4);
  const std::vector<RawLimits> limits(
      1 + data[0] / 4 % 5,
      {.rail_min = -32768, .rail_max = 32767, .bad_below = -1e4, .bad_above = 5.25});
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 2, size - 2);
  Require(Parse(format, limits, bytes, 1 + data[1] % 16) ==
          Parse(format, limits, bytes, std::max<std::size_t>(bytes.size(), 1)));
  return 0;
}
