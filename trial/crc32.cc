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

// x^n modulo the polynomial, bits reflected and shifted by one: x^(n + 32) and x^(n - 32) move the
// halves of a lane on by n bits
constexpr std::int64_t Power(int n) {
  std::uint32_t power = 0x8000'0000;
  for (int k = 0; k < n; ++k) power = (power >> 1U) ^ ((power & 1U) != 0 ? 0xedb8'8320 : 0);
  return static_cast<std::int64_t>(power) << 1U;
}
static_assert(Power(512 + 32) == 0x1'5444'2bd4 && Power(512 - 32) == 0x1'c6e4'1596,
              "Gopal et al., table for the gzip CRC");

// 64 bytes and more, begun from `start`
[[gnu::target("pclmul,sse4.1")]] std::uint32_t ByFolding(std::uint32_t start,
                                                         std::span<const std::byte> bytes) {
  const __m128i by_512 = _mm_set_epi64x(Power(512 - 32), Power(512 + 32));
  const __m128i by_128 = _mm_set_epi64x(Power(128 - 32), Power(128 + 32));
  __m128i lanes[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = Load(&bytes[k * kLane]);
  lanes[0] = _mm_xor_si128(lanes[0], _mm_cvtsi32_si128(static_cast<int>(start)));
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

constexpr std::size_t kWideLane = 64;

[[gnu::target("vpclmulqdq,avx512f")]] inline __m512i LoadWide(const std::byte* bytes) {
  return _mm512_loadu_si512(bytes);
}

// the same of 256 bytes and more, four times as wide
[[gnu::target("vpclmulqdq,avx512f")]] std::uint32_t ByWideFolding(
    std::uint32_t start, std::span<const std::byte> bytes) {
  constexpr std::int64_t kLow = Power(2048 + 32);
  constexpr std::int64_t kHigh = Power(2048 - 32);
  const __m512i by_2048 = _mm512_set4_epi64(kHigh, kLow, kHigh, kLow);
  __m512i lanes[kLanes];
  for (std::size_t k = 0; k < kLanes; ++k) lanes[k] = LoadWide(&bytes[k * kWideLane]);
  const __m512i begin = _mm512_zextsi128_si512(_mm_cvtsi32_si128(static_cast<int>(start)));
  lanes[0] = _mm512_xor_si512(lanes[0], begin);
  bytes = bytes.subspan(kLanes * kWideLane);
  for (; bytes.size() >= kLanes * kWideLane; bytes = bytes.subspan(kLanes * kWideLane)) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const __m512i low = _mm512_clmulepi64_epi128(lanes[k], by_2048, 0x00);
      const __m512i high = _mm512_clmulepi64_epi128(lanes[k], by_2048, 0x11);
      const __m512i next = LoadWide(&bytes[k * kWideLane]);
      lanes[k] = _mm512_xor_si512(_mm512_xor_si512(low, high), next);
    }
  }
  std::array<std::byte, kLanes * kWideLane> rest;
  for (std::size_t k = 0; k < kLanes; ++k) _mm512_storeu_si512(&rest[k * kWideLane], lanes[k]);
  return ByZlib(ByFolding(0, rest), bytes);
}

}  // namespace

std::uint32_t Crc32(std::span<const std::byte> bytes) {
  static const bool folds_widely =
      __builtin_cpu_supports("vpclmulqdq") != 0 && __builtin_cpu_supports("avx512f") != 0;
  static const bool folds =
      __builtin_cpu_supports("pclmul") != 0 && __builtin_cpu_supports("sse4.1") != 0;
  if (folds_widely && bytes.size() >= kLanes * kWideLane) return ByWideFolding(kOnes, bytes);
  if (folds && bytes.size() >= kLanes * kLane) return ByFolding(kOnes, bytes);
  return ByZlib(0, bytes);
}

}  // namespace haptometer::trial
