#include "tools/document/render.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace haptometer::document {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Key kRms{"rms_m", "vibration", kMetre, Form::kInterval};
constexpr Key kTone{"tone_hz", "tone", kHertz};

Section Trial(std::string heading, double rms_m) {
  Section trial{.heading = std::move(heading)};
  trial.Add(kRms, rms_m, 0.1e-6).interval = Range{rms_m - 0.2e-6, rms_m + 0.2e-6};
  trial.Add(kTone, std::isnan(rms_m) ? kNan : 225.0);
  return trial;
}

Section Parameters() {
  Section parameters{.name = "parameters", .heading = "Parameters"};
  parameters.Add({"Kv", "stiffness Kv", kNewtonPerMetre, Form::kEstimate}, 2800.0, 12.0).interval =
      Range{2776, 2824};
  parameters.Add({"Bv", "damping Bv", kNewtonSecondPerMetre, Form::kEstimate}, kNan).at_most =
      0.0512;
  return parameters;
}

// what the tests read: each kind of part once
Document Sample() {
  Document document{.verb = "sample", .title = "Vibration of two trials"};
  document.provenance = {.version = "1.2",
                         .command = "haptometer sample a.bin",
                         .utc = "2026-11-23T05:06:07Z",
                         .inputs = {{"a.bin", 12, "ab"}, {"b.bin", 13, ""}}};
  Section& root = document.root;
  root.sources = {DataSource::kEmulated, DataSource::kInterrupted};
  root.Add(kRms, 12.3456e-6, 0.1e-6).note = "in 20-500 Hz";
  root.Add({"readings", "readings"}, std::size_t{1000});
  root.Add({"window_s", "window", kSecond}, Range{0.5, 2.25});
  root.Add({"matrix"}, std::vector<std::vector<double>>{{1, kNan}, {0.1, 1}});
  root.Add({"", "drive"}, "from a channel");
  root.sections.push_back({.name = "trials",
                           .heading = "Trials",
                           .shape = Section::Shape::kTable,
                           .sections = {Trial("a", 9e-6), Trial("b", kNan)}});
  root.sections.push_back(Parameters());
  Section onset{.name = "onset", .heading = "Onset", .is_known = false};
  onset.Add({"rise_s", "rise", kSecond, Form::kUncertain}, 0.0);
  root.sections.push_back(onset);
  Section flat{.is_known = false};
  flat.Add({"drive_s", "drive", kSecond, Form::kUncertain}, 0.0);
  root.sections.push_back(flat);
  Section budget{.heading = "Budget", .detail = Detail::kAll};
  budget.Add({"", "noise", kMetre}, 2e-9);
  root.sections.push_back(budget);
  root.findings = {{.kind = "few-readings",
                    .severity = Severity::kDoubt,
                    .text = "48 readings are few",
                    .subject = "a.bin",
                    .numbers = {{"readings", 48}, {"channel", std::string("CH1")}}}};
  return document;
}

TEST(TextOf, ADocumentIsALineForEachLabel) {
  EXPECT_EQ(TextOf(Sample(), Detail::kShort),
            "Vibration of two trials\n"
            "  data: emulated, interrupted\n"
            "  vibration  12.35(10) um, in 20-500 Hz\n"
            "  readings   1000\n"
            "  window     0.5 to 2.25 s\n"
            "  drive      from a channel\n"
            "  Trials\n"
            "    vibration / um  tone / Hz\n"
            "          9.00(10)        225\n"
            "                 -          -\n"
            "  Parameters\n"
            "    stiffness Kv  2800(12) N/m; 95 %: 2776 to 2824 N/m\n"
            "    damping Bv    at most 0.051 N s/m (95 %)\n"
            "  doubt: a.bin: 48 readings are few\n");
}

TEST(TextOf, WhatIsNotShownWidensNoColumn) {
  Document document{.verb = "v", .title = "t"};
  document.root.Add({"tone_hz", "tone", kHertz}, 225.0);
  Section hidden{.detail = Detail::kAll};
  hidden.Add({"noise_m", "noise of one reading", kMetre}, 2e-9);
  document.root.sections.push_back(hidden);
  EXPECT_EQ(TextOf(document, Detail::kShort), "t\n  tone  225 Hz\n");
  EXPECT_THAT(TextOf(document, Detail::kAll), HasSubstr("  tone                  225 Hz\n"));
}

TEST(TextOf, AllDetailsHoldTheirSectionsAndTheProvenance) {
  const std::string text = TextOf(Sample(), Detail::kAll);
  EXPECT_THAT(text, HasSubstr("  Budget\n    noise  0.002 um\n"));
  EXPECT_THAT(text, HasSubstr("  haptometer 1.2, 2026-11-23T05:06:07Z\n"
                              "  command: haptometer sample a.bin\n"
                              "  input: a.bin, 12 bytes, SHA-256 ab\n"
                              "  input: b.bin, 13 bytes, SHA-256 not known\n"));
}

TEST(TextOf, WhatIsNotPrintableIsEscaped) {
  Document document{.verb = "sample", .title = "a\x1b[2J"};
  document.root.Add({"label", "label"}, "two\nlines");
  EXPECT_EQ(TextOf(document, Detail::kShort), "a\\x1b[2J\n  label  two\\nlines\n");
}

TEST(TextOf, LabelsStandAsWideAsThoseThatAreShown) {
  Document document{.verb = "sample", .title = "t"};
  document.root.Add({"a", "a label of what is not known"}, Value());
  document.root.Add({"frequency_hz", "tone", kHertz}, 225.0, 1e-9).interval =
      Range{225 - 2e-9, 225 + 2e-9};
  EXPECT_EQ(TextOf(document, Detail::kShort), "t\n  tone  225 Hz\n") << "and no interval of it";
}

TEST(TextOf, ListsOfSectionsStandOneBelowTheOther) {
  Document document{.verb = "sample", .title = "t"};
  document.root.sections.push_back({.name = "trials",
                                    .shape = Section::Shape::kArray,
                                    .sections = {Trial("a", 9e-6), Trial("b", 1.5e-3)}});
  EXPECT_EQ(TextOf(document, Detail::kShort),
            "t\n"
            "  a\n"
            "    vibration  9.00(10) um; 95 %: 8.80 to 9.20 um\n"
            "    tone       225 Hz\n"
            "  b\n"
            "    vibration  1.50000(10) mm; 95 %: 1.49980 to 1.50020 mm\n"
            "    tone       225 Hz\n");
}

TEST(ColumnsOf, ATableAreInOneUnitEach) {
  const std::vector<Column> columns = ColumnsOf({.name = "trials",
                                                 .shape = Section::Shape::kTable,
                                                 .sections = {Trial("", 9e-6), Trial("", 1.5e-3)}});
  ASSERT_EQ(columns.size(), 2U);
  EXPECT_EQ(columns[0].heading, "vibration / mm");
  EXPECT_EQ(columns[0].cells, (std::vector<std::string>{"0.00900(10)", "1.50000(10)"}));
}

TEST(ColumnsOf, WhereRowsDifferInUnitItStandsInTheCells) {
  Section table{.shape = Section::Shape::kTable, .sections = {{}, {}}};
  table.sections[0].Add({"", "value", kMetre}, 2e-3);
  table.sections[1].Add({"", "value", kHertz}, 225.0);
  EXPECT_EQ(ColumnsOf(table)[0].heading, "value");
  EXPECT_EQ(ColumnsOf(table)[0].cells, (std::vector<std::string>{"2 mm", "225 Hz"}));
}

TEST(ColumnsOf, AColumnWithoutAnyValueIsLeftOut) {
  Section table{.shape = Section::Shape::kTable, .sections = {Trial("", kNan), Trial("", kNan)}};
  EXPECT_TRUE(ColumnsOf(table).empty());
}

// a table of two groups, the first with more to say of a row
Document Groups() {
  Document document{.verb = "sample", .title = "t"};
  for (const char* name : {"one", "other"}) {
    Section& group = document.root.sections.emplace_back(
        Section{.name = "rows", .heading = name, .shape = Section::Shape::kTable});
    Section& row = group.sections.emplace_back();
    row.Add({"what", "what"}, name);
    row.Add({"count", "count"}, 1);
    Section& why = row.sections.emplace_back(Section{.heading = "why"});
    why.Add({"remark", "remark"}, name == std::string("one") ? Value("because") : Value());
  }
  return document;
}

TEST(TextOf, ASectionOfARowWithAHeadingStandsBelowTheTable) {
  EXPECT_EQ(TextOf(Groups(), Detail::kShort),
            "t\n"
            "  one\n"
            "    what  count\n"
            "    one       1\n"
            "    why\n"
            "      remark  because\n"
            "  other\n"
            "    what   count\n"
            "    other      1\n");
}

TEST(JsonOf, TablesOfOneNameAreOneArray) {
  EXPECT_EQ(nlohmann::json::parse(JsonOf(Groups())).at("rows").dump(),
            R"([{"count":1,"remark":"because","what":"one"},)"
            R"({"count":1,"remark":null,"what":"other"}])");
}

TEST(JsonOf, ADocumentHoldsFlatNamesWithCompanions) {
  const auto json = nlohmann::json::parse(JsonOf(Sample()));
  EXPECT_EQ(json.at("rms_m").get<double>(), 12.3456e-6) << "round-trip";
  EXPECT_EQ(json.at("rms_standard_uncertainty_m").get<double>(), 0.1e-6);
  EXPECT_TRUE(json.at("rms_interval_95_m").is_null());
  EXPECT_EQ(json.at("readings"), 1000);
  EXPECT_EQ(json.at("window_s"), nlohmann::json({0.5, 2.25}));
  EXPECT_EQ(json.at("matrix").dump(), "[[1.0,null],[0.1,1.0]]");
  EXPECT_EQ(json.at("data_source"), nlohmann::json({"emulated", "interrupted"}));
  EXPECT_FALSE(json.contains("")) << "a label without a name";
}

TEST(JsonOf, WhatIsNotKnownIsNullAndThere) {
  const auto json = nlohmann::json::parse(JsonOf(Sample()));
  EXPECT_TRUE(json.at("onset").is_null());
  EXPECT_TRUE(json.at("drive_s").is_null());
  EXPECT_TRUE(json.at("drive_standard_uncertainty_s").is_null());
  EXPECT_TRUE(json.at("trials").at(1).at("rms_m").is_null());
  EXPECT_EQ(json.at("trials").at(0).at("rms_interval_95_m").size(), 2U);
}

TEST(JsonOf, AnEstimateIsAnObject) {
  const auto json = nlohmann::json::parse(JsonOf(Sample())).at("parameters");
  EXPECT_EQ(json.at("Kv").at("value"), 2800);
  EXPECT_EQ(json.at("Kv").at("combined_standard_uncertainty"), 12);
  EXPECT_EQ(json.at("Kv").at("upper_95"), 2824);
  EXPECT_EQ(json.at("Kv").at("determined"), true);
  EXPECT_TRUE(json.at("Bv").at("value").is_null());
  EXPECT_EQ(json.at("Bv").at("at_most_95"), 0.0512);
  EXPECT_EQ(json.at("Bv").at("unit"), "N s/m");
}

TEST(JsonOf, HoldsFindingsAndProvenance) {
  const auto json = nlohmann::json::parse(JsonOf(Sample()));
  EXPECT_EQ(json.at("findings").dump(),
            R"([{"kind":"few-readings","numbers":{"channel":"CH1","readings":48},)"
            R"("severity":"doubt","subject":"a.bin","text":"48 readings are few"}])");
  const auto& provenance = json.at("provenance");
  EXPECT_EQ(provenance.at("command"), "haptometer sample a.bin");
  EXPECT_EQ(provenance.at("inputs").at(0).at("sha256"), "ab");
  EXPECT_TRUE(provenance.at("inputs").at(1).at("sha256").is_null());
}

TEST(CsvOf, AListIsARowForEachElement) {
  Section list{.name = "trials",
               .shape = Section::Shape::kTable,
               .sections = {Trial("", 9e-6), Trial("", kNan)}};
  list.sections[0].Add({"label"}, "=1+1, \"x\"");
  list.sections[1].Add({"label"}, Value());
  EXPECT_EQ(CsvOf(list, {.version = "1", .command = "haptometer x", .utc = "now", .inputs = {}}),
            "# haptometer 1, now\n# command: haptometer x\n"
            "rms_m,rms_standard_uncertainty_m,rms_interval_95_m,tone_hz,label\n"
            "9e-06,1e-07,\"[8.8e-06,9.2e-06]\",225.0,\"'=1+1, \"\"x\"\"\"\n"
            ",1e-07,,,\n");
}

TEST(HtmlOf, ADocumentIsAPageWithEverything) {
  Document document = Sample();
  document.root.figures.push_back(
      {"a ramp", {{"", "time / s", "displacement / um", {{"", {}, {0, 1}, {0, 1}}}}}});
  const auto html = HtmlOf(document);
  ASSERT_TRUE(html);
  for (const char* said :
       {"<h1>Vibration of two trials</h1>", "haptometer 1.2, 2026-11-23T05:06:07Z: haptometer",
        "<th scope=\"row\">vibration</th><td>12.35(10)\u00a0µm, in 20-500\u00a0Hz</td>",
        "<p class=\"warning\">doubt: a.bin: 48 readings are few</p>", "Figure 1. a ramp",
        "<th scope=\"col\" class=\"number\">vibration / µm</th>", "<h2>Budget</h2>",
        "<h2>Inputs</h2>"}) {
    EXPECT_THAT(*html, HasSubstr(said));
  }
  EXPECT_THAT(*html, Not(HasSubstr("Onset")));
}

TEST(HtmlOf, WhatMeansSomethingToHtmlOrIsNotPrintableIsWrittenOut) {
  Document document{.verb = "sample", .title = "a<b latin\xe9\x1b.bin"};
  document.provenance.command = "x & \"y\" \xc3\xa9 \xc3";
  document.root.Add({"key", "<i>"}, "&amp;");
  document.root.findings.push_back(
      {.kind = "note", .text = "<script>alert(1)</script>", .subject = {}, .numbers = {}});
  const auto html = HtmlOf(document);
  ASSERT_TRUE(html);
  EXPECT_THAT(*html, HasSubstr("<title>a&lt;b latin\\xe9\\x1b.bin</title>"));
  EXPECT_THAT(*html, HasSubstr("x &amp; &quot;y&quot; \xc3\xa9 \\xc3</p>"));
  EXPECT_THAT(*html, Not(HasSubstr("<script>")));
  EXPECT_THAT(*html, HasSubstr("<th scope=\"row\">&lt;i&gt;</th><td>&amp;amp;</td>"));
}

TEST(HtmlOf, NumbersItsFiguresAndNeedsNothingFromElsewhere) {
  Document document{.verb = "sample", .title = "two"};
  const plot::Panel ramp{"a ramp", "time / s", "distance / um", {{"", {}, {0, 1}, {0, 1}}}};
  document.root.figures = {{"first", {ramp}}, {"second", {ramp}}};
  const auto html = HtmlOf(document);
  ASSERT_TRUE(html);
  EXPECT_THAT(*html, HasSubstr("Figure 1. first"));
  EXPECT_THAT(*html, HasSubstr("Figure 2. second"));
  EXPECT_THAT(*html, Not(HasSubstr("src=")));
  EXPECT_THAT(*html, Not(HasSubstr("<?xml")));
}

}  // namespace
}  // namespace haptometer::document
