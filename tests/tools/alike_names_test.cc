#include "tools/study/alike_names.h"

#include <gtest/gtest.h>

#include <utility>

namespace haptometer::tools {
namespace {

TEST(LikenessOf, IsOfCaseBlanksAndOneLetter) {
  using enum Likeness;
  EXPECT_EQ(LikenessOf("Stock", "sto ck"), kSpelling);
  EXPECT_EQ(LikenessOf("2", "02"), kSpelling);
  EXPECT_EQ(LikenessOf("pad7", "pad007"), kSpelling);
  for (const auto& [one, other] :
       {std::pair("cone", "cones"), std::pair("adapter", "adaptor"), std::pair("Cone", "cony"),
        std::pair("stock", "tock"), std::pair("left pad", "lef pad")}) {
    EXPECT_EQ(LikenessOf(one, other), kOneLetter) << one;
    EXPECT_EQ(LikenessOf(other, one), kOneLetter) << other;
  }
  for (const auto& [one, other] :
       {std::pair("cone", "cone"), std::pair("a", "b"), std::pair("1", "11"),
        std::pair("ia1", "ia2"), std::pair("s1", "s11"), std::pair("rig a", "rig b"),
        std::pair("padA", "padB"), std::pair("pad", "padB"), std::pair("cone", "stock"),
        std::pair("on", "off"), std::pair("100", "10"), std::pair("20", "200"),
        std::pair("left", "right"), std::pair("", "abc")}) {
    EXPECT_EQ(LikenessOf(one, other), kNone) << one << ", " << other;
    EXPECT_EQ(LikenessOf(other, one), kNone) << one << ", " << other;
  }
  const auto alike = NamesAlike({"cone", "stock", "cones", "Stock"});
  ASSERT_EQ(alike.size(), 2U);
  EXPECT_EQ(alike[0].other, "cones");
  EXPECT_EQ(alike[1].likeness, kSpelling);
}

TEST(StudyLabelLike, IsTheLabelThatWasMeant) {
  for (const char* label : {"subjct", "Subject", "subjects", " subject"}) {
    EXPECT_EQ(StudyLabelLike(label), "subject") << label;
  }
  EXPECT_EQ(StudyLabelLike("conditon"), "condition");
  for (const char* label : {"subject", "condition", "repeat", "rig", "position", "object"}) {
    EXPECT_EQ(StudyLabelLike(label), "") << label;
  }
  ::testing::internal::CaptureStderr();
  RemarkOnLabels("acquire", {{"rig", "2"}, {"subjct", "3"}});
  EXPECT_EQ(
      ::testing::internal::GetCapturedStderr(),
      "acquire: doubt: the label subjct is kept, and no study reads it: was subject meant?\n");
}

}  // namespace
}  // namespace haptometer::tools
