#include "base/instruction_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace haptometer {
namespace {

TEST(InstructionSet, ALimitLowersItAndNeverRaisesIt) {
  EXPECT_EQ(WidestInstructionSet("sse2"), InstructionSet::kBaseline);
  for (const InstructionSet set : kInstructionSets) {
    const InstructionSet widest = WidestInstructionSet(Name(set));
    EXPECT_LE(widest, set) << Name(set);
    EXPECT_TRUE(IsSupported(widest)) << Name(set);
    if (IsSupported(set)) {
      EXPECT_EQ(widest, set) << Name(set);
    }
  }
}

TEST(InstructionSet, OtherTextsLimitNothing) {
  const InstructionSet widest = WidestInstructionSet("avx512");
  for (const char* text : {"", "avx", "AVX2", " sse2", "sse2 ", "0"}) {
    EXPECT_EQ(WidestInstructionSet(text), widest) << text;
  }
}

// each in a process of its own, because the environment is read once
TEST(InstructionSetDeathTest, ProcessesObeyTheEnvironment) {
  for (const InstructionSet set : kInstructionSets) {
    const std::string limit(Name(set));
    EXPECT_EXIT(
        {
          setenv("HAPTOMETER_INSTRUCTION_SET", limit.c_str(), 1);
          std::_Exit(UsableInstructionSet() == WidestInstructionSet(limit) ? 0 : 1);
        },
        testing::ExitedWithCode(0), "")
        << limit;
  }
}

}  // namespace
}  // namespace haptometer
