#include "base/error.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace haptometer {
namespace {

// a file and line below the root of the sources, whatever folder they were built in
TEST(CheckDeathTest, NamesThePlaceWithoutThePathOfTheBuild) {
  const double rate_hz = -2;
  EXPECT_DEATH(HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz),
               "^tests/base/error_test.cc:[0-9]+: check failed: rate_hz > 0 \\(rate_hz = -2\\)");
}

// as the compiler was called from the sources or from a folder of the build
TEST(CheckDeathTest, NamesAFileFromWhereverItWasCompiled) {
  const std::string fixtures = HAPTOMETER_FIXTURES;
  const std::string root = fixtures.substr(0, fixtures.rfind("fixtures"));
  const std::pair<std::string, const char*> kFiles[]{
      {root + "base/x.cc", "^base/x.cc:7: check failed: a > b \\(c\\\\nd\\)"},
      {"../../base/x.cc", "^base/x.cc:7: "},
      {"../base/../x.cc", "^base/../x.cc:7: "},
      {root + "../x.cc", "^x.cc:7: "},
      {"base/x.cc", "^base/x.cc:7: "},
      {"/another" + root + "base/x.cc", "^/another.*/base/x.cc:7: "}};
  for (const auto& [file, text] : kFiles) {
    EXPECT_DEATH(internal::CheckFailed(file.c_str(), 7, "a > b", "c\nd"), text) << file;
  }
}

TEST(Check, PassesWhatHolds) { HAPTOMETER_CHECK(true, "{}", 1); }

TEST(Error, TextJoinsWhereWhatAndRemedy) {
  EXPECT_EQ((Error{Cause::kFailed, "a.csv", "is empty", "record again"}).Text(),
            "a.csv: is empty; record again");
  EXPECT_EQ((Error{Cause::kFailed, "a.csv", "is empty", ""}).Text(), "a.csv: is empty");
  EXPECT_EQ((Error{Cause::kFailed, "", "no answer", "wait"}).Text(), "no answer; wait");
  EXPECT_EQ((Error{Cause::kFailed, "", "no answer", ""}).Text(), "no answer");
}

TEST(Error, CauseDecidesTheExitStatus) {
  EXPECT_EQ(ExitStatus(Failed("", "").error().cause), 1);
  EXPECT_EQ(ExitStatus(Usage("", "").error().cause), 2);
  EXPECT_EQ(ExitStatus(CannotAnswer("", "").error().cause), 3);
}

TEST(CheckDeathTest, PrintsTheExpressionAndTheValues) {
  const double rate_hz = -3;
  EXPECT_DEATH(HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz),
               "check failed: rate_hz > 0 \\(rate_hz = -3\\)");
}

}  // namespace
}  // namespace haptometer
