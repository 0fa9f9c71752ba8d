#pragma once

#include <cstdint>
#include <string_view>

namespace haptometer {

/// Instruction sets of x86-64 that loops are compiled for. All give the same bytes. On other
/// processors there is only kBaseline, which is what the compiler's flags say: NEON on AArch64.
enum class InstructionSet : std::uint8_t {
  kBaseline,  ///< SSE2, which every processor of x86-64 has
  kAvx2,      ///< with carry-less products of 128 bits
  kAvx512,    ///< F, DQ, VL and BW
};

inline constexpr InstructionSet kInstructionSets[] = {
    InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512};

/// "sse2", "avx2", "avx512".
[[nodiscard]] std::string_view Name(InstructionSet set);

/// Whether this processor, and the system's saving of its registers, know it.
[[nodiscard]] bool IsSupported(InstructionSet set);

/// The widest supported one up to the one called `limit`; other texts limit nothing.
[[nodiscard]] InstructionSet WidestInstructionSet(std::string_view limit);

/// The one that loops of this process use: the widest supported one up to the value of
/// HAPTOMETER_INSTRUCTION_SET in the environment, which is read once.
[[nodiscard]] InstructionSet UsableInstructionSet();

}  // namespace haptometer
