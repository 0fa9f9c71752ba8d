#include "dsp/readings/row_block.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "base/error.h"
#include "base/instruction_set.h"
#include "dsp/readings/row_kernel.h"

namespace haptometer::dsp {

// several results are kept apart, so that no step waits for the one before it
bool AllOk(std::span<const trial::SampleStatus> statuses) {
  static_assert(static_cast<int>(trial::SampleStatus::kOk) == 0);
  std::array<std::uint64_t, 4> seen{};
  while (statuses.size() >= sizeof seen) {
    std::array<std::uint64_t, 4> words;
    std::memcpy(words.data(), statuses.data(), sizeof words);
    for (std::size_t lane = 0; lane < words.size(); ++lane) seen[lane] |= words[lane];
    statuses = statuses.subspan(sizeof words);
  }
  for (const trial::SampleStatus status : statuses) seen[0] |= static_cast<std::uint64_t>(status);
  return (seen[0] | seen[1] | seen[2] | seen[3]) == 0;
}

bool AllFinite(std::span<const double> values) {
  return WidestRowKernel().all_finite(values.data(), values.size());
}

const RowKernel& WidestRowKernel() {
  switch (UsableInstructionSet()) {
    case InstructionSet::kBaseline:
      return kRowKernelBaseline;
    case InstructionSet::kAvx2:
      return kRowKernelAvx2;
    case InstructionSet::kAvx512:
      return kRowKernelAvx512;
  }
  HAPTOMETER_CHECK(false, "instruction set {}", static_cast<int>(UsableInstructionSet()));
}

}  // namespace haptometer::dsp
