#include "base/nearest.h"

#include <gtest/gtest.h>

namespace haptometer {
namespace {

TEST(Nearest, FindsTheWordThatWasMeant) {
  const std::vector<std::string> keys{"stiffness_n_per_m", "damping_n_s_per_m", "resistance_ohm"};
  EXPECT_EQ(Nearest("stifness_n_per_m", keys), "stiffness_n_per_m");
  EXPECT_EQ(Nearest("resistence_ohms", keys), "resistance_ohm");
}

TEST(Nearest, KnowsTheDistanceOfTheTextbook) {
  // kitten -> sitting is 3 (Levenshtein): as near as half of six letters allows, and not 4
  EXPECT_EQ(Nearest("kitten", {"sitting"}), "sitting");
  EXPECT_EQ(Nearest("kitten", {"mutton's"}), "");
}

TEST(Nearest, SaysNothingWhereNothingIsNear) {
  EXPECT_EQ(Nearest("xyz", {"stiffness", "damping"}), "");
  EXPECT_EQ(Nearest("xyz", {}), "");
}

}  // namespace
}  // namespace haptometer
