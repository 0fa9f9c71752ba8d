#include "base/instruction_set.h"

#include <cstdlib>

#include "base/error.h"
#include "base/names.h"

namespace haptometer {

std::string_view Name(InstructionSet set) {
  return Names<InstructionSet, 3>{{"sse2", "avx2", "avx512"}}.Of(set);
}

#ifdef __x86_64__
bool IsSupported(InstructionSet set) {
  switch (set) {
    case InstructionSet::kBaseline:
      return true;
    case InstructionSet::kAvx2:
      return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("pclmul") != 0;
    case InstructionSet::kAvx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
             __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512bw") != 0;
  }
  HAPTOMETER_CHECK(false, "instruction set {}", static_cast<int>(set));
}
#else
bool IsSupported(InstructionSet set) { return set == InstructionSet::kBaseline; }
#endif

InstructionSet WidestInstructionSet(std::string_view limit) {
  InstructionSet best = InstructionSet::kBaseline;
  for (const InstructionSet set : kInstructionSets) {
    if (IsSupported(set)) best = set;
    if (Name(set) == limit) break;
  }
  return best;
}

InstructionSet UsableInstructionSet() {
  static const InstructionSet usable = [] {
    const char* const limit = std::getenv("HAPTOMETER_INSTRUCTION_SET");
    return WidestInstructionSet(limit == nullptr ? "" : limit);
  }();
  return usable;
}

}  // namespace haptometer
