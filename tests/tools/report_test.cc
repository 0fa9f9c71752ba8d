#include <gtest/gtest.h>

#include "tools/cli/terminal.h"

namespace haptometer::cli {
namespace {

TEST(WorseStatus, FailingThenWrongThenNotAnsweredThenAnswered) {
  const int order[] = {130, 1, 2, 3, 0};
  for (int worse = 0; worse < 5; ++worse) {
    for (int better = worse; better < 5; ++better) {
      EXPECT_EQ(WorseStatus(order[worse], order[better]), order[worse]);
      EXPECT_EQ(WorseStatus(order[better], order[worse]), order[worse]);
    }
  }
}

}  // namespace
}  // namespace haptometer::cli
