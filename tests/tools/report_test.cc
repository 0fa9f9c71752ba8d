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

TEST(WithOptions, SaysTheOptionOfASetting) {
  EXPECT_EQ(WithOptions("<columns>: names 2; say <rate> or leave <columns> out"),
            "--columns: names 2; say --rate or leave --columns out");
  EXPECT_EQ(WithOptions("try <baud> 9600", ""), "try baud 9600") << "a key of a file";
  for (const char* same : {"a < b > c", "<html>", "<rate", "rate>", "<", "", "<<rates>>"}) {
    EXPECT_EQ(WithOptions(same), same);
  }
}

}  // namespace
}  // namespace haptometer::cli
