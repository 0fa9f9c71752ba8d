// study matching and study linearity against numbers of SciPy (which study_reference.py also holds
// against R's).
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/residual.h"
#include "tools/study/linearity.h"
#include "tools/study/matching.h"

namespace haptometer::tools {
namespace {

constexpr double kBar = 1e-11;  // of the issue: 1e-10
constexpr const char* kReason = "two independent implementations in double";

class StudyReference : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ifstream file(std::string(HAPTOMETER_FIXTURES) + "/../tests/tools/study_reference.csv");
    std::string line;
    std::getline(file, line);  // where it is from
    while (std::getline(file, line)) {
      const std::size_t comma = line.find(',');
      wanted_[line.substr(0, comma)] = std::stod(line.substr(comma + 1));
    }
    ASSERT_FALSE(wanted_.empty());
  }

  // a number near 0 is held against `floor`
  void Expect(const std::string& key, double value, double floor = 1e-3) {
    const double wanted = wanted_.at(key);
    const double scale = std::max(std::abs(wanted), floor);
    EXPECT_TRUE(
        tests::Within("relative", key.c_str(), "reference", value, wanted, kBar, scale, kReason));
    ++compared_;
  }

  void Expect(const std::string& key, const MatchedRatio& ratio) {
    Expect(key + "/n", static_cast<double>(ratio.log_ratio.n));
    Expect(key + "/ratio", ratio.ratio());
    Expect(key + "/lower", ratio.ratio_interval()->lower);
    Expect(key + "/upper", ratio.ratio_interval()->upper);
    Expect(key + "/t", ratio.log_ratio.test->t);
    Expect(key + "/p", ratio.log_ratio.test->p, 0);
    if (ratio.p_holm) Expect(key + "/p_holm", *ratio.p_holm, 0);
  }

  void ExpectMatching(const std::string& name, const TextTable& table) {
    const auto result = AnalyzeMatching(table, {{"ia1", "stock"}, {"ia2", "cone"}});
    ASSERT_TRUE(result) << result.error().Text();
    for (const MatchedCondition& condition : result->conditions) {
      const std::string key = name + "/" + condition.name;
      for (const MatchedLevel& level : condition.levels) {
        Expect(fmt::format("{}/{:g}", key, *level.ratio.reference_v), level.ratio);
      }
      Expect(key + "/all", condition.overall);
    }
    for (const MatchedContrast& contrast : result->contrasts) {
      const std::string key =
          name + "/" + contrast.planned.treatment + ":" + contrast.planned.control;
      for (const MatchedRatio& level : contrast.levels) {
        Expect(fmt::format("{}/{:g}", key, *level.reference_v), level);
      }
      Expect(key + "/all", contrast.overall.value());
    }
  }

  // those of which the name begins so
  [[nodiscard]] std::size_t CountOf(const std::string& beginning) const {
    std::size_t count = 0;
    for (const auto& [key, value] : wanted_) count += key.starts_with(beginning) ? 1 : 0;
    return count;
  }

  [[nodiscard]] std::size_t compared() const { return compared_; }

 private:
  std::map<std::string, double> wanted_;
  std::size_t compared_ = 0;
};

TextTable Fixture() {
  const auto table = ReadTextTable(std::string(HAPTOMETER_FIXTURES) + "/matching.csv",
                                   {"reference_v", "condition", "subject", "matched_v", "started"});
  EXPECT_TRUE(table);
  return table.value();
}

TEST_F(StudyReference, MatchingOfTheFixture) {
  ExpectMatching("whole", Fixture());
  EXPECT_EQ(compared(), CountOf("whole/"));
}

TEST_F(StudyReference, MatchingWithGaps) {
  const TextTable whole = Fixture();
  TextTable gaps;
  gaps.name = whole.name;
  for (std::size_t row = 0; row < whole.rows(); ++row) {
    if (row % 7 == 3) continue;
    gaps.lines.push_back(whole.lines[row]);
    for (const auto& [name, cells] : whole.columns) gaps.columns[name].push_back(cells[row]);
  }
  ExpectMatching("gaps", gaps);
  EXPECT_EQ(compared(), CountOf("gaps/"));
}

TEST_F(StudyReference, Linearity) {
  constexpr double kUm = 1e-6;  // in metres
  for (std::uint32_t number = 0; number < 40; ++number) {
    // as study_reference.py says
    std::uint32_t state = number + 1;
    std::vector<DriveReading> readings;
    for (std::uint32_t k = 0; k < 4 + number % 9; ++k) {
      state = (1103515245U * state + 12345U) % (1U << 31);
      const double draw = static_cast<double>(state >> 8) / (1U << 23);
      const double v = 1 + 0.5 * k;
      const double bend = (static_cast<double>(number % 5) - 2) / 10;
      readings.push_back({"", "", v, (8 * v + bend * v * v + 1 + draw) * kUm});
    }
    const LinearityResult result = AnalyzeLinearity(readings, std::nullopt);
    const dsp::Line& line = result.lines.at(0).line.value();
    const dsp::Curvature& bend = result.lines.at(0).curvature.value();
    const std::string key = fmt::format("sweep/{}/", number);
    Expect(key + "slope", line.slope / kUm);
    Expect(key + "slope_lower", line.slope_interval.lower / kUm);
    Expect(key + "slope_upper", line.slope_interval.upper / kUm);
    Expect(key + "r_squared", line.r_squared);
    Expect(key + "largest", line.largest_deviation / kUm);
    Expect(key + "curvature", bend.quadratic / kUm);
    Expect(key + "curvature_lower", bend.interval.lower / kUm);
    Expect(key + "curvature_upper", bend.interval.upper / kUm);
    Expect(key + "curvature_t", bend.t.value());
    Expect(key + "curvature_p", bend.p.value(), 0);
  }
  EXPECT_EQ(compared(), CountOf("sweep/"));
}

}  // namespace
}  // namespace haptometer::tools
