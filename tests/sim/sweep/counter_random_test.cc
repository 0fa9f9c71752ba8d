#include "sim/sweep/counter_random.h"

#include <gtest/gtest.h>

namespace haptometer::sim {
namespace {

using Words = std::array<std::uint32_t, 4>;

// the known answers of philox4x32-10 in Random123 1.x, tests/kat_vectors (Salmon et al.)
TEST(CounterRandom, GivesThePublishedAnswers) {
  constexpr std::uint32_t kAll = 0xffffffff;
  EXPECT_EQ(CounterRandom({0, 0, 0, 0}, 0),
            (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(CounterRandom({kAll, kAll, kAll, kAll}, 0xffffffffffffffff),
            (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  // digits of pi; the key's first word is its lower half
  EXPECT_EQ(CounterRandom({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, 0x299f31d0a4093822),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

}  // namespace
}  // namespace haptometer::sim
