#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tests/temporary_files.h"
#include "tests/tools/captured.h"
#include "tools/reproduce/reproduce.h"
#include "tools/verbs.h"

namespace haptometer::tools {
namespace {

using nlohmann::json;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

Outcome Reproduced(const std::vector<std::string>& words) {
  return Captured(RunReproduce, "reproduce", words);
}

// these two once for all tests of them, which CMakeLists.txt keeps in one process
const Outcome& Chained() {
  static const Outcome outcome = Reproduced({"--chain", "--json"});
  return outcome;
}

const std::vector<ThesisFigure>& Figures() {
  static const std::vector<ThesisFigure> figures = ModelFigures({});
  return figures;
}

TEST(ReproduceVerb, JsonHasEveryNumberOfTheThesisOnceAndIsComplete) {
  ASSERT_EQ(Chained().status, 0) << Chained().err;
  const json document = json::parse(Chained().out);
  const json& rows = document.at("rows");
  ASSERT_EQ(rows.size(), ThesisNumbers().size());
  const std::set<std::string> verdicts{"reproduced", "explained", "disagrees", "not printed"};
  int counted = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const json& row = rows.at(i);
    EXPECT_EQ(row.at("key"), ThesisNumbers()[i].key);
    for (const char* key :
         {"group", "where", "what", "relation", "printed", "printed_half_step", "unit", "ours",
          "ours_interval_95", "deviation", "verdict", "generated", "candidates", "remark"}) {
      EXPECT_TRUE(row.contains(key)) << row.at("key") << ' ' << key;
    }
    EXPECT_TRUE(verdicts.contains(row.at("verdict").get<std::string>()));
    EXPECT_TRUE(row.at("ours").is_number()) << row.at("key");
    EXPECT_EQ(row.at("printed").is_null(), row.at("verdict") == "not printed");
    if (!row.at("generated").get<bool>()) ++counted;
  }
  EXPECT_EQ(document.at("reproduced").get<int>() + document.at("explained").get<int>() +
                document.at("disagree").get<int>() + document.at("not_printed").get<int>(),
            counted);
  EXPECT_EQ(document.at("circular"), 10) << "of trials made with the printed number";
  EXPECT_LE(document.at("explained_by_rounding").get<int>() +
                document.at("explained_by_tuned").get<int>(),
            document.at("explained").get<int>());
  EXPECT_EQ(document.at("files"), json::array());
  EXPECT_EQ(document.at("data_source"), json::array({"simulated"}));
  std::set<std::string> kinds;
  for (const json& finding : document.at("findings")) {
    EXPECT_EQ(finding.at("severity"), "note");
    kinds.insert(finding.at("kind").get<std::string>());
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"half-digit", "coil-reaction", "skin-range", "reading",
                                          "tuned", "rounding", "generated"}));
}

TEST(ReproduceVerb, TheChainReturnsTheSimulatedTruth) {
  const json chain = json::parse(Chained().out).at("chain");
  EXPECT_EQ(chain.size(), 21U);
  for (const json& row : chain) {
    EXPECT_TRUE(row.at("holds").get<bool>()) << row.dump();
    if (row.at("truth").is_null() || row.at("unit") == "Hz") continue;
    EXPECT_REL(row.at("answer").get<double>(), row.at("truth").get<double>(), 0.01,
               "11 um of noise on 45 um over 2 s");
  }
  EXPECT_TRUE(chain.back().at("answer").is_null()) << "62.5 readings a second";
}

TEST(ReproduceVerb, TextIsATableForEachGroupOfRows) {
  const Outcome outcome = Reproduced({});
  EXPECT_EQ(outcome.status, 0);
  for (const char* said :
       {"University of Washington, 2013, recomputed\n  data: simulated\n",
        "\n  Steady displacement of the skin\n", "\n  Electrical input without adapter\n",
        "note: 10 rows are of trials generated with the printed number, not of the thesis's",
        "note: \"tuned\" is a candidate cause with a number chosen by what is printed",
        "note: a printed value is rounded to half of its last digit", "as matrix 2.5 has it",
        "Table 2.1 has 1200 N/m", "no cause is proved", "it may miss it"}) {
    EXPECT_THAT(outcome.out, HasSubstr(said));
  }
  for (const char* said :
       {"\n  reproduced +18\n", "\n  of generated trials +10\n",
        "LRA with adapter, 1 mm2 +Table 2.3, p. 12 +equals +0.1917 mm +0.20018 mm +4.42 "
        "+explained\n",
        "Ks: \"less than 2 percent\" +2.2.2, p. 14 +below +2 +1.859[0-9]* +reproduced\n",
        "IA#1 over stock LRA +3.1.2, p. 24 +equals +3.26 +3.[0-9]+ +[0-9.]+ to [0-9.]+ .* "
        "yes\n"}) {
    EXPECT_THAT(outcome.out, ContainsRegex(said));
  }
  for (const char* not_said : {" nan", "not determined", "interpolated linearly"}) {
    EXPECT_THAT(outcome.out, Not(HasSubstr(not_said)));
  }
}

TEST(ReproduceVerb, AllShowsTheCausesAndWhetherTheyGiveWhatIsPrinted) {
  const std::string text = Reproduced({"--all"}).out;
  for (const char* said :
       {"\n    LRA direct, 78.5 mm2\n      remark +with Ks up to 2000 N/m",
        "\n      reading +equation 2.3 as printed, [^\n]*, gives [0-9.]+ deg, as printed\n",
        "\n      tuned +averages over a whole run of 0.085 s",
        "\n      rounding +inputs that round to the printed ones, one set for 3 rows: "
        "[^\n]*, gives 0.04384 mm, as printed\n"}) {
    EXPECT_THAT(text, ContainsRegex(said));
  }
  // the gain at 175 Hz: no rounding brings it above 1
  EXPECT_THAT(text, ContainsRegex("\n      rounding +inputs that round to the printed ones: "
                                  "[^\n]*, gives 0.[5-9][0-9]+\n"));
  EXPECT_THAT(text, Not(HasSubstr("within rounding")));
}

TEST(ReproduceVerb, RefusesPlacesThatCannotBeWritten) {
  EXPECT_EQ(Reproduced({"--report", ::testing::TempDir() + "thesis.pdf"}).status, 2);
  EXPECT_EQ(Reproduced({"--figures", "/dev/null"}).status, 2);
  EXPECT_EQ(Reproduced({"--thesis"}).status, 2);
}

using ReproduceFiles = tests::TemporaryFiles;

TEST_F(ReproduceFiles, FiguresAndPageAreWritten) {
  const std::string page = directory_ / "thesis.html";
  const std::string figures = directory_ / "figures";
  const Outcome outcome = Reproduced({"--figures", figures, "--report", page, "--json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const json files = json::parse(outcome.out).at("files");
  ASSERT_EQ(files.size(), 10U);
  for (const char* name : {"2.2", "2.3", "2.4", "2.5", "2.6", "2.7", "3.3", "3.4", "3.5"}) {
    const std::string svg = Content(std::string("figures/figure-") + name + ".svg");
    EXPECT_THAT(svg, HasSubstr("<svg")) << name;
    EXPECT_THAT(svg, HasSubstr("</svg>")) << name;
  }
  const std::string html = Content("thesis.html");
  EXPECT_THAT(html, HasSubstr("Figure 9."));
  EXPECT_THAT(html, HasSubstr("generated, not measured"));
  EXPECT_THAT(html, HasSubstr("0.0438\u00a0mm"));
  EXPECT_THAT(html, HasSubstr("one set for 3 rows"));
}

const ThesisFigure& FigureOf(const std::vector<ThesisFigure>& figures, std::string_view name) {
  return *std::ranges::find(figures, name, &ThesisFigure::name);
}

double LargestOf(const plot::Series& series) { return *std::ranges::max_element(series.y); }

// what is drawn holds what is printed beside it
TEST(ThesisFigures, HoldTheExtremesOfTheirData) {
  const auto& figures = Figures();
  ASSERT_EQ(figures.size(), 6U);
  const auto& rise = FigureOf(figures, "figure-2.3").panels[0].series;
  ASSERT_EQ(rise.size(), 3U);
  EXPECT_REL(LargestOf(rise[0]), 0.28309, 0.02, "98 % settled after 0.1 s");
  const plot::Series& direct = rise[2];
  EXPECT_REL(*std::max_element(direct.y.begin() + 1000, direct.y.end()), 0.063626, 1e-3,
             "settled; 89 points a period");
  const auto& impedance = FigureOf(figures, "figure-2.4").panels[0].series[1];
  const auto dip = std::ranges::min_element(impedance.y);
  EXPECT_ABS(impedance.x[static_cast<std::size_t>(dip - impedance.y.begin())], 223.65, 0.25,
             "steps of a quarter of a hertz");
  EXPECT_REL(*dip, 0.64547, 1e-3, "NumPy; a parabola between two points");
  for (const plot::Series& curve : FigureOf(figures, "figure-2.5").panels[0].series) {
    EXPECT_EQ(curve.x.size(), 101U);
    EXPECT_ABS(curve.y[50], 1, 1e-12, "nothing changed");
  }
  EXPECT_EQ(LargestOf(FigureOf(figures, "figure-2.6").panels[0].series[0]), 49);
  const auto& stimulus = FigureOf(figures, "figure-2.7").panels[0].series;
  EXPECT_REL(LargestOf(stimulus[0]), 6.2425, 0.005, "a step lies between two of 5 um");
  EXPECT_REL(LargestOf(stimulus[1]), 4.9688, 0.005, "the same");
  EXPECT_REL(LargestOf(stimulus[2]), 2.2204, 0.005, "the same");
}

// 49 circles of 5.7 mm about a pad of 15 mm, as many reached as are counted
TEST(ThesisFigures, DrawTheFieldsThatAreReached) {
  for (const plot::Panel& panel : FigureOf(Figures(), "figure-2.2").panels) {
    EXPECT_TRUE(panel.equal_axes);
    std::array<std::ptrdiff_t, 3> circles{};
    for (std::size_t i = 0; i < circles.size(); ++i) {
      circles[i] = std::ranges::count_if(panel.series[i].y, [](double y) { return std::isnan(y); });
    }
    EXPECT_EQ(circles[0] + circles[1], 49);
    EXPECT_EQ(circles[2], 1);
    EXPECT_THAT(panel.title, HasSubstr(std::to_string(circles[1]) + " reached"));
  }
}

}  // namespace
}  // namespace haptometer::tools
