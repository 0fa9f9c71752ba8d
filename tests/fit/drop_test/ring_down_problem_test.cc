#include "fit/drop_test/ring_down_problem.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/fit/synthetic_drop.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using tests::kOpen;

RingDownSamples Samples(double load_ohm, double mass_ratio) {
  RingDownSamples samples;
  for (int n = 0; n < 40; ++n) {
    samples.times_s.push_back(1e-3 + 3.1e-4 * n);
    samples.voltages_v.push_back(0.01 * n);
  }
  samples.noise_v = 0.1;
  samples.load_ohm = load_ohm;
  samples.mass_ratio = mass_ratio;
  samples.polarity = load_ohm > 100 ? 1 : -1;
  samples.drifts = true;
  samples.hum_hz = {50};
  return samples;
}

RingDownPoint Point() {
  RingDownPoint point;
  point.shared = {std::log(2800), std::log(0.0322), 1.21, std::log(1.4e-3), std::log(27)};
  point.own = {{std::log(0.484), 2e-5, 0.01, 0, 0, 0}, {std::log(0.44), -3e-5, -0.02, 0, 0, 0}};
  return point;
}

// all but Km, mass, resistance and `held`
std::vector<bool> FreeColumns(std::size_t records, const std::vector<std::size_t>& held) {
  std::vector<bool> is_free(kSharedCount + kOwnCount * records, true);
  for (const Shared k : {Shared::kForceConstantSquared, Shared::kMass, Shared::kResistance}) {
    is_free[Index(k)] = false;
  }
  for (std::size_t r = 0; r < records; ++r) {
    is_free[Column(r, Own::kStiffness)] = false;
    is_free[Column(r, Own::kDamping)] = false;
  }
  for (const std::size_t k : held) is_free[k] = false;
  return is_free;
}

TEST(RingDownProblem, DerivativesAreThoseOfFiniteDifferences) {
  for (const double damping : {0.0322, 2 * std::sqrt(2800 * 1.4e-3)}) {
    SCOPED_TRACE(damping);
    std::vector records{Samples(kOpen, 1), Samples(33, 0.3), Samples(50, 1)};
    records[2].speed_m_per_s = 0.44;
    for (auto& record : records) record.hum_hz = {50, 100, 150, 250};
    // drops that scatter, the one in both rates
    records[0].damping_scatter = 0.02;
    records[1].stiffness_scatter = 0.01;
    records[1].damping_scatter = 0.03;
    const RingDownProblem problem(records, 130e-6);
    auto point = Point();
    point.own.push_back({0, 1e-5, 0.03, 0.1, 1e-3, 1e-3});
    point.shared[Index(Shared::kDamping)] = std::log(damping);
    point.own[0] = {std::log(0.44), 2e-5, 0.01, 0.3, 2e-3, -4e-3};
    point.own[0][Index(Own::kDamping)] = -0.01;
    point.own[1][Index(Own::kStiffness)] = 0.003;
    const auto jacobian = problem.Linearise(point);
    ASSERT_EQ(jacobian.columns, kSharedCount + 3 * kOwnCount);
    ASSERT_EQ(problem.ScatterRows(), 3);
    const auto residuals = problem.Residuals(point);
    for (std::size_t n = 0; n < residuals.size(); ++n) {
      EXPECT_ABS(jacobian.residuals[n], residuals[n], 1e-14, "the same operations");
    }
    const std::vector<double> own(residuals.end() - 3, residuals.end());
    EXPECT_THAT(own, ::testing::ElementsAre(-0.01 / 0.02, 0.003 / 0.01, 0.0));
    for (std::size_t k = 0; k < jacobian.columns; ++k) {
      const auto component = [k](RingDownPoint& p) -> double& {
        if (k < kSharedCount) return p.shared[k];
        return p.own[(k - kSharedCount) / kOwnCount][(k - kSharedCount) % kOwnCount];
      };
      // fourth-order central differences; the impact's time is worth a thousandth of the others
      const bool is_time =
          k >= kSharedCount && (k - kSharedCount) % kOwnCount == Index(Own::kImpact);
      const double step = is_time ? 1e-7 : 1e-4;
      std::array<std::vector<double>, 4> moved;
      constexpr std::array kMultiples{-2.0, -1.0, 1.0, 2.0};
      for (std::size_t m = 0; m < 4; ++m) {
        auto at = point;
        component(at) += kMultiples[m] * step;
        moved[m] = problem.Residuals(at);
      }
      double worst = 0;
      double scale = 0;
      for (std::size_t n = 0; n < jacobian.rows; ++n) {
        const double difference =
            (moved[0][n] - 8 * moved[1][n] + 8 * moved[2][n] - moved[3][n]) / (12 * step);
        worst = std::max(worst, std::abs(jacobian.values[n * jacobian.columns + k] - difference));
        scale = std::max(scale, std::abs(difference));
      }
      if (k == Column(2, Own::kAmplitude)) {
        EXPECT_EQ(moved[0], moved[3]) << "with a given speed the amplitude is not the record's own";
        EXPECT_EQ(worst, scale) << "no derivative either";
      } else {
        EXPECT_ABS(worst / scale, 0.0, 5e-10, "rounding 1e-16 over the step");
      }
    }
  }
}

TEST(RingDownPoint, ColumnsAreTheSharedNumbersThenEachRecordsOwn) {
  const RingDownPoint point = Point();
  const std::vector<double> columns = ToColumns(point);
  ASSERT_EQ(columns.size(), kSharedCount + 2 * kOwnCount);
  EXPECT_EQ(columns[Index(Shared::kResistance)], std::log(27));
  EXPECT_EQ(columns[Column(1, Own::kImpact)], -3e-5);
  const RingDownPoint again = FromColumns(columns);
  EXPECT_EQ(again.shared, point.shared);
  EXPECT_EQ(again.own, point.own);
}

TEST(RingDownProblem, PolesMoveAsByFiniteDifferences) {
  const RingDownProblem problem({Samples(kOpen, 1), Samples(33, 0.3)}, 130e-6);
  const auto point = Point();
  for (std::size_t r = 0; r < 2; ++r) {
    const RecordPoles at = problem.Poles(point, r);
    for (std::size_t k = 0; k < kSharedCount; ++k) {
      constexpr double kStep = 1e-5;
      auto more = point;
      auto less = point;
      more.shared[k] += kStep;
      less.shared[k] -= kStep;
      const PolePair above = problem.Poles(more, r).poles;
      const PolePair below = problem.Poles(less, r).poles;
      EXPECT_ABS(at.decay_slopes[k] / at.poles.decay_per_s,
                 (above.decay_per_s - below.decay_per_s) / (2 * kStep) / at.poles.decay_per_s, 1e-9,
                 "a step of 1e-5, squared; rounding over it");
      EXPECT_ABS(at.stiffness_slopes[k] / at.poles.stiffness_per_s2,
                 (above.stiffness_per_s2 - below.stiffness_per_s2) / (2 * kStep) /
                     at.poles.stiffness_per_s2,
                 1e-9, "the same");
    }
  }
  EXPECT_REL(problem.Poles(point, 0).poles.decay_per_s, 0.0322 / 2.8e-3, 1e-15, "Bv/2M, open");
}

TEST(RingDownProblem, HeldParametersStay) {
  const RingDownProblem problem({Samples(kOpen, 1), Samples(33, 1)}, 0);
  auto point = Point();
  const auto before = point;
  const auto report = problem.Minimise(FreeColumns(2, {Column(0, Own::kAmplitude)}), &point);
  EXPECT_GT(report.iterations, 1);
  EXPECT_EQ(point.shared[Index(Shared::kForceConstantSquared)],
            before.shared[Index(Shared::kForceConstantSquared)]);
  EXPECT_EQ(point.shared[Index(Shared::kMass)], before.shared[Index(Shared::kMass)]);
  EXPECT_EQ(point.own[0][Index(Own::kAmplitude)], before.own[0][Index(Own::kAmplitude)]);
  EXPECT_NE(point.own[1][Index(Own::kAmplitude)], before.own[1][Index(Own::kAmplitude)]);
  EXPECT_NE(point.shared[Index(Shared::kStiffness)], before.shared[Index(Shared::kStiffness)]);
}

TEST(RingDownProblem, VoltagesBeginWithThePolarity) {
  const RingDownProblem problem({Samples(kOpen, 1), Samples(33, 1)}, 130e-6);
  const auto point = Point();
  EXPECT_REL(problem.Voltages(point, 0, {2e-5})[0], 0.01 + 0.484, 1e-12, "Km v0 + offset");
  // the loaded coil's current needs 2 us; a divider of 33/60 and -1 after that
  EXPECT_REL(problem.Voltages(point, 1, {1e-5})[0], -0.02 - 0.44 * 33 / 60, 3e-3,
             "cosine of 40 us");
}

TEST(RingDownProblem, ReachesTheMinimumFromThirtyPercentAway) {
  for (const double away : {0.7, 0.85, 1.15, 1.3}) {
    SCOPED_TRACE(away);
    const RingDownProblem scratch({Samples(kOpen, 1)}, 0);
    RingDownPoint truth;
    truth.shared = Point().shared;
    truth.own = {{std::log(0.44), 2e-5, 0.01, 0.3, 2e-3, -4e-3}};
    auto samples = Samples(kOpen, 1);
    samples.voltages_v = scratch.Voltages(truth, 0, samples.times_s);
    const RingDownProblem problem({samples}, 0);
    auto point = truth;
    point.shared[Index(Shared::kStiffness)] += std::log(away);
    point.shared[Index(Shared::kDamping)] += std::log(10.0);
    const auto report = problem.Minimise(FreeColumns(1, {}), &point);
    EXPECT_TRUE(report.converged) << report.termination;
    EXPECT_REL(std::exp(point.shared[0]), 2800.0, 1e-12, "noise-free");
    EXPECT_REL(std::exp(point.shared[1]), 0.0322, 1e-11, "noise-free");
    EXPECT_REL(point.own[0][Index(Own::kDrift)], 0.3, 1e-9, "noise-free");
    EXPECT_REL(point.own[0][Index(Own::kHumSine)], -4e-3, 1e-9, "noise-free");
  }
}

TEST(RingDownProblem, DriftCountsFromTheMiddleOfTheSamples) {
  for (const bool hums : {false, true}) {
    auto samples = Samples(kOpen, 1);
    if (!hums) samples.hum_hz.clear();
    const RingDownProblem problem({samples}, 0);
    RingDownPoint still;
    still.shared = Point().shared;
    still.own = {{std::log(0.44), 2e-5, 0.01, 0, 0, 0}};
    auto drifting = still;
    drifting.own[0][Index(Own::kDrift)] = 0.3;
    const double middle_s = (samples.times_s.front() + samples.times_s.back()) / 2;
    const std::vector<double> times_s{middle_s, middle_s + 2e-3};
    const auto without = problem.Voltages(still, 0, times_s);
    const auto with = problem.Voltages(drifting, 0, times_s);
    EXPECT_ABS(with[0] - without[0], 0.0, 1e-15, "rounding");
    EXPECT_ABS(with[1] - without[1], 0.3 * 2e-3, 1e-15, "rounding");
  }
}

TEST(RingDownProblem, HumIsACosineAndASineOfTheRecordsTime) {
  const RingDownProblem problem({Samples(kOpen, 1)}, 0);
  RingDownPoint still;
  still.shared = Point().shared;
  still.own = {{std::log(0.44), 2e-5, 0.01, 0, 0, 0}};
  auto humming = still;
  humming.own[0][Index(Own::kHumCosine)] = 0.02;
  humming.own[0][Index(Own::kHumSine)] = 0.03;
  for (const double time_s : {0.0, 0.005, 0.0123}) {
    const double angle = 2 * M_PI * 50 * time_s;
    EXPECT_ABS(problem.Voltages(humming, 0, {time_s})[0] - problem.Voltages(still, 0, {time_s})[0],
               0.02 * std::cos(angle) + 0.03 * std::sin(angle), 1e-15, "rounding");
  }
}

}  // namespace
}  // namespace haptometer::fit
