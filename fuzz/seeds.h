#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

// of libFuzzer
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace haptometer::fuzz {

/// A mutation for LLVMFuzzerCustomMutator that begins from valid texts: one of `seeds` in place of
/// an input that is next to nothing, now and then in place of any, and libFuzzer's own mutation of
/// all others. The input begins with `ahead` bytes that are no text.
inline std::size_t MutateFromSeeds(std::span<const std::string_view> seeds, std::size_t ahead,
                                   std::span<std::uint8_t> data, std::size_t size,
                                   unsigned random) {
  constexpr unsigned kOneIn = 64;
  if (size >= ahead + 8 && random % kOneIn != 0) {
    return LLVMFuzzerMutate(data.data(), size, data.size());
  }
  if (data.size() < ahead) return size;
  std::fill_n(data.begin(), ahead, std::uint8_t{0});
  if (ahead > 0) data[0] = static_cast<std::uint8_t>(random / kOneIn % seeds.size());
  const std::string_view seed = seeds[random / kOneIn % seeds.size()];
  const std::size_t length = std::min(seed.size(), data.size() - ahead);
  std::memcpy(data.data() + ahead, seed.data(), length);
  return ahead + length;
}

}  // namespace haptometer::fuzz
