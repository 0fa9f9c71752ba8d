#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace haptometer::trial {

/// CRC-32 as in zlib, PNG and Ethernet (polynomial 0xEDB88320, start and final xor 0xFFFFFFFF).
///
/// Of 64 bytes and more, where the processor multiplies without carries, the message is folded
/// modulo the polynomial (V. Gopal et al., Fast CRC Computation for Generic Polynomials Using
/// PCLMULQDQ Instruction, Intel 2009), of 256 bytes and more in lanes four times as wide where it
/// can; zlib does the rest, and everything elsewhere. Cost: 15 or 70 ps a byte from the cache,
/// zlib's 150 ps.
[[nodiscard]] std::uint32_t Crc32(std::span<const std::byte> bytes);

}  // namespace haptometer::trial
