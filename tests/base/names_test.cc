#include "base/names.h"

#include <gtest/gtest.h>

namespace haptometer {
namespace {

enum class Colour { kRed, kGreen };
constexpr Names<Colour, 2> kColours{{"red", "green"}};

TEST(Names, GoBothWays) {
  EXPECT_EQ(kColours.Of(Colour::kGreen), "green");
  EXPECT_EQ(kColours.From("red"), Colour::kRed);
  EXPECT_EQ(kColours.From("blue"), std::nullopt);
}

TEST(NamesDeathTest, KnowOnlyTheirValues) {
  EXPECT_DEATH((void)kColours.Of(static_cast<Colour>(2)), "value 2 of 2");
}

}  // namespace
}  // namespace haptometer
