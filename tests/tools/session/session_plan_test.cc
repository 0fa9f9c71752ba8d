#include "tools/session/session_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace haptometer::tools {
namespace {

SessionPlan PlanOf(std::size_t subjects, std::size_t conditions, SessionOrder order) {
  SessionPlan plan;
  for (std::size_t s = 1; s <= subjects; ++s) plan.subjects.push_back("s" + std::to_string(s));
  for (std::size_t c = 1; c <= conditions; ++c) plan.conditions.push_back("c" + std::to_string(c));
  plan.repeats = 2;
  plan.order = order;
  plan.seed = 5;
  plan.duration_s = 4;
  plan.source = {"--port", "/dev/ttyUSB0"};
  return plan;
}

// the conditions of each block, in their order
std::vector<std::vector<std::string>> BlocksOf(const SessionPlan& plan) {
  std::vector<std::vector<std::string>> blocks;
  for (const SessionCell& cell : CellsOf(plan)) {
    if (cell.is_floor()) continue;
    if (blocks.empty() || blocks.back().size() == plan.conditions.size()) blocks.emplace_back();
    blocks.back().push_back(cell.condition);
  }
  return blocks;
}

TEST(SessionPlan, EachCellIsPlannedOnceWhateverTheOrder) {
  using enum SessionOrder;
  for (const SessionOrder order : {kBalanced, kRandom, kGiven}) {
    for (std::size_t conditions = 1; conditions <= 7; ++conditions) {
      const SessionPlan plan = PlanOf(5, conditions, order);
      const auto cells = CellsOf(plan);
      std::set<std::string> names;
      for (const SessionCell& cell : cells) names.insert(NameOf(cell));
      EXPECT_EQ(cells.size(), 5 * conditions * 2) << Name(order);
      EXPECT_EQ(names.size(), cells.size());
      EXPECT_EQ(cells, CellsOf(plan)) << "the same plan has the same order";
    }
  }
}

// Williams 1949: over n subjects (2n where n is odd) each condition is in each place, and behind
// each other one, equally often
TEST(SessionPlan, TheBalancedOrderIsAWilliamsDesign) {
  for (std::size_t n = 2; n <= 9; ++n) {
    const std::size_t rows = n % 2 == 0 ? n : 2 * n;
    SessionPlan plan = PlanOf(rows, n, SessionOrder::kBalanced);
    plan.repeats = 1;
    std::map<std::pair<std::size_t, std::string>, std::size_t> places;
    std::map<std::pair<std::string, std::string>, std::size_t> followers;
    for (const auto& block : BlocksOf(plan)) {
      for (std::size_t i = 0; i < n; ++i) {
        ++places[{i, block[i]}];
        if (i > 0) ++followers[{block[i - 1], block[i]}];
      }
    }
    EXPECT_EQ(rows, DesignRows(plan));
    EXPECT_EQ(places.size(), n * n);
    EXPECT_EQ(followers.size(), n * (n - 1));
    for (const auto& [place, count] : places) EXPECT_EQ(count, rows / n) << n;
    for (const auto& [pair, count] : followers) EXPECT_EQ(count, rows / n) << n;
  }
}

TEST(SessionPlan, TheSeedDecidesAndTheGivenOrderIsKept) {
  SessionPlan plan = PlanOf(6, 5, SessionOrder::kRandom);
  const auto first = CellsOf(plan);
  plan.seed = 6;
  EXPECT_NE(first, CellsOf(plan));
  plan.order = SessionOrder::kBalanced;
  const auto balanced = CellsOf(plan);
  plan.seed = 7;
  EXPECT_NE(balanced, CellsOf(plan));
  plan.order = SessionOrder::kGiven;
  for (const auto& block : BlocksOf(plan)) EXPECT_EQ(block, plan.conditions);
}

TEST(SessionPlan, AFloorComesBeforeEachSubjectsTrials) {
  SessionPlan plan = PlanOf(3, 2, SessionOrder::kGiven);
  plan.has_floors = true;
  const auto cells = CellsOf(plan);
  ASSERT_EQ(cells.size(), 3U * 5U);
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(cells[i].is_floor(), i % 5 == 0);
  EXPECT_EQ(cells[5].subject, "s2");
  EXPECT_EQ(NameOf(cells[5]), "subject s2, floor");
}

TEST(SessionPlan, IsReadAsItWasWritten) {
  SessionPlan plan = PlanOf(2, 3, SessionOrder::kRandom);
  plan.subjects[0] = "Ann \"the first\" \\ caf\u00e9";
  plan.has_floors = true;
  plan.duration_s = 0.1;
  plan.expect = "tone=225Hz+-1Hz, change<5%";
  plan.drive_frequency_hz = 225;
  plan.drive_amplitude_v = 5.1;
  plan.contrasts = {{"c2", "c1"}, {"c3", "c1"}};
  const auto read = ParsePlan(TomlOf(plan), "session.toml");
  ASSERT_TRUE(read) << read.error().Text();
  EXPECT_EQ(TomlOf(*read), TomlOf(plan));
  EXPECT_EQ(CellsOf(*read), CellsOf(plan));
  EXPECT_EQ(read->duration_s, plan.duration_s);
  EXPECT_EQ(read->source, plan.source);
  EXPECT_EQ(read->contrasts.at(1).treatment, "c3");
  EXPECT_EQ(read->drive_amplitude_v, 5.1);
}

// of 8 subjects 1.1560 (tests/dsp/statistics/power_reference.csv), of 2 contrasts 1.3392
TEST(SessionPlan, StatesTheEffectThatItsSubjectsShow) {
  SessionPlan plan = PlanOf(8, 2, SessionOrder::kGiven);
  EXPECT_NEAR(*DetectableEffect(plan), 1.15603, 1e-5);
  plan.conditions.emplace_back("third");
  EXPECT_NEAR(*DetectableEffect(plan), 1.33917, 1e-5) << "against the first, both";
  plan.contrasts = {{"third", "c2"}};
  EXPECT_NEAR(*DetectableEffect(plan), 1.15603, 1e-5);
  plan.subjects = {"1"};
  EXPECT_EQ(DetectableEffect(plan), std::nullopt);
}

TEST(SessionPlan, ADriveLimitsTheToneWhereNothingElseDoes) {
  SessionPlan plan = PlanOf(2, 2, SessionOrder::kGiven);
  EXPECT_FALSE(ExpectationOf(plan).tone_hz);
  plan.drive_frequency_hz = 200;
  EXPECT_EQ(ExpectationOf(plan).tone_hz, (Quantity{200, 2}));
  plan.expect = "tone=225Hz+-1Hz";
  EXPECT_EQ(ExpectationOf(plan).tone_hz, (Quantity{225, 1}));
}

TEST(SessionPlan, ImpossiblePlansAreRefusedInOneLine) {
  const auto refused = [](auto&& change) {
    SessionPlan plan = PlanOf(2, 2, SessionOrder::kBalanced);
    change(plan);
    const auto checked = CheckPlan(plan, "p");
    return checked ? std::string() : checked.error().Text();
  };
  EXPECT_EQ(refused([](SessionPlan&) {}), "");
  EXPECT_EQ(refused([](SessionPlan& plan) { plan.conditions = {"Stock", "stock"}; }),
            "p: conditions: Stock and stock differ by case, blanks or zeros in front only; give "
            "each a name of its "
            "own");
  EXPECT_EQ(refused([](SessionPlan& plan) { plan.subjects = {"1", "1"}; }),
            "p: subjects: name 1 twice; give each a name of its own");
  for (const char* name : {"", " a", "a ", "a\nb", "\x1b", "\xff"}) {
    EXPECT_NE(refused([&](SessionPlan& plan) { plan.conditions[1] = name; }), "") << name;
  }
  EXPECT_NE(refused([](SessionPlan& plan) { plan.conditions.clear(); }), "");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.repeats = 0; }), "");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.duration_s = 0; }), "");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.source.clear(); }), "");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.expect = "tone"; }), "");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.contrasts = {{"c1", "c9"}}; }), "");
  EXPECT_EQ(
      refused([](SessionPlan& plan) { plan.contrasts = {{"c1", "c2"}, {"c1", "c2"}}; }),
      "p: contrasts: c1 against c2: is a pair of conditions that is planned twice; write each "
      "pair once");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.contrasts = {{"c1", "c2"}, {"c2", "c1"}}; }), "");
  EXPECT_NE(refused([](SessionPlan& plan) { plan.drive_frequency_hz = 0; }), "");
  EXPECT_NE(refused([](SessionPlan& plan) {
              plan.subjects = *ReadSubjects("1000");
              plan.repeats = 1000;
            }),
            "");
  EXPECT_FALSE(ParsePlan("subjects = [\"1\"]\nfoo = 1\n", "s.toml"));
}

TEST(SessionPlan, SubjectsAreANumberOrNames) {
  EXPECT_EQ(*ReadSubjects("3"), (std::vector<std::string>{"1", "2", "3"}));
  EXPECT_EQ(*ReadSubjects("s2"), (std::vector<std::string>{"s2"}));
  EXPECT_EQ(*ReadSubjects("ann, ben"), (std::vector<std::string>{"ann", "ben"}));
  for (const char* wrong : {"0", "1001", "99999999999999999999", "-2", "2.5", "1e2"}) {
    EXPECT_FALSE(ReadSubjects(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace haptometer::tools
