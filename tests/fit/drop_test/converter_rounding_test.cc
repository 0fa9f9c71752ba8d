// Intervals of records of a few converter steps, whose rounding errors follow the ringing.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/ring_down_problem.h"
#include "tests/fit/fitted_drops.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/repetitions.h"

namespace haptometer::fit {
namespace {

// Fourier series of a converter's mean error (Widrow and Kollar, Quantization Noise, 2008, 5.3):
// sum over k of (-1)^k/(pi k) exp(-2 (pi k s)^2) sin(2 pi k x)
double SeriesOfMeanError(double x, double noise) {
  double sum = 0;
  for (int k = 1; k < 200; ++k) {
    const double angle = std::numbers::pi * k;
    sum += (k % 2 == 0 ? 1 : -1) / angle * std::exp(-2 * std::pow(angle * noise, 2)) *
           std::sin(2 * angle * x);
  }
  return sum;
}

TEST(ConverterRounding, MeanErrorIsTheSeriesOfIt) {
  for (const double noise : {0.02, 0.1, 0.2, 0.35, 0.5}) {
    for (const double x : {-3.7, -0.5, 0.0, 0.1, 0.49, 0.5, 0.9, 7.3}) {
      // the series ends where its terms are below 1e-100; 5 deviations of noise are summed: 3e-7
      EXPECT_NEAR(MeanRoundingError(x, noise), SeriesOfMeanError(x, noise), 4e-7)
          << x << ' ' << noise;
    }
  }
}

TEST(ConverterRounding, WithoutNoiseItIsTheRoundingError) {
  for (const double x : {-3.7, -0.4, 0.0, 0.1, 0.49, 0.9, 7.3}) {
    EXPECT_DOUBLE_EQ(MeanRoundingError(x, 0), std::floor(x + 0.5) - x);
  }
}

// drops of Q 2 to 6 with 12 to 20 steps, where Bv and its 95 % interval are asked for
struct Coarse {
  double quality = 3;
  double steps = 20;  // of the first voltage
  double noise_steps = 0;
};

tests::SyntheticDrop CoarseDrop(const Coarse& coarse, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  tests::SyntheticDrop drop;
  drop.damping_n_s_per_m = std::sqrt(drop.stiffness_n_per_m * drop.moving_mass_kg) / coarse.quality;
  drop.step_s = 5e-5;
  drop.length_s = 0.1;
  drop.height_m = 0.01 * (1 + 0.1 * place(engine));
  drop.step_v = tests::SpeedVoltage(drop) / coarse.steps;
  drop.offset_v = drop.step_v * place(engine);
  drop.impact_s = drop.step_s * (0.5 + place(engine));
  drop.noise_v = coarse.noise_steps * drop.step_v;
  drop.seed = seed;
  return drop;
}

TEST(ConverterRounding, IntervalsOfAFewStepsHoldTheDamping) {
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 2 : 30);
  ActuatorKnowns knowns;
  knowns.moving_mass_kg = Quantity{1.4e-3, 0};
  for (const Coarse& coarse : {Coarse{2, 20, 0.0},
                               {2, 20, 0.2},
                               {3, 20, 0.1},
                               {3, 12, 0.0},
                               {3, 12, 0.2},
                               {6, 20, 0.0},
                               {6, 12, 0.1}}) {
    int held = 0;
    int fitted = 0;
    for (int k = 0; k < repetitions; ++k) {
      const auto drop = CoarseDrop(coarse, static_cast<unsigned>(k));
      const auto fit = FitDropTest({tests::MakeRecord(drop)}, knowns);
      if (!fit || !fit->damping.determined) continue;
      ++fitted;
      held += fit->damping.lower <= drop.damping_n_s_per_m &&
                      drop.damping_n_s_per_m <= fit->damping.upper
                  ? 1
                  : 0;
    }
    // a true 95 % holds fewer than 26 of 30 once in 65 times (binomial); of others in proportion
    EXPECT_GE(held, fitted - std::ceil(4.0 * fitted / 30))
        << "Q " << coarse.quality << ", " << coarse.steps << " steps, noise " << coarse.noise_steps;
    EXPECT_GE(fitted, 0.9 * repetitions) << "Q " << coarse.quality;
  }
}

TEST(ConverterRounding, WidensKmOfFewStepsByLoads) {
  std::vector<ImpulseRecord> records;
  for (const double load_ohm : {tests::kOpen, tests::kOpen, 33.0, 33.0}) {
    tests::SyntheticDrop drop;
    drop.load_ohm = load_ohm;
    drop.height_m = 0.009 + 0.001 * static_cast<double>(records.size());
    drop.step_s = 1e-4;
    drop.step_v = 0.1;
    records.push_back(tests::MakeRecord(drop));
  }
  const DropTestFit fit = tests::Fit(records);
  ASSERT_TRUE(fit.force_constant.determined);
  EXPECT_LT(fit.force_constant.lower, 1.0);
  EXPECT_GT(fit.force_constant.upper, 1.0);
  // rounding is among the causes, and what no cause explains is nothing
  EXPECT_GT(fit.by_rounding[2], 0.01);
  EXPECT_LT(fit.by_rounding[2] * fit.force_constant.value,
            fit.force_constant.combined_standard_uncertainty);
}

// 200 000 samples, which are averaged: their means show no codes
TEST(ConverterRounding, IsThatOfTheSamplesWhereTheseAreAveraged) {
  tests::SyntheticDrop drop = CoarseDrop({10, 20, 0.2}, 3);
  drop.step_s = 2e-6;
  drop.length_s = 0.4;
  ImpulseRecord record = tests::MakeRecord(drop);
  auto prepared = PrepareDrops(record);
  ASSERT_EQ(prepared.prepared.size(), 1U);
  ASSERT_TRUE(prepared.findings.Has(FindingKind::kThinned));
  ActuatorKnowns knowns;
  knowns.moving_mass_kg = Quantity{1.4e-3, 0};
  const auto fit = FitDropTest(std::move(prepared.prepared), knowns);
  ASSERT_TRUE(fit);
  // of 20 steps at this quality factor some 0.2 %, whatever the rate
  EXPECT_GT(fit->by_rounding[1], 5e-4);
  EXPECT_LT(fit->by_rounding[1], 5e-3);
}

// the median of rounding errors is not a Gaussian's: it is no noise before the converter
TEST(ConverterRounding, IsAsLargeForTheRobustFit) {
  const tests::SyntheticDrop drop = CoarseDrop({6, 16, 0}, 5);
  ActuatorKnowns knowns;
  knowns.moving_mass_kg = Quantity{1.4e-3, 0};
  const auto plain = FitDropTest({tests::MakeRecord(drop)}, knowns);
  const auto robust = FitDropTest({tests::MakeRecord(drop)}, knowns, Loss::kHuber);
  ASSERT_TRUE(plain && robust);
  EXPECT_GT(robust->by_rounding[1], 0.8 * plain->by_rounding[1]);
}

TEST(ConverterRounding, IsNoneInNoiseOfAStep) {
  tests::SyntheticDrop drop;
  drop.step_v = 0.01;
  drop.noise_v = 0.01;
  const DropTestFit fit = tests::Fit({tests::MakeRecord(drop)});
  EXPECT_EQ(fit.by_rounding[1], 0);
  // and none of a record without steps
  drop.step_v = 0;
  EXPECT_EQ(tests::Fit({tests::MakeRecord(drop)}).by_rounding[1], 0);
}

}  // namespace
}  // namespace haptometer::fit
