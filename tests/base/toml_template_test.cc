#include "base/toml_template.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/printable.h"
#include "base/toml_table.h"

namespace haptometer {
namespace {

using ::testing::HasSubstr;

TomlTemplate Opened(std::string_view text, const std::vector<std::string>& keys) {
  auto made = TomlTemplate::ParseText(text, "x.toml", keys);
  EXPECT_TRUE(made) << made.error().Text();
  return *std::move(made);
}

TomlTable Filled(const TomlTemplate& made, const std::vector<std::string>& literals) {
  auto table = TomlTable::ParseText(made.Fill(literals), "x.toml");
  EXPECT_TRUE(table) << table.error().Text() << "\n" << made.Fill(literals);
  return *std::move(table);
}

TEST(TomlTemplate, FillsOpenKeysAndKeepsTheRest) {
  const TomlTemplate made = Opened(
      "title = 'x' # said\n[drive]\nfrequency_hz = 225\nkind = \"sine\"\n[run]\nstart = 'rest'\n",
      {"run.duration_s", "drive.frequency_hz", "effects.gravity"});
  for (const double hertz : {1.0, 2.5}) {
    TomlTable table = Filled(made, {"0.1", hertz == 1 ? "1" : "2.5", "true"});
    EXPECT_EQ(table.Text("title"), "x");
    EXPECT_EQ(table.Table("drive")->Number("frequency_hz", Dimension::kFrequency), hertz);
    EXPECT_EQ(table.Table("drive")->Text("kind"), "sine");
    EXPECT_EQ(table.Table("run")->Number("duration_s", Dimension::kTime), 0.1);
    EXPECT_EQ(table.Table("run")->Text("start"), "rest");
    EXPECT_EQ(table.Table("effects")->Flag("gravity"), true);
    EXPECT_TRUE(table.Finish());
  }
}

// 17 digits give back every double; the extremes, and numbers that 15 or 16 digits would change
TEST(TomlTemplate, KeepsEveryBitOfNumbers) {
  const std::string text =
      "a = 0.1\nb = 1.0000000000000002e-30\nc = 9.9999999999999988e29\nd = 0.30000000000000004\ne "
      "= inf\n"
      "f = 9007199254740993\ng = 123456789.12345679\n";
  TomlTable table = Filled(Opened(text, {"open"}), {"1"});
  EXPECT_EQ(table.Number("a", Dimension::kNone), 0.1);
  EXPECT_EQ(table.Number("b", Dimension::kNone), 1.0000000000000002e-30);
  EXPECT_EQ(table.Number("c", Dimension::kNone), 9.9999999999999988e29);
  EXPECT_EQ(table.Number("d", Dimension::kNone), 0.1 + 0.2);
  EXPECT_TRUE(std::isinf(table.Require("e", Dimension::kResistance)));
  EXPECT_EQ(table.Integer("f"), 9007199254740993);
  EXPECT_EQ(table.Number("g", Dimension::kNone), 123456789.12345679);
}

TEST(TomlTemplate, TakesAnyTextAsAString) {
  const TomlTemplate made = Opened("a = 1\n", {"b"});
  for (const std::string text : {"plain", "\"quoted\" 'twice'", "back\\slash", "\xc2\xb5m", ""}) {
    EXPECT_EQ(Filled(made, {TomlString(text)}).Text("b"), text);
  }
  // what the table refuses came through as it was
  for (const std::string text : {"tab\tline\nend", "\x01\x7f"}) {
    TomlTable table = Filled(made, {TomlString(text)});
    EXPECT_FALSE(table.Text("b"));
    EXPECT_NE(table.Finish().error().Text().find(Printable(text)), std::string::npos) << text;
  }
}

// neither a text of the file that looks like a mark nor ten keys and more are confused
TEST(TomlTemplate, TellsItsPlacesFromTexts) {
  std::vector<std::string> keys;
  std::vector<std::string> literals;
  for (int k = 0; k < 12; ++k) {
    keys.push_back("t.k" + std::to_string(k));
    literals.push_back(std::to_string(100 + k));
  }
  TomlTable table = Filled(Opened("a = 'open_place_0_'\nb = 'open_place_'\n", keys), literals);
  EXPECT_EQ(table.Text("a"), "open_place_0_");
  EXPECT_EQ(table.Text("b"), "open_place_");
  for (int k = 0; k < 12; ++k) {
    EXPECT_EQ(table.Table("t")->Integer("k" + std::to_string(k)), 100 + k);
  }
}

TEST(TomlTemplate, NamesTheTextsThatStay) {
  const TomlTemplate made = Opened(
      "[a]\nfile = 'x.toml'\nn = 1\n[[b]]\nfiles = ['y', 'z']\n[c]\nkind = 'k'\n", {"c.kind"});
  EXPECT_THAT(made.texts(), ::testing::UnorderedElementsAre("x.toml", "y", "z"));
}

TEST(TomlTemplate, RefusesWhatIsNoKey) {
  const auto error = [](std::string_view text, const std::vector<std::string>& keys) {
    const auto made = TomlTemplate::ParseText(text, "x.toml", keys);
    return made ? std::string("no error") : made.error().Text();
  };
  EXPECT_THAT(error("a = 1\nb = \n", {"a"}), HasSubstr("x.toml:2:"));
  EXPECT_THAT(error("a = 1\n", {"a.b"}), HasSubstr("a.b: leads through a, which is not a table"));
  EXPECT_THAT(error("a = 1\n", {"a."}), HasSubstr("a.: is not a key"));
  EXPECT_THAT(error("a = 1\n", {".a"}), HasSubstr("is not a key"));
  EXPECT_THAT(error("a = 1\n", {"a", "b", "a"}), HasSubstr("a: is given twice"));
  EXPECT_THAT(error("", {"a.b", "a"}), HasSubstr("a.b: lies within a"));
  EXPECT_THAT(error("", {"a", "a.b"}), HasSubstr("a.b: lies within a"));
  EXPECT_EQ(error("", {"a", "ab"}), "no error");
}

}  // namespace
}  // namespace haptometer
