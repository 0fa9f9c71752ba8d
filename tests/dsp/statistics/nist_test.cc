#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tests/dsp/statistics/nist_reference.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

std::vector<double> NumAcc(double first, double low, double high) {
  std::vector<double> values{first};
  for (int k = 0; k < 500; ++k) values.insert(values.end(), {low, high});
  return values;
}

std::map<std::string, std::vector<double>> Sets() {
  std::map<std::string, std::vector<double>> sets{
      {"NumAcc1", {10000001, 10000003, 10000002}},
      {"NumAcc2", NumAcc(1.2, 1.1, 1.3)},
      {"NumAcc3", NumAcc(1000000.2, 1000000.1, 1000000.3)},
      {"NumAcc4", NumAcc(10000000.2, 10000000.1, 10000000.3)}};
  std::ifstream file(HAPTOMETER_FIXTURES "/nist_univariate.txt");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    std::string name;
    words >> name;
    for (double value = 0; words >> value;) sets[name].push_back(value);
  }
  return sets;
}

// NIST's measure: decimal digits that are right, at most those that are certified
double RightDigits(double value, double certified) {
  constexpr double kCertifiedDigits = 15;
  if (value == certified) return kCertifiedDigits;
  return std::min(kCertifiedDigits, -std::log10(std::abs((value - certified) / certified)));
}

TEST(NistUnivariateSets, AreWithinHalfADigitOfExactArithmetic) {
  const auto sets = Sets();
  for (const NistSet& set : kNistSets) {
    const std::vector<double>& values = sets.at(set.name);
    const std::array<double, 2> ours{Mean(values), StandardDeviation(values)};
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const double possible = RightDigits(set.exact[i], set.certified[i]);
      EXPECT_GE(RightDigits(ours[i], set.certified[i]), possible - 0.5) << set.name << ' ' << i;
      EXPECT_REL(ours[i], set.exact[i], 2e-15, "sums of up to 5000 rounded squares");
    }
  }
}

}  // namespace
}  // namespace haptometer::dsp
