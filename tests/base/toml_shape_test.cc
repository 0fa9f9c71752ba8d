#include "base/toml_shape.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <string>

#include "base/toml_table.h"
#include "base/toml_template.h"

namespace haptometer {
namespace {

std::string Repeated(std::string_view piece, int times) {
  std::string text;
  for (int k = 0; k < times; ++k) text += piece;
  return text;
}

// what the gate says of a text; empty: nothing
std::string Told(std::string_view text) {
  const auto shape = CheckTomlShape(text, "x.toml");
  return shape ? "" : shape.error().Text();
}

struct Deep {
  const char* name;
  std::string text;
  const char* told;
};

class DeepToml : public ::testing::TestWithParam<Deep> {};

// a parser that calls itself for each level runs out of stack with them
TEST_P(DeepToml, IsRefusedWithItsLineByEveryReader) {
  const Deep& deep = GetParam();
  EXPECT_EQ(Told(deep.text), deep.told);
  const auto table = TomlTable::ParseText(deep.text, "x.toml");
  ASSERT_FALSE(table);
  EXPECT_EQ(table.error().Text(), deep.told);
  EXPECT_EQ(table.error().cause, Cause::kCannotAnswer);
  const auto made = TomlTemplate::ParseText(deep.text, "x.toml", {"drive.frequency_hz"});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().Text(), deep.told);
}

constexpr const char* kKey3 = "x.toml:3: names a key of more than 16 parts; mend the TOML there";
constexpr const char* kKey1 = "x.toml:1: names a key of more than 16 parts; mend the TOML there";
constexpr const char* kOpen2 = "x.toml:2: opens more than 16 brackets; mend the TOML there";

INSTANTIATE_TEST_SUITE_P(
    Kinds, DeepToml,
    ::testing::Values(Deep{"Key", "# a\nb = 1\n" + Repeated("a.", 70000) + "a = 1\n", kKey3},
                      Deep{"KeyWithBlanks", "\n\n" + Repeated("a . ", 50000) + "a = 1\n", kKey3},
                      Deep{"KeyOfQuotedParts", "\n\n" + Repeated("'a'.\"b\".", 30000) + "a = 1\n",
                           kKey3},
                      Deep{"Header", "[" + Repeated("t.", 55000) + "t]\n", kKey1},
                      Deep{"HeaderOfTables", "[[" + Repeated("t.", 55000) + "t]]\n", kKey1},
                      Deep{"KeyInATable", "a = {" + Repeated("t.", 55000) + "t = 1}\n", kKey1},
                      Deep{"Lists", "\na = " + Repeated("[", 90000), kOpen2},
                      Deep{"InlineTables", "\na = " + Repeated("{a = ", 40000), kOpen2},
                      Deep{"ListsOfTables", "\na = " + Repeated("[{a = ", 40000), kOpen2},
                      Deep{"BehindAMultiLineString",
                           "a = ''' '\n\\''' \nb." + Repeated("c.", 60000) + "d = 1\n", kKey3},
                      Deep{"BehindAnEscape",
                           "a = \"\\\\\"\nb = '\\'\n" + Repeated("c.", 60000) + "d = 1\n", kKey3}),
    [](const auto& at) { return std::string(at.param.name); });

TEST(TomlShape, BracketsAndPointsInStringsAndCommentsDoNotCount) {
  const std::string many = Repeated("[{a.", 500);
  for (const std::string& text :
       {"# " + many + "\na = 1\n", "a = \"" + many + "\"\n", "a = '" + many + "'\n",
        "a = \"\"\"" + many + "\n\" \"\" \\\"\"\" " + many + "\"\"\"\n",
        "a = '''" + many + "\n'' \\''''\nb = 2 # '" + many, "a = \"\\\"" + many + "\"\n",
        "a = \"\" # " + many, "\"" + many + "\" = 1\n"}) {
    EXPECT_EQ(Told(text), "") << text.substr(0, 40);
    EXPECT_TRUE(TomlTable::ParseText(text, "x.toml")) << text.substr(0, 40);
  }
}

TEST(TomlShape, WhatIsAtTheLimitIsRead) {
  EXPECT_TRUE(TomlTable::ParseText(Repeated("a.", 15) + "a = 1\n", "x.toml"));
  EXPECT_TRUE(TomlTable::ParseText("a = " + Repeated("[", 16) + Repeated("]", 16), "x.toml"));
  EXPECT_TRUE(TomlTable::ParseText("a = [" + Repeated("[0.5, 1.5],\n", 5000) + "]", "x.toml"))
      << "many in a row are not deep";
  EXPECT_TRUE(TomlTable::ParseText(Repeated("[[a.b]]\nc = 1.5\n", 5000), "x.toml"));
  std::string flat;
  for (int k = 0; k < 60000; ++k) flat += fmt::format("k{} = 1\n", k);
  EXPECT_TRUE(TomlTable::ParseText(flat, "x.toml"));
}

TEST(TomlShape, ALargeTextIsRefused) {
  EXPECT_EQ(Told(std::string(kMostTomlBytes + 1, '\n')),
            "x.toml: is larger than 1 MiB; is it a TOML file of this program?");
  EXPECT_EQ(Told(std::string(kMostTomlBytes, '\n')), "");
}

}  // namespace
}  // namespace haptometer
