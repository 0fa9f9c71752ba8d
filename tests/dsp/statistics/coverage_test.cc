// Every 95 % interval of dsp/statistics holds the population's value 93 to 97 times in a hundred.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <string_view>
#include <vector>

#include "dsp/statistics/paired_tests.h"
#include "dsp/statistics/regression.h"
#include "dsp/statistics/repeated_measures.h"
#include "tests/residual.h"

namespace haptometer::dsp {
namespace {

constexpr int kRepetitions = 2000;

bool Holds(const std::optional<Interval>& interval, double truth) {
  return interval && interval->lower <= truth && truth <= interval->upper;
}

// standard normal, Box and Muller: the same on every standard library
class Normal {
 public:
  explicit Normal(std::uint32_t seed) : engine_(seed) {}
  double operator()() {
    const double u = (static_cast<double>(engine_()) + 0.5) / 4294967296.0;
    const double v = static_cast<double>(engine_()) / 4294967296.0;
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * 3.14159265358979323846 * v);
  }

 private:
  std::mt19937 engine_;
};

struct Pairs {
  std::vector<double> a;
  std::vector<double> b;
};

// eight subjects whose conditions differ by `difference` with a standard deviation of 0.5
Pairs DrawPairs(Normal& normal, double difference) {
  Pairs pairs;
  for (int s = 0; s < 8; ++s) {
    const double subject = 10 + normal();
    pairs.b.push_back(subject + 0.3 * normal());
    pairs.a.push_back(subject + difference + 0.4 * normal());
  }
  return pairs;
}

template <typename Draw>
void ExpectCoverage(std::string_view what, std::uint32_t seed, const Draw& holds) {
  Normal normal(seed);
  int held = 0;
  for (int k = 0; k < kRepetitions; ++k) held += holds(normal) ? 1 : 0;
  const double coverage = static_cast<double>(held) / kRepetitions;
  EXPECT_ABS(coverage, 0.95, 0.02, "the bar; 2000 repetitions scatter by 0.005") << what;
}

TEST(Coverage, OfTheMeanDifference) {
  ExpectCoverage("difference", 1, [](Normal& normal) {
    const Pairs pairs = DrawPairs(normal, 0.7);
    return Holds(ComparePairs(pairs.a, pairs.b).test->mean, 0.7);
  });
}

TEST(Coverage, OfTheGeometricMeanRatio) {
  ExpectCoverage("ratio", 2, [](Normal& normal) {
    Pairs pairs = DrawPairs(normal, std::log(3.26));
    for (double& value : pairs.a) value = std::exp(value);
    for (double& value : pairs.b) value = std::exp(value);
    return Holds(RatioOfPairs(pairs.a, pairs.b)->interval, 3.26);
  });
}

TEST(Coverage, OfTheStandardizedDifference) {
  constexpr double kTruth = 1.4;
  ExpectCoverage("d_z", 3, [](Normal& normal) {
    const Pairs pairs = DrawPairs(normal, 0.5 * kTruth);
    return Holds(EffectOfPairs(pairs.a, pairs.b)->interval, kTruth);
  });
}

TEST(Coverage, OfTheRatioOfMeans) {
  ExpectCoverage("Fieller", 4, [](Normal& normal) {
    const Pairs pairs = DrawPairs(normal, 20);
    return Holds(CompareMeans(pairs.a, pairs.b)->interval, 3);
  });
}

TEST(Coverage, OfTheIntraclassCorrelation) {
  for (const double between : {0.3, 2.0}) {
    ExpectCoverage("ICC", 5, [between](Normal& normal) {
      std::vector<std::vector<double>> cells(8);
      for (std::vector<double>& cell : cells) {
        const double subject = between * normal();
        for (int repeat = 0; repeat < 3; ++repeat) cell.push_back(subject + normal());
      }
      return Holds(AssessRepeats(cells)->interval, between * between / (between * between + 1));
    });
  }
}

TEST(Coverage, OfSlopeAndIntercept) {
  const auto line = [](Normal& normal) {
    const std::vector<double> x{1, 2, 3, 4, 5};
    std::vector<double> y;
    for (const double level : x) y.push_back(0.5 + 8 * level + normal());
    return *FitLine(x, y);
  };
  ExpectCoverage("slope", 6, [&](Normal& normal) { return Holds(line(normal).slope_interval, 8); });
  ExpectCoverage("intercept", 7,
                 [&](Normal& normal) { return Holds(line(normal).intercept_interval, 0.5); });
}

// 24 pairs of 8 subjects: the share of false positives at 5 % of the paired t
double FalsePositives(bool subject_means) {
  Normal normal(8);
  int found = 0;
  for (int k = 0; k < kRepetitions; ++k) {
    std::vector<double> differences;
    for (int s = 0; s < 8; ++s) {
      const double subject = normal();
      double mean = 0;
      for (int repeat = 0; repeat < 3; ++repeat) {
        const double trial = subject + 0.5 * normal();
        mean += trial / 3;
        if (!subject_means) differences.push_back(trial);
      }
      if (subject_means) differences.push_back(mean);
    }
    found += TestMean(differences).test->p < 0.05 ? 1 : 0;
  }
  return static_cast<double>(found) / kRepetitions;
}

TEST(UnitOfAnalysis, IsTheSubjectBecauseTrialsAreNotIndependent) {
  EXPECT_ABS(FalsePositives(true), 0.05, 0.015, "three standard deviations of 2000 repetitions");
  EXPECT_GT(FalsePositives(false), 0.2) << "trials taken for independent: this is what goes wrong";
}

}  // namespace
}  // namespace haptometer::dsp
