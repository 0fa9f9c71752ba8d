#include "dsp/filter/instruction_set.h"

#include "base/error.h"

namespace haptometer::dsp {

bool IsSupported(InstructionSet set) {
  switch (set) {
    case InstructionSet::kBaseline:
      return true;
    case InstructionSet::kAvx2:
      return __builtin_cpu_supports("avx2") != 0;
    case InstructionSet::kAvx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
             __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512bw") != 0;
  }
  HAPTOMETER_CHECK(false, "instruction set {}", static_cast<int>(set));
}

InstructionSet WidestInstructionSet() {
  static const InstructionSet widest = [] {
    InstructionSet best = InstructionSet::kBaseline;
    for (const InstructionSet set : kInstructionSets) {
      if (IsSupported(set)) best = set;
    }
    return best;
  }();
  return widest;
}

std::string_view Name(InstructionSet set) {
  switch (set) {
    case InstructionSet::kBaseline:
      return "baseline";
    case InstructionSet::kAvx2:
      return "avx2";
    case InstructionSet::kAvx512:
      return "avx512";
  }
  HAPTOMETER_CHECK(false, "instruction set {}", static_cast<int>(set));
}

}  // namespace haptometer::dsp
