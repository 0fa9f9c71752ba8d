// t, p, F, intervals and effect sizes of 200 random tables against SciPy's numbers (which
// tables_reference.py also holds against R's).
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "dsp/statistics/paired_tests.h"
#include "dsp/statistics/repeated_measures.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

// as tables_reference.py says
CompleteTable RandomTable(std::uint32_t number) {
  std::uint32_t state = number + 1;
  const auto draw = [&] {
    state = (1103515245U * state + 12345U) % (1U << 31);
    return static_cast<double>(state >> 8) / (1U << 23);
  };
  CompleteTable table(3 + number % 22, 2 + number % 5);
  for (std::size_t s = 0; s < table.subjects(); ++s) {
    const double subject = 8 * draw();
    for (std::size_t c = 0; c < table.conditions(); ++c) {
      const double effect = static_cast<double>(number % 7) / 4;
      table.At(s, c) = 16 + subject + static_cast<double>(c) * effect + 4 * draw();
    }
  }
  return table;
}

// a line's numbers; NaN for an empty cell
std::vector<double> Cells(const std::string& line) {
  std::vector<double> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    const std::string cell = line.substr(begin, end - begin);
    cells.push_back(cell.empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(cell));
    begin = end + 1;
  }
  return cells;
}

// of the issue: 1e-10; held ten times tighter
constexpr double kBar = 1e-11;
constexpr const char* kReason = "two independent implementations, one in long double";

class RandomTables : public ::testing::Test {
 protected:
  // `value`: the next column. Numbers near 0 are held against a thousandth of the data's unit.
  void Expect(double value, double floor) {
    const double wanted = cells_.at(column_++);
    const double scale = std::max(std::abs(wanted), floor);
    EXPECT_TRUE(
        tests::Within("relative", "column", "reference", value, wanted, kBar, scale, kReason))
        << "table " << cells_[0] << ", column " << column_ - 1;
  }
  void Expect(const Interval& interval) {
    Expect(interval.lower, 1e-3);
    Expect(interval.upper, 1e-3);
  }
  void ExpectPair(const std::vector<double>& a, const std::vector<double>& b) {
    const OneSample difference = ComparePairs(a, b);
    Expect(difference.test->t, 1e-3);
    Expect(difference.test->p, 0);
    Expect(difference.test->mean);
    const auto effect = EffectOfPairs(a, b);
    Expect(effect->hedges_g, 1e-3);
    Expect(effect->interval.value());
    const auto ratio = RatioOfPairs(a, b);
    Expect(ratio->ratio, 0);
    Expect(ratio->log_ratio.test->p, 0);
    Expect(ratio->interval.value());
    const auto fieller = CompareMeans(a, b);
    Expect(fieller->interval.value());
  }
  void ExpectAnova(const RepeatedMeasuresAnova& anova) {
    Expect(anova.f, 1e-3);
    Expect(anova.p, 0);
    Expect(anova.greenhouse_geisser, 0);
    Expect(anova.p_greenhouse_geisser, 0);
  }

  std::vector<double> cells_;
  std::size_t column_ = 0;
};

TEST_F(RandomTables, AreAsInSciPyAndR) {
  std::ifstream file(HAPTOMETER_FIXTURES "/../tests/dsp/statistics/tables_reference.csv");
  std::string line;
  std::getline(file, line);
  std::getline(file, line);
  std::uint32_t number = 0;
  for (; std::getline(file, line); ++number) {
    cells_ = Cells(line);
    column_ = 3;
    const CompleteTable table = RandomTable(number);
    ASSERT_EQ(static_cast<double>(table.subjects()), cells_.at(1));
    ExpectPair(table.Condition(1), table.Condition(0));
    ExpectAnova(*AnalyzeRepeatedMeasures(table));
    ASSERT_EQ(column_, cells_.size());
  }
  EXPECT_EQ(number, 200U);
}

}  // namespace
}  // namespace haptometer::dsp
