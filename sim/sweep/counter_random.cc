#include "sim/sweep/counter_random.h"

namespace haptometer::sim {
namespace {

// Salmon et al. 2011, section 4.3
constexpr std::uint64_t kMultiplier0 = 0xD2511F53;
constexpr std::uint64_t kMultiplier1 = 0xCD9E8D57;
constexpr std::uint32_t kWeyl0 = 0x9E3779B9;
constexpr std::uint32_t kWeyl1 = 0xBB67AE85;
constexpr int kRounds = 10;

std::uint32_t Upper(std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32U); }
std::uint32_t Lower(std::uint64_t word) { return static_cast<std::uint32_t>(word); }

}  // namespace

std::array<std::uint32_t, 4> CounterRandom(const std::array<std::uint32_t, 4>& counter,
                                           std::uint64_t key) {
  std::array<std::uint32_t, 4> word = counter;
  std::uint32_t key0 = Lower(key);
  std::uint32_t key1 = Upper(key);
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t product0 = kMultiplier0 * word[0];
    const std::uint64_t product1 = kMultiplier1 * word[2];
    word = {Upper(product1) ^ word[1] ^ key0, Lower(product1), Upper(product0) ^ word[3] ^ key1,
            Lower(product0)};
    key0 += kWeyl0;
    key1 += kWeyl1;
  }
  return word;
}

}  // namespace haptometer::sim
