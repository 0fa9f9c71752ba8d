#include "base/toml.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "base/text.h"

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

constexpr const char* kKey3 = "x.toml:3: names a key of more than 16 parts; correct the TOML there";
constexpr const char* kKey1 = "x.toml:1: names a key of more than 16 parts; correct the TOML there";
constexpr const char* kOpen2 = "x.toml:2: opens more than 16 brackets; correct the TOML there";

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

// a string that is not closed goes on to the end of its line, or of the text
TEST(TomlShape, AStringWithoutItsEndIsLeftToTheParser) {
  const std::string many = Repeated("[{a.", 500);
  for (const std::string& text :
       {"a = \"" + many, "a = '" + many, "a = \"\"\"" + many + "\n\"\"", "a = '''" + many + "\n''",
        "a = \"" + many + "\\", std::string("a = \""), std::string("a = '''")}) {
    EXPECT_EQ(Told(text), "") << text.substr(0, 10);
    const auto table = TomlTable::ParseText(text, "x.toml");
    ASSERT_FALSE(table) << text.substr(0, 10);
    EXPECT_TRUE(table.error().where.starts_with("x.toml:")) << table.error().where;
  }
  for (const char* begin : {"a = \"x\nb = ", "a = 'x\nb = ", "a = ''\nb = ", "a = '\\'\nb = "}) {
    EXPECT_EQ(Told(begin + Repeated("[", 17)), kOpen2) << begin;
  }
}

// of the quotes that end a text of several lines up to two belong to it
TEST(TomlShape, AMultiLineStringEndsWithUpToFiveQuotes) {
  const std::string many = Repeated("[", 17);
  for (const char quote : {'"', '\''}) {
    const std::string begin = "\na = " + std::string(3, quote) + "x";
    for (const std::size_t quotes : {3U, 4U, 5U}) {
      EXPECT_EQ(Told(begin + std::string(quotes, quote) + many), kOpen2) << quotes;
    }
    // a sixth begins a string
    EXPECT_EQ(Told(begin + std::string(6, quote) + many + quote), "");
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

TEST(TomlShape, OneMoreThanTheLimitIsRefused) {
  EXPECT_EQ(Told(Repeated("a.", 16) + "a = 1\n"), kKey1);
  EXPECT_EQ(Told("\na = " + Repeated("[", 17) + Repeated("]", 17)), kOpen2);
  EXPECT_EQ(Told("\na = " + Repeated("{a = ", 17) + "1" + Repeated("}", 17)), kOpen2);
  // what is closed is no longer open, and a surplus bracket opens nothing
  EXPECT_EQ(Told("a = [" + Repeated("[[]],", 40) + "]"), "");
  EXPECT_EQ(Told("]\na = " + Repeated("[", 17)), kOpen2);
}

TEST(TomlShape, ALargeTextIsRefused) {
  EXPECT_EQ(Told(std::string(kMostTomlBytes + 1, '\n')),
            "x.toml: is larger than 1 MiB; is it a TOML file of this program?");
  EXPECT_EQ(Told(std::string(kMostTomlBytes, '\n')), "");
}

TomlTable Parsed(std::string_view text) {
  auto table = TomlTable::ParseText(text, "x.toml");
  EXPECT_TRUE(table) << table.error().Text();
  return std::move(*table);
}

TEST(TomlTable, ReadsNumbersTextsFlagsAndQuantities) {
  TomlTable table = Parsed(R"(
    mass_kg = 1.4e-3
    load = "33ohm"
    count = 3
    on = true
    kind = "sine"
    open = inf)");
  EXPECT_EQ(table.Require("mass_kg", Dimension::kMass), 1.4e-3);  // SI numbers may be bare in files
  EXPECT_EQ(table.Require("load", Dimension::kResistance), 33);
  EXPECT_EQ(table.Integer("count"), 3);
  EXPECT_EQ(table.Flag("on"), true);
  EXPECT_EQ(table.Choice("kind", {"sine", "chirp"}), "sine");
  EXPECT_TRUE(std::isinf(table.Require("open", Dimension::kResistance)));
  EXPECT_EQ(table.Number("absent", Dimension::kTime), std::nullopt);
  EXPECT_TRUE(table.Finish());
}

TEST(TomlTable, UncertaintyComesAlong) {
  TomlTable table = Parsed(R"(moving_mass_kg = "1.40(3)g")");
  const Quantity mass = table.RequireQuantity("moving_mass_kg", Dimension::kMass);
  EXPECT_NEAR(mass.standard_uncertainty, 3e-5, 1e-19);
}

// no uncertainty is invented for a number without one
TEST(TomlTable, ANumberWithoutAnUncertaintyIsExact) {
  TomlTable table = Parsed("a_kg = 1.4e-3\nb_kg = 2\nc_kg = '3g'\n");
  EXPECT_EQ(table.RequireQuantity("a_kg", Dimension::kMass), (Quantity{1.4e-3, 0}));
  EXPECT_EQ(table.RequireQuantity("b_kg", Dimension::kMass), (Quantity{2, 0}));
  EXPECT_EQ(table.RequireQuantity("c_kg", Dimension::kMass), (Quantity{3e-3, 0}));
  EXPECT_TRUE(table.Finish());
}

TEST(TomlTable, ABareNumberHasTheLimitsOfItsDimension) {
  const auto is_read = [](const char* text) {
    TomlTable table = Parsed(text);
    (void)table.Require("a_kg", Dimension::kMass);
    return table.Finish().has_value();
  };
  for (const char* text : {"a_kg = 1e-12", "a_kg = 1e6", "a_kg = -1e6", "a_kg = 0"}) {
    EXPECT_TRUE(is_read(text)) << text;
  }
  for (const char* text : {"a_kg = 0.99e-12", "a_kg = 1.01e6", "a_kg = -1.01e6"}) {
    EXPECT_FALSE(is_read(text)) << text;
  }
}

TEST(TomlTable, ReadsListsOfWholeNumbers) {
  TomlTable table = Parsed("a = [0, -3, 65535]\nnone = []\n");
  EXPECT_EQ(table.Integers("a"), (std::vector<long long>{0, -3, 65535}));
  EXPECT_TRUE(table.Integers("none").empty());
  EXPECT_TRUE(table.Integers("absent").empty());
  EXPECT_TRUE(table.Finish());
  for (const char* text : {"a = [1, 2.5]", "a = 1"}) {
    TomlTable wrong = Parsed(text);
    EXPECT_TRUE(wrong.Integers("a").empty()) << text;
    EXPECT_EQ(wrong.Finish().error().Text(),
              "x.toml:1: a: is not a list of whole numbers; write it as [0, 65535]");
  }
}

TEST(TomlTable, TellsWhatStandsUnderAKey) {
  TomlTable table = Parsed("text = 'a'\nflag = false\nnumber = 1\nlist = []\n[table]\n");
  EXPECT_EQ(table.KindOf("text"), TomlKind::kText);
  EXPECT_EQ(table.KindOf("flag"), TomlKind::kFlag);
  EXPECT_EQ(table.KindOf("number"), TomlKind::kOther);
  EXPECT_EQ(table.KindOf("list"), TomlKind::kOther);
  EXPECT_EQ(table.KindOf("table"), TomlKind::kTable);
  EXPECT_EQ(table.KindOf("absent"), TomlKind::kAbsent);
  EXPECT_TRUE(table.Finish()) << "all of them were asked for";
}

TEST(TomlTable, AnUnknownKeyIsNamedWithTheNearestKnownOne) {
  TomlTable root = Parsed("[skin]\nstifness_n_per_m = 600\n");
  TomlTable* skin = root.Table("skin");
  ASSERT_NE(skin, nullptr);
  EXPECT_EQ(skin->Require("stiffness_n_per_m", Dimension::kStiffness), 0);
  EXPECT_EQ(root.Finish().error().Text(),
            "x.toml:2: [skin]: key stifness_n_per_m is not known; did you mean stiffness_n_per_m?");
  EXPECT_EQ(root.Finish().error().cause, Cause::kUsage);
}

TEST(TomlTable, APartOfAKeyIsNamedWithAllThatHaveIt) {
  const auto told = [](std::string_view text) {
    TomlTable table = Parsed(text);
    for (const char* key : {"moving_mass_kg", "case_mass_kg", "load_ohm"}) (void)table.Has(key);
    return table.Finish().error().Text();
  };
  EXPECT_EQ(told("load = 33"), "x.toml:1: key load is not known; did you mean load_ohm?");
  EXPECT_EQ(told("mass_kg = 1e-3"),
            "x.toml:1: key mass_kg is not known; did you mean case_mass_kg or moving_mass_kg?");
  EXPECT_EQ(told("oad = 33"), "x.toml:1: key oad is not known; remove it") << "no part of its own";
}

TEST(TomlTable, AListOfTablesIsReadInOrderAndStrictly) {
  TomlTable root = Parsed("[[sensor]]\nname = 'a'\n[[sensor]]\nname = 'b'\nprot = 'x'\n");
  const auto sensors = root.Tables("sensor");
  ASSERT_EQ(sensors.size(), 2U);
  EXPECT_EQ(sensors[0]->Text("name"), "a");
  EXPECT_EQ(sensors[1]->Text("name"), "b");
  (void)sensors[1]->Text("port");
  EXPECT_EQ(root.Finish().error().Text(),
            "x.toml:5: [[sensor]] 2: key prot is not known; did you mean port?");
  EXPECT_TRUE(Parsed("").Tables("sensor").empty());
}

TEST(TomlTable, ATableIsNoListOfTables) {
  TomlTable root = Parsed("[sensor]\nname = 'a'\n");
  EXPECT_TRUE(root.Tables("sensor").empty());
  EXPECT_EQ(root.Finish().error().Text(),
            "x.toml:1: sensor: is not a list of tables; write [[sensor]]");
}

TEST(TomlTable, AListThatHoldsSomethingElseIsNoListOfTables) {
  for (const char* text : {"sensor = [1, 2]", "sensor = [{name = 'a'}, 1]", "sensor = 3"}) {
    TomlTable root = Parsed(text);
    EXPECT_TRUE(root.Tables("sensor").empty()) << text;
    EXPECT_EQ(root.Finish().error().Text(),
              "x.toml:1: sensor: is not a list of tables; write [[sensor]]");
  }
}

TEST(TomlTable, AListThatHoldsSomethingElseIsNoListOfTexts) {
  for (const char* text : {"a = ['b', 1]", "a = [1, 'b']", "a = 'b'", "a = [['b']]"}) {
    TomlTable table = Parsed(text);
    EXPECT_TRUE(table.TextList("a").empty()) << text;
    EXPECT_EQ(table.Finish().error().Text(),
              "x.toml:1: a: is not a list of texts; write it as [\"stock\", \"cone\"]");
  }
  for (const char* text :
       {"a = [['b', 1]]", "a = ['b', ['c']]", "a = [['b'], 1, ['c']]", "a = 'b'", "a = [1]"}) {
    TomlTable table = Parsed(text);
    EXPECT_TRUE(table.TextLists("a").empty()) << text;
    EXPECT_EQ(table.Finish().error().Text(),
              "x.toml:1: a: is not a list of lists of texts; write it as [[\"ia1\", \"stock\"]]");
  }
  TomlTable absent = Parsed("");
  EXPECT_TRUE(absent.TextList("a").empty());
  EXPECT_TRUE(absent.Finish());
}

TEST(TomlTable, ReadsListsOfTexts) {
  TomlTable table = Parsed(R"(
    names = ["stock", "cone"]
    pairs = [["ia1", "stock"], ["ia2", "cone"]]
    none = [])");
  EXPECT_EQ(table.TextList("names"), (std::vector<std::string>{"stock", "cone"}));
  EXPECT_EQ(table.TextLists("pairs").at(1), (std::vector<std::string>{"ia2", "cone"}));
  EXPECT_TRUE(table.TextList("none").empty());
  EXPECT_TRUE(table.TextLists("absent").empty());
  EXPECT_TRUE(table.Finish());
  TomlTable mixed = Parsed(R"(pairs = [["ia1"], "stock"])");
  EXPECT_TRUE(mixed.TextLists("pairs").empty());
  EXPECT_NE(mixed.Finish().error().Text().find("pairs: is not a list of lists of texts"),
            std::string::npos);
}

TEST(TomlTable, TextsUnderTheUsersOwnKeys) {
  TomlTable root = Parsed("[labels]\nrig = 'A'\n'any thing' = 'b'\n");
  EXPECT_EQ(root.Texts("labels"),
            (std::map<std::string, std::string>{{"any thing", "b"}, {"rig", "A"}}));
  EXPECT_TRUE(root.Finish());
  EXPECT_TRUE(Parsed("").Texts("labels").empty());
  TomlTable number = Parsed("[labels]\nsubject = 3\n");
  (void)number.Texts("labels");
  EXPECT_EQ(number.Finish().error().Text(),
            "x.toml:2: [labels]: subject: is not a text; put it in quotes");
}

struct Fault {
  const char* toml;
  const char* text;  // of the error
};

class TomlFaults : public ::testing::TestWithParam<Fault> {};

TEST_P(TomlFaults, AreNamed) {
  TomlTable table = Parsed(GetParam().toml);
  (void)table.Number("mass_kg", Dimension::kMass);
  (void)table.Number("load_ohm", Dimension::kResistance);
  (void)table.Flag("on");
  (void)table.Integer("count");
  (void)table.Choice("kind", {"sine", "chirp"});
  (void)table.Table("skin");
  const auto done = table.Finish();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().Text(), GetParam().text);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, TomlFaults,
    ::testing::Values(
        Fault{"mass_kg = true",
              "x.toml:1: mass_kg: is not a number; write an SI number or a string with a unit"},
        Fault{"mass_kg = nan", "x.toml:1: mass_kg: is not a finite number; write an SI number"},
        Fault{"mass_kg = inf", "x.toml:1: mass_kg: is not a finite number; write an SI number"},
        Fault{"load_ohm = nan", "x.toml:1: load_ohm: is not a finite number; write an SI number"},
        Fault{"mass_kg = 2e-310",
              "x.toml:1: mass_kg: '2e-310' is outside the possible range of a mass; its size is 0, "
              "or from 1e-12 to 1000000 kg"},
        Fault{"load_ohm = '4e-200 ohm'",
              "x.toml:1: load_ohm: '4e-200 ohm' is outside the possible range of a resistance; its "
              "size is 0, or from 1e-09 to 1000000000000000 ohm"},
        Fault{"load_ohm = -inf", "x.toml:1: load_ohm: is not a finite number; write an SI number"},
        Fault{"mass_kg = \"3mm\"",
              "x.toml:1: mass_kg: 'mm' is not a unit of a mass; use one of kg, g, mg"},
        Fault{"on = 1", "x.toml:1: on: is neither true nor false; write true or false"},
        Fault{"count = 1.5",
              "x.toml:1: count: is not a whole number; write it without a point or quotes"},
        Fault{"kind = \"saw\"", "x.toml:1: kind: \"saw\" is not known; use one of sine, chirp"},
        Fault{"kind = 3", "x.toml:1: kind: is not a text; put it in quotes"},
        Fault{"skin = 3", "x.toml:1: skin: is not a table; write [skin]"}));

// a text comes to headers, plots and terminals, which no control character may reach
TEST(TomlTable, TextsThatAreNotPrintableAreRefused) {
  TomlTable text = Parsed("name = \"x\\n!touch\"\n");
  EXPECT_FALSE(text.Text("name"));
  EXPECT_EQ(text.Finish().error().Text(),
            "x.toml:1: name: 'x\\n!touch' holds a character that cannot be printed; write it "
            "without control characters, on one line");
  TomlTable list = Parsed("names = [\"a\", \"\\u001b[2J\"]\n");
  EXPECT_TRUE(list.TextList("names").empty());
  EXPECT_FALSE(list.Finish());
  TomlTable lists = Parsed("pairs = [[\"a\", \"b\\r\"]]\n");
  EXPECT_TRUE(lists.TextLists("pairs").empty());
  EXPECT_FALSE(lists.Finish());
  TomlTable keys = Parsed("labels.\"a\\nb\" = \"c\"\n");
  EXPECT_TRUE(keys.Texts("labels").empty());
  EXPECT_FALSE(keys.Finish());
  TomlTable unknown = Parsed("\"evil\\nkey\" = 1\n");
  EXPECT_EQ(unknown.Finish().error().Text().find('\n'), std::string::npos);
}

TEST(TomlTable, MissingAndRefusedValuesAreTold) {
  TomlTable missing = Parsed("");
  EXPECT_EQ(missing.Require("mass_kg", Dimension::kMass), 0);
  EXPECT_EQ(missing.Finish().error().Text(),
            "x.toml: mass_kg: is missing; add it, in kg or with a unit");
  TomlTable refused = Parsed("mass_kg = -1.0");
  if (refused.Require("mass_kg", Dimension::kMass) < 0) {
    refused.Refuse("mass_kg", "must be positive");
  }
  EXPECT_EQ(refused.Finish().error().Text(), "x.toml:1: mass_kg: must be positive");
}

TEST(TomlTable, AWrongValueIsToldBeforeTheKeysThatItLeavesUnread) {
  TomlTable table = Parsed("amplitude = 5\nkind = 'saw'\n");
  EXPECT_FALSE(table.Choice("kind", {"sine", "chirp"}));
  EXPECT_EQ(table.Finish().error().Text(),
            "x.toml:2: kind: \"saw\" is not known; use one of sine, chirp");
  // but a missing key after the unknown one that may be it
  TomlTable missing = Parsed("[drive]\nfrequenzy_hz = 5\n");
  TomlTable* drive = missing.Table("drive");
  (void)drive->Require("frequency_hz", Dimension::kFrequency);
  EXPECT_EQ(missing.Finish().error().Text(),
            "x.toml:2: [drive]: key frequenzy_hz is not known; did you mean frequency_hz?");
}

TEST(TomlTable, AMissingKeyIsPlacedAtItsTable) {
  TomlTable table = Parsed("# scene\n[drive]\nkind = 'sine'\n");
  TomlTable* drive = table.Table("drive");
  (void)drive->Text("kind");
  (void)drive->Require("frequency_hz", Dimension::kFrequency);
  EXPECT_EQ(table.Finish().error().Text(),
            "x.toml:2: [drive]: frequency_hz: is missing; add it, in Hz or with a unit");
}

TEST(TomlTable, BrokenTomlIsPlacedByLineAndColumn) {
  for (const char* text : {"a = \n", "[\n", "\"\n", "a = 0x\n"}) {
    const auto table = TomlTable::ParseText(text, "x.toml");
    ASSERT_FALSE(table) << text;
    EXPECT_EQ(table.error().cause, Cause::kCannotAnswer);
    EXPECT_TRUE(table.error().where.starts_with("x.toml:")) << table.error().where;
  }
  // what is given twice is a mistake of use, as a wrong key is
  for (const char* text : {"a = 1\na = 2\n", "[b]\nc = 1\n[b]\nd = 1\n"}) {
    const auto table = TomlTable::ParseText(text, "x.toml");
    ASSERT_FALSE(table) << text;
    EXPECT_EQ(table.error().cause, Cause::kUsage) << text;
    EXPECT_TRUE(table.error().where.starts_with("x.toml:")) << table.error().where;
  }
}

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
