#include "trial/crc32.h"

#include <immintrin.h>
#include <zlib.h>

#include <array>

namespace haptometer::trial {
namespace {

constexpr std::size_t kLane = 16;
constexpr std::size_t kLanes = 4;
constexpr std::uint32_t kOnes = 0xffff'ffff;

// goes on from `crc`, that of the bytes before
std::uint32_t ByZlib(std::uint32_t crc, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

[[gnu::target("pclmul,sse4.1")]] inline __m128i Load(const std::byte* bytes) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
}

// `lane` moved on by as many bits as `powers` say, plus `next`
[[gnu::target("pclmul,sse4.1")]] inline __m128i Folded(__m128i lane, __m128i powers, __m128i next) {
  const __m128i low = _mm_clmulepi64_si128(lane, powers, 0x00);
  const __m128i high = _mm_clmulepi64_si128(lane, powers, 0x11);
  return _mm_xor_si128(_mm_xor_si128(low, high), next);
}

// 64 bytes and more: x^(n + 32) and x^(n - 32) modulo the polynomial, bits reflected and shifted by
// one, move a lane on by n bits (Gopal et al., table for the gzip CRC)
[[gnu::target("pclmul,sse4.1")]] std::uint32_t ByFolding(std::span<const std::byte> bytes) {
  const __m128i by_512 = _mm_set_epi64x(0x1'c6e4'1596, 0x1'5444'2bd4);
  const __m128i by_128 = _mm_set_epi64x(0x0'ccaa'009e, 0x1'7519'97d0);
  __m128i lanes[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = Load(&bytes[k * kLane]);
  lanes[0] = _mm_xor_si128(lanes[0], _mm_cvtsi32_si128(-1));
  bytes = bytes.subspan(kLanes * kLane);
  for (; bytes.size() >= kLanes * kLane; bytes = bytes.subspan(kLanes * kLane)) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      lanes[k] = Folded(lanes[k], by_512, Load(&bytes[k * kLane]));
    }
  }
  __m128i folded = lanes[0];
  for (std::size_t k = 1; k < kLanes; ++k) folded = Folded(folded, by_128, lanes[k]);
  std::array<std::byte, kLane> rest;
  _mm_storeu_si128(reinterpret_cast<__m128i*>(rest.data()), folded);
  // the start is in them already: begun from 0, which zlib calls the CRC of all ones
  return ByZlib(ByZlib(kOnes, rest), bytes);
}

}  // namespace

std::uint32_t Crc32(std::span<const std::byte> bytes) {
  static const bool folds =
      __builtin_cpu_supports("pclmul") != 0 && __builtin_cpu_supports("sse4.1") != 0;
  return folds && bytes.size() >= kLanes * kLane ? ByFolding(bytes) : ByZlib(0, bytes);
}

}  // namespace haptometer::trial
