#include "tools/cli/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/band.h"
#include "tests/residual.h"
#include "tests/tools/captured.h"
#include "tools/cli/shared_options.h"

namespace haptometer::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using tools::Outcome;

// what the sample verb is asked
struct Words {
  std::optional<double> drop_m;
  double pad_m = 15e-3, low_hz = 20, high_hz = 500,
         limit_m = std::numeric_limits<double>::infinity(), part = 0;
  std::optional<Quantity> mass_kg;
  std::size_t values = 20;
  std::string skin = "text", output, note;
  bool all = false, status = false;
  std::vector<std::string> labels, files;
  std::vector<std::vector<std::string>> loads;
} words;

int Sample(int argc, const char* const* argv) {
  words = {};
  Options options({.name = "sample", .summary = "A sample.", .examples = {"one", "two", "three"}});
  options.Number("--drop", &words.drop_m, Dimension::kLength, Above(0), "Height of the drop");
  options.Number("--pad", &words.pad_m, Dimension::kLength, Within(0, 1), "Side").Rare();
  options.Number("--mass", &words.mass_kg, Dimension::kMass, AtLeast(1e-3), "Moving mass");
  options.Number("--limit", &words.limit_m, Dimension::kLength, Bounds{.most = 2e-3}, "Limit");
  options.Number("--part", &words.part, Dimension::kNone, {.least = 0, .most = 1, .is_below = true},
                 "Part");
  options.Range("--band", &words.low_hz, &words.high_hz, Dimension::kFrequency, Above(0), "Band");
  options.Count("--values", &words.values, 1, 60, "Values");
  options.Choice("--skin", &words.skin, {"text", "table"}, "Law");
  options.Parsed(
      "--note", "TEXT",
      [](const std::string& text) -> Result<void> {
        words.note = text;
        return text == "bad" ? Usage("--note", "is bad", "write another") : Result<void>{};
      },
      "A note");
  options.Output("-o,--output", &words.output, "FILE", "Write it");
  options.Flag("--all", &words.all, "All");
  options.Repeated("--label", &words.labels, "KEY=VALUE", "A label").Known({"subject"});
  options.Groups("--load", &words.loads, "OHM FILE...", "Records");
  options.OptionalText("--status", &words.status, &words.note, "SOCKET", "Status");
  options.Positionals("files", &words.files, "Trials", 0);
  options.Exclude("--band", {"--drop", "--note"}, "they measure different things");
  return options.Parse(argc, argv).value_or(0);
}

Outcome Typed(const std::vector<std::string>& asked) {
  return tools::Captured(Sample, "sample", asked);
}

TEST(Options, TakeValuesWithinTheirBounds) {
  const Outcome outcome =
      Typed({"--drop", "10mm", "--mass", "1.40(3)g", "--values", "60", "--skin", "table", "--limit",
             "2mm", "--part", "0", "--note", "good", "-o", "a.csv", "--all"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(words.drop_m, 10e-3);
  EXPECT_REL(words.mass_kg->standard_uncertainty, 0.03e-3, 1e-12, "one product");
  EXPECT_EQ(words.values, 60U);
  EXPECT_EQ(words.skin, "table");
  EXPECT_EQ(words.note, "good");
  EXPECT_EQ(words.output, "a.csv");
  EXPECT_TRUE(words.all);
  EXPECT_EQ(words.pad_m, 15e-3) << "its default";
}

TEST(Options, ARangeIsTwoEndsOrOneNumberForBoth) {
  EXPECT_EQ(Typed({"--band", "50:0.4kHz"}).status, 0);
  EXPECT_EQ(words.low_hz, 50);
  EXPECT_EQ(words.high_hz, 400);
  EXPECT_EQ(Typed({"--band", "225"}).status, 0);
  EXPECT_EQ(words.low_hz, 225);
  EXPECT_EQ(words.high_hz, 225);
}

TEST(Options, RefuseWhatLiesOutsideAndStateTheBounds) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--drop", "0mm"}, "--drop: '0mm' is not above 0; write one within"},
      {{"--pad", "-1mm"}, "'-1mm' is not from 0 to 1 m"},
      {{"--mass", "0.9g"}, "'0.9g' is not at least 1 g"},
      {{"--limit", "3mm"}, "'3mm' is not at most 2 mm"},
      {{"--part", "1"}, "'1' is not from 0 to below 1"},
      {{"--band", "0:5"}, "'0' is not above 0"},
      {{"--band", "9:5"}, "the lower end of '9:5' lies above the upper one"},
      {{"--values", "61"}, "'61' is not a whole number from 1 to 60"},
      {{"--skin", "pig"}, "use one of text, table"},
      {{"--note", "bad"}, "--note: is bad; write another"},
      {{"--drop", "10(1)mm"}, "has an uncertainty, which is not used here"},
      {{"--drop", "1mm", "--band", "5"},
       "--band: cannot be combined with --drop: they measure different things; leave out one of "
       "the two"}};
  for (const auto& [typed, said] : cases) {
    const Outcome outcome = Typed(typed);
    EXPECT_EQ(outcome.status, 2) << said;
    EXPECT_THAT(outcome.err, HasSubstr(said));
  }
}

TEST(Options, TheNameOfAnOptionIsNoValue) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--note", "--drop", "1mm", "-o", "a.csv"}, "--note: has no value; write --note TEXT"},
      {{"--drop", "--note=x"}, "--drop: has no value; write --drop m"},
      {{"--skin", "--json"}, "--skin: has no value; write --skin text|table"},
      {{"a.bin", "-o", "--all"}, "-o: has no value; write -o FILE"},
      {{"--label", "-o", "a.csv"}, "--label: has no value"},
      {{"--load", "--all"}, "--load: has no value; write --load OHM FILE"},
      {{"--all", "--note"}, "--note: has no value"}};
  for (const auto& [typed, said] : cases) {
    const Outcome outcome = Typed(typed);
    EXPECT_EQ(outcome.status, 2) << said;
    EXPECT_THAT(outcome.err, HasSubstr(said));
  }
  // negative numbers, "-", words that are no option, and names that are meant
  for (const char* value : {"-1mm", "-", "--drops", "files", "note"}) {
    EXPECT_EQ(Typed({"--note", value, "--all"}).status, 0) << value;
    EXPECT_EQ(words.note, value);
  }
  EXPECT_EQ(Typed({"--note=--all"}).status, 0);
  EXPECT_EQ(words.note, "--all");
  EXPECT_EQ(Typed({"--status", "--all"}).status, 0) << "its value may be left out";
  EXPECT_EQ(Typed({"--all", "--", "--drop"}).status, 0) << "a file behind --";
}

int WithoutFiles(int argc, const char* const* argv) {
  std::string output;
  Options options({.name = "alone", .summary = "No file.", .examples = {"one", "two", "three"}});
  options.Output("-o,--output", &output, "FILE", "Write it");
  return options.Parse(argc, argv).value_or(0);
}

int WithAFile(int argc, const char* const* argv) {
  std::string file;
  bool all = false;
  Options options({.name = "one", .summary = "One file.", .examples = {"one", "two", "three"}});
  options.Positional("file", &file, "Trial");
  options.Flag("--all", &all, "All");
  return options.Parse(argc, argv).value_or(0);
}

TEST(Options, AnUnknownOptionIsNamedBeforeAnAbsentFile) {
  EXPECT_THAT(tools::Captured(WithAFile, "one", {"--al"}).err,
              HasSubstr("--al: is not an option; did you mean --all?"));
  EXPECT_THAT(tools::Captured(WithAFile, "one", {"--al=3"}).err, HasSubstr("--al: is not"));
  EXPECT_THAT(tools::Captured(WithAFile, "one", {"--all"}).err, HasSubstr("file is required"));
}

TEST(Options, AWordThatIsLeftOverIsNamed) {
  const Outcome word = tools::Captured(WithoutFiles, "alone", {"1s", "-o", "a.csv"});
  EXPECT_EQ(word.status, 2);
  EXPECT_THAT(word.err, AllOf(HasSubstr("1s"), Not(HasSubstr("-o: "))));
  EXPECT_THAT(tools::Captured(WithoutFiles, "alone", {"--outptu", "a.csv"}).err,
              HasSubstr("--outptu: is not an option; did you mean --output?"));
}

TEST(Options, HelpStatesBoundsAndDefaults) {
  const std::string help = Typed({"--help"}).out;
  for (const char* said :
       {"Height of the drop [above 0]", "Band [above 0; default 20 Hz:500 Hz]",
        "Limit [at most 2 mm]", "Values [from 1 to 60; default 20]", "Law [default text]",
        "Part [from 0 to below 1; default 0]", "LOW:HIGH", "Examples:", "  three"}) {
    EXPECT_THAT(help, HasSubstr(said));
  }
  EXPECT_THAT(help, Not(HasSubstr("--pad")));
  EXPECT_THAT(help, Not(HasSubstr("describe-options")));
  EXPECT_THAT(Typed({"--help-all"}).out, HasSubstr("Side [from 0 to 1 m; default 15 mm]"));
}

int WithLargeEnds(int argc, const char* const* argv) {
  std::optional<double> mass_kg, travel_m;
  std::int64_t points = 1;
  std::vector<std::string> scenes;
  Options options({.name = "ends", .summary = "Large ends.", .examples = {"one", "two", "three"}});
  options.Count("--points", &points, 1, 1'000'000'000, "Points");
  options.Count("--seed", &points, 0, std::numeric_limits<std::int64_t>::max(), "Seed");
  options.Number("--mass", &mass_kg, Dimension::kMass, Within(1e-9, 1e3), "Mass");
  options.Number("--travel", &travel_m, Dimension::kLength, Within(1e-6, 1e-5), "Travel");
  options.Positionals("scene", &scenes, "Scene", 0).is_repeated = false;
  return options.Parse(argc, argv).value_or(0);
}

TEST(Options, HelpStatesEndsThatAreTakenInOneUnit) {
  const std::string help = tools::Captured(WithLargeEnds, "ends", {"--help"}).out;
  for (const char* said :
       {"Points [from 1 to 1000000000; default 1]", "Seed [at least 0; default 1]",
        "Mass [from 1e-09 kg to 1000 kg]", "Travel [from 1 um to 10 um]", "[OPTIONS] [scene]\n"}) {
    EXPECT_THAT(help, HasSubstr(said));
  }
}

TEST(Options, AreDescribedAsJson) {
  const Outcome outcome = Typed({"--drop", "1mm", "--describe-options"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json.at("name"), "sample");
  EXPECT_EQ(json.at("examples").size(), 3U);
  const auto& options = json.at("options");
  ASSERT_EQ(options.size(), 14U);
  const auto& pad = options.at(1);
  EXPECT_EQ(pad.at("name"), "--pad");
  EXPECT_EQ(pad.at("kind"), "number");
  EXPECT_EQ(pad.at("unit"), "m");
  EXPECT_EQ(pad.at("least"), 0.0);
  EXPECT_EQ(pad.at("most"), 1.0);
  EXPECT_EQ(pad.at("above"), false);
  EXPECT_EQ(pad.at("default"), "15 mm");
  EXPECT_EQ(pad.at("rare"), true);
  EXPECT_TRUE(options.at(0).at("most").is_null());
  EXPECT_EQ(options.at(0).at("above"), true);
  EXPECT_EQ(options.at(4).at("below"), true);
  EXPECT_EQ(pad.at("bounds"), "from 0 to 1 m");
  EXPECT_TRUE(options.at(9).at("bounds").is_null());
  EXPECT_EQ(options.at(11).at("known"), nlohmann::json({"subject"}));
  EXPECT_EQ(options.at(11).at("repeatable"), true);
  EXPECT_EQ(options.at(11).at("several"), false);
  EXPECT_EQ(options.at(12).at("several"), true);
  EXPECT_EQ(options.at(13).at("optional"), true);
  EXPECT_EQ(options.at(13).at("repeatable"), false);
  EXPECT_EQ(options.at(7).at("choices"), nlohmann::json({"text", "table"}));
  EXPECT_EQ(Typed({"--drop", "-1mm", "--describe-options"}).status, 2);
}

TEST(Options, DescribeWordsWithoutDashesAndWhatAllVerbsHave) {
  const auto json = nlohmann::json::parse(Typed({"--describe-options"}).out);
  ASSERT_EQ(json.at("positionals").size(), 1U);
  EXPECT_EQ(json.at("positionals").at(0), nlohmann::json({{"name", "files"},
                                                          {"text", "Trials"},
                                                          {"repeatable", true},
                                                          {"required", false},
                                                          {"known", nlohmann::json::array()}}));
  ASSERT_EQ(json.at("common").size(), 4U);
  EXPECT_EQ(json.at("common").at(0).at("name"), "-h,--help");
  EXPECT_EQ(json.at("common").at(0).at("text"), "Show this help");
}

TEST(DefaultBand, ItsTextHasItsNumbers) {
  const auto band = ParseBand(std::string(kDefaultBand));
  ASSERT_TRUE(band) << band.error().Text();
  EXPECT_EQ(band->lower_hz, kDefaultLowerHz);
  EXPECT_EQ(band->upper_hz, kDefaultUpperHz);
}

}  // namespace
}  // namespace haptometer::cli
