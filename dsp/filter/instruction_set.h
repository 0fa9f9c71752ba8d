#pragma once

#include <cstdint>
#include <string_view>

namespace haptometer::dsp {

/// Instruction sets that the filter kernel is compiled for. All give the same bytes.
enum class InstructionSet : std::uint8_t { kBaseline, kAvx2, kAvx512 };

inline constexpr InstructionSet kInstructionSets[] = {
    InstructionSet::kBaseline, InstructionSet::kAvx2, InstructionSet::kAvx512};

/// Whether this processor, and the system's saving of its registers, know it.
[[nodiscard]] bool IsSupported(InstructionSet set);

/// The fastest one that this processor knows.
[[nodiscard]] InstructionSet WidestInstructionSet();

/// "baseline", "avx2", "avx512".
[[nodiscard]] std::string_view Name(InstructionSet set);

}  // namespace haptometer::dsp
