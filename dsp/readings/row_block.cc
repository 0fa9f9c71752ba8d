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
  constexpr std::array kKernels{&kRowKernelBaseline, &kRowKernelAvx2, &kRowKernelAvx512};
  return *kKernels.at(static_cast<std::size_t>(UsableInstructionSet()));
}

}  // namespace haptometer::dsp
