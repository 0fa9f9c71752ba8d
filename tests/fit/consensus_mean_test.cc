#include "fit/consensus_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "fit/uncertainty.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

// estimates of these standard uncertainties about 0, scattered by `between` too
std::vector<Estimate> Drawn(const std::vector<double>& uncertainties, double between,
                            std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  std::vector<Estimate> estimates;
  for (const double u : uncertainties) {
    estimates.push_back({between * normal(engine) + u * normal(engine), u * u});
  }
  return estimates;
}

// `count` uncertainties from 1 to `ratio`, in equal ratios
std::vector<double> From1To(double ratio, std::size_t count) {
  std::vector<double> uncertainties;
  for (std::size_t k = 0; k < count; ++k) {
    uncertainties.push_back(
        std::pow(ratio, static_cast<double>(k) / static_cast<double>(count - 1)));
  }
  return uncertainties;
}

TEST(ConsensusMean, TwoEstimatesHaveTheClosedForm) {
  // F(t^2) = d^2 / (u1^2 + u2^2 + 2 t^2) = 1
  const ConsensusMean mean = ConsensusOf({{2, 1}, {12, 9}});
  const double between = (100.0 - 10) / 2;
  EXPECT_REL(mean.between_variance, between, 1e-12, "rounding");
  EXPECT_REL(mean.value, (2 / (1 + between) + 12 / (9 + between)) * mean.variance, 1e-12,
             "rounding");
  EXPECT_REL(mean.variance, 1 / (1 / (1 + between) + 1 / (9 + between)), 1e-12, "rounding");
  EXPECT_REL(mean.scatter_variance, mean.variance - 0.9, 1e-12, "1/(1/1 + 1/9) without scatter");
  EXPECT_REL(mean.birge_ratio, std::sqrt(10.0), 1e-12, "chi^2 of two: d^2/(u1^2 + u2^2)");
}

TEST(ConsensusMean, WhatTheNoiseExplainsHasTheWeightsOfTheNoise) {
  const ConsensusMean mean = ConsensusOf({{2, 1}, {5, 9}});
  EXPECT_EQ(mean.between_variance, 0) << "chi^2 = 9/10 of 1 degree of freedom";
  EXPECT_EQ(mean.scatter_variance, 0);
  EXPECT_REL(mean.value, 2.3, 1e-12, "(2/1 + 5/9)/(1/1 + 1/9)");
  EXPECT_REL(mean.variance, 0.9, 1e-12, "1/(1/1 + 1/9)");
  const ConsensusMean one = ConsensusOf({{2, 1}});
  EXPECT_EQ(one.value, 2);
  EXPECT_EQ(one.variance, 1);
  EXPECT_EQ(one.birge_ratio, 0);
}

TEST(ConsensusMean, EqualUncertaintiesAreWidenedByTheBirgeRatio) {
  const ConsensusMean mean = ConsensusOf({{-3, 1}, {0, 1}, {3, 1}});
  EXPECT_REL(mean.birge_ratio, 3.0, 1e-12, "chi^2 = 18 of 2");
  EXPECT_ABS(mean.value, 0.0, 1e-12, "rounding");
  EXPECT_REL(mean.variance, 9.0 / 3, 1e-12, "the empirical variance over n");
}

// the equation holds, whatever the uncertainties are
TEST(ConsensusMean, ChiSquareIsItsDegreesOfFreedom) {
  std::mt19937_64 engine(5);
  for (const double ratio : {1.0, 8.0, 1e3, 1e9}) {
    for (const std::size_t count : {2UL, 3UL, 6UL, 20UL}) {
      const auto estimates = Drawn(From1To(ratio, count), 30 * std::sqrt(ratio), engine);
      const ConsensusMean mean = ConsensusOf(estimates);
      if (mean.birge_ratio < 1) continue;
      double squares = 0;
      for (const auto& [value, variance] : estimates) {
        squares += std::pow(value - mean.value, 2) / (variance + mean.between_variance);
      }
      EXPECT_REL(squares, static_cast<double>(count) - 1, 1e-9, "the search's end");
    }
  }
  // records without noise: the mean and the scatter of the values
  const ConsensusMean exact = ConsensusOf({{1, 0}, {2, 0}, {6, 1e-40}});
  EXPECT_REL(exact.value, 3.0, 1e-12, "alike weights");
  EXPECT_REL(exact.variance, 7.0 / 3, 1e-12, "the empirical variance over n");
}

TEST(ConsensusMean, OfGroupsTheSquaresAddAboutTheirOwnMeans) {
  // of equal u^2 = 4: F = (2 + 8)/(4 + t^2), whatever the means are
  const std::vector<std::vector<Estimate>> groups{{{9, 4}, {11, 4}},
                                                  {{-52, 4}, {-50, 4}, {-48, 4}}};
  EXPECT_REL(SquaresOf(groups, 0), 10.0 / 4, 1e-12, "rounding");
  EXPECT_REL(SquaresOf(groups, 6), 1.0, 1e-12, "rounding");
  EXPECT_REL(BetweenVariance(groups, 0.5), 10 / 0.5 - 4, 1e-11, "the search's end");
  EXPECT_EQ(BetweenVariance(groups, 2.6), 0) << "F(0) is smaller";
  // of different u, in both
  const std::vector<std::vector<Estimate>> apart{{{0, 1}, {9, 9}}, {{0, 0.04}, {7, 4}, {1, 1}}};
  const double between = BetweenVariance(apart, 1.5);
  EXPECT_GT(between, 1);
  EXPECT_REL(SquaresOf(apart, between), 1.5, 1e-11, "the search's end");
}

TEST(ConsensusMean, StudentSquaresMakeANormalIntervalStudents) {
  // of three: +-t s/sqrt(3), s^2 = 9, t(2) = 4.30265
  const std::vector<Estimate> estimates{{-3, 1}, {0, 1}, {3, 1}};
  const double between = BetweenVariance({estimates}, StudentSquares(2));
  EXPECT_REL(1.96 * std::sqrt((1 + between) / 3), 4.302653 * 3 / std::sqrt(3.0), 1e-6,
             "the factor's digits");
  EXPECT_REL(StudentSquares(1e9), 1e9, 1e-4, "1.96 in place of 1.959964");
}

// of 100 intervals whose scatter holds Student's factor
double HeldByStudent(const std::vector<double>& uncertainties, double between) {
  constexpr int kSets = 2000;  // their share scatters by 0.5 %
  std::mt19937_64 engine(uncertainties.size());
  const double squares = StudentSquares(static_cast<double>(uncertainties.size()) - 1);
  int held = 0;
  for (int set = 0; set < kSets; ++set) {
    const auto estimates = Drawn(uncertainties, between, engine);
    const double scatter = BetweenVariance({estimates}, squares);
    double weights = 0;
    for (const Estimate& estimate : estimates) weights += 1 / (estimate.variance + scatter);
    held += std::abs(ConsensusOf(estimates).value) < 1.96 / std::sqrt(weights) ? 1 : 0;
  }
  return 100.0 * held / kSets;
}

TEST(ConsensusMean, WithStudentSquaresIntervalsHoldWhateverTheScatter) {
  for (const std::size_t count : {2UL, 3UL, 6UL}) {
    for (const double ratio : {1.0, 8.0}) {
      for (const double scatter : {0.0, 0.5, 2.0, 4.0, 8.0, 50.0}) {
        const double held = HeldByStudent(From1To(ratio, count), scatter);
        // 93 less three deviations of the share
        EXPECT_GE(held, 91.5) << count << " drops 1:" << ratio << ", scatter " << scatter;
        EXPECT_LE(held, 99.5) << count << " drops 1:" << ratio << ", scatter " << scatter;
      }
    }
  }
}

// of 100 intervals
double Held(const std::vector<double>& uncertainties, double between) {
  constexpr int kSets = 2000;  // their share scatters by 0.5 %
  std::mt19937_64 engine(uncertainties.size());
  int held = 0;
  for (int set = 0; set < kSets; ++set) {
    const ConsensusMean mean = ConsensusOf(Drawn(uncertainties, between, engine));
    const double coverage = ScatterCoverage(mean.variance, mean.scatter_variance,
                                            static_cast<double>(uncertainties.size()) - 1);
    held += std::abs(mean.value) < coverage * std::sqrt(mean.variance) ? 1 : 0;
  }
  return 100.0 * held / kSets;
}

TEST(ConsensusMean, IntervalsHoldTheCommonValueOfAlikeAndOfDifferentTaps) {
  for (const std::size_t count : {2UL, 4UL, 6UL}) {
    for (const double ratio : {1.0, 8.0}) {
      for (const double scatter : {0.0, 50.0}) {
        const double held = Held(From1To(ratio, count), scatter * ratio);
        EXPECT_GE(held, 93) << count << " taps 1:" << ratio << ", scatter " << scatter;
        EXPECT_LE(held, 97) << count << " taps 1:" << ratio << ", scatter " << scatter;
      }
    }
  }
}

}  // namespace
}  // namespace haptometer::fit
