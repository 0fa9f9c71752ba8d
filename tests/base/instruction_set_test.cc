#include "base/instruction_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <set>
#include <sstream>
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

#ifdef __x86_64__
// what the system states of its first processor; empty where it has no such list
std::set<std::string> ProcessorFlags() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("flags")) continue;
    std::istringstream words(line);
    return {std::istream_iterator<std::string>(words), {}};
  }
  return {};
}

TEST(InstructionSet, IsSupportedWhereTheSystemListsAllOfItsFlags) {
  const std::set<std::string> flags = ProcessorFlags();
  if (flags.empty()) GTEST_SKIP() << "no list of flags";
  const auto has = [&](std::initializer_list<const char*> names) {
    return std::ranges::all_of(names, [&](const char* name) { return flags.contains(name); });
  };
  EXPECT_TRUE(IsSupported(InstructionSet::kBaseline));
  EXPECT_EQ(IsSupported(InstructionSet::kAvx2), has({"avx2", "pclmulqdq"}));
  EXPECT_EQ(IsSupported(InstructionSet::kAvx512),
            has({"avx512f", "avx512dq", "avx512vl", "avx512bw"}));
}
#else
TEST(InstructionSet, OfOtherProcessorsOnlyTheBaselineIsSupported) {
  for (const InstructionSet set : kInstructionSets) {
    EXPECT_EQ(IsSupported(set), set == InstructionSet::kBaseline) << Name(set);
  }
}
#endif

TEST(InstructionSetDeathTest, AnotherOneIsAnErrorOfTheProgrammer) {
  const auto none = static_cast<InstructionSet>(3);
  EXPECT_DEATH((void)Name(none), "value 3 of 3");
#ifdef __x86_64__
  EXPECT_DEATH((void)IsSupported(none), "instruction set 3");
#endif
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
