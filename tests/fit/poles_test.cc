#include "fit/poles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"
#include "sim/ring_down.h"
#include "tests/fit/fitted_drops.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

std::vector<double> Decay(const PolePair& poles, double step_s, std::size_t count,
                          double noise = 0) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  std::vector<double> values(count);
  for (std::size_t n = 0; n < count; ++n) {
    const auto pair = sim::DampedFundamentals(poles.decay_per_s, poles.stiffness_per_s2,
                                              static_cast<double>(n) * step_s);
    values[n] = 0.4 * pair.even - 5.0 * pair.odd + noise * normal(engine);
  }
  return values;
}

TEST(StrongestFrequency, IsTheLineNearestToTheTone) {
  const PolePair poles{11.5, 2e6};
  const auto frequency_hz = StrongestFrequency(Decay(poles, 1e-4, 2500), 1e-4);
  ASSERT_TRUE(frequency_hz);
  EXPECT_ABS(*frequency_hz, 225.07, 0.5 * 1e4 / 8192, "half a line of the padded spectrum");
}

TEST(StrongestFrequency, NeedsSixteenSamplesThatDiffer) {
  EXPECT_FALSE(StrongestFrequency(std::vector<double>(15, 1.0), 1e-3));
  EXPECT_FALSE(StrongestFrequency(std::vector<double>(100, 0.0), 1e-3));
}

TEST(EstimatePoles, IsExactWithoutNoise) {
  // block means of a sum of exponentials are such a sum themselves, so nothing is lost by them
  for (const double step_s : {5e-4, 1e-4, 2e-6}) {
    const auto poles =
        EstimatePoles(Decay({11.5, 2e6}, step_s, static_cast<std::size_t>(0.25 / step_s)), step_s);
    ASSERT_TRUE(poles);
    EXPECT_REL(poles->decay_per_s, 11.5, 2e-13, "SVD of 240 samples, zeta 0.008");
    EXPECT_REL(poles->stiffness_per_s2, 2e6, 1e-14, "SVD of 240 samples");
  }
}

TEST(EstimatePoles, KeepsADoublePole) {
  const double w = 1414.0;
  for (const double zeta : {0.5, 0.99, 1.0, 1.01, 2.0}) {
    SCOPED_TRACE(zeta);
    const auto poles = EstimatePoles(Decay({zeta * w, w * w}, 5e-5, 400), 5e-5);
    ASSERT_TRUE(poles);
    EXPECT_REL(poles->decay_per_s, zeta * w, 1e-10, "trace and determinant stay well conditioned");
    EXPECT_REL(poles->stiffness_per_s2, w * w, 1e-10,
               "trace and determinant stay well conditioned");
  }
}

TEST(EstimatePoles, StaysNearTheBoundInNoise) {
  // noise 1 % of the amplitude, 2500 samples in 0.25 s: the bound is 0.14 % for the decay
  const auto poles = EstimatePoles(Decay({11.5, 2e6}, 1e-4, 2500, 4e-3), 1e-4);
  ASSERT_TRUE(poles);
  EXPECT_REL(poles->decay_per_s, 11.5, 0.005, "3.5 standard deviations of the bound");
  EXPECT_REL(std::sqrt(poles->stiffness_per_s2), std::sqrt(2e6), 4e-5, "4 of 11 ppm");
}

TEST(EstimatePoles, FallsBackOnTheSpectrumInHeavyNoise) {
  // twice as much noise as signal: the line is still there
  const auto poles = EstimatePoles(Decay({11.5, 2e6}, 1e-4, 2500, 0.8), 1e-4);
  ASSERT_TRUE(poles);
  EXPECT_GT(poles->decay_per_s, 0);
  EXPECT_REL(std::sqrt(poles->stiffness_per_s2) / (2 * std::numbers::pi), 225.07, 0.05,
             "the fit reaches 30 %");
}

using tests::Fit;
using tests::MakeRecord;
using tests::SyntheticDrop;
using tests::ThesisKnowns;

// (place - pole)' covariance^-1 (place - pole)
double SquareDistance(const UncertainPole& pole, const PolePlace& place) {
  const auto& c = pole.covariance;
  const double x = place.frequency_hz - pole.frequency_hz;
  const double y = place.decay_per_s - pole.decay_per_s;
  return (c[1][1] * x * x - 2 * c[0][1] * x * y + c[0][0] * y * y) /
         (c[0][0] * c[1][1] - c[0][1] * c[0][1]);
}

constexpr double kTwoOfNinetyFive =
    5.991464547107979;  // chi-squared, 2 degrees, R's qchisq(0.95,2)

TEST(EllipseOf, IsTheRegionOfNinetyFivePercent) {
  const UncertainPole pole{225, 11.5, {{{4e-6, -3e-5}, {-3e-5, 9e-4}}}, true};
  const auto ellipse = EllipseOf(pole, 48);
  ASSERT_EQ(ellipse.size(), 49U);
  for (const PolePlace& place : ellipse) {
    EXPECT_REL(SquareDistance(pole, place), kTwoOfNinetyFive, 1e-9, "2e-3 of 225 cancels");
  }
  EXPECT_EQ(ellipse.front().frequency_hz, ellipse.back().frequency_hz);
  EXPECT_EQ(ellipse.front().decay_per_s, ellipse.back().decay_per_s);
  const auto [left, right] = std::ranges::minmax(ellipse, {}, &PolePlace::frequency_hz);
  EXPECT_REL(right.frequency_hz - left.frequency_hz, 2 * std::sqrt(kTwoOfNinetyFive) * 2e-3, 1e-9,
             "points lie on the axis");
}

TEST(EllipseOf, ACovarianceOfOneDirectionIsALine) {
  const UncertainPole pole{225, 11.5, {{{4e-6, 6e-5}, {6e-5, 9e-4}}}, true};
  for (const PolePlace& place : EllipseOf(pole, 16)) {
    EXPECT_ABS(place.decay_per_s - 11.5, 15 * (place.frequency_hz - 225), 1e-9, "0.03 over 2e-3");
  }
  const UncertainPole exact{225, 11.5, {}, true};
  EXPECT_EQ(EllipseOf(exact, 3)[1].frequency_hz, 225);
}

PolePlace Truth(const SyntheticDrop& drop) {
  const sim::RingDown<double> circuit({drop.stiffness_n_per_m, drop.damping_n_s_per_m,
                                       drop.force_constant_n_per_a * drop.force_constant_n_per_a,
                                       tests::EffectiveMass(drop), drop.resistance_ohm,
                                       drop.inductance_h, drop.load_ohm});
  const double decay = circuit.decay_per_s();
  return {std::sqrt(circuit.stiffness_per_s2() - decay * decay) / (2 * std::numbers::pi), decay};
}

TEST(PoleOfARecord, IsThatOfItsCircuit) {
  SyntheticDrop loaded;
  loaded.load_ohm = 33;
  SyntheticDrop free;
  free.condition = CaseCondition::kFree;
  const auto fit = Fit({MakeRecord({}), MakeRecord(loaded), MakeRecord(free)});
  const std::array drops{SyntheticDrop{}, loaded, free};
  for (std::size_t r = 0; r < drops.size(); ++r) {
    const FittedRecord& record = fit.records[r];
    ASSERT_TRUE(record.pole.determined);
    EXPECT_REL(record.pole.frequency_hz, Truth(drops[r]).frequency_hz, 1e-13, "noise-free");
    EXPECT_REL(record.pole.decay_per_s, Truth(drops[r]).decay_per_s, 1e-12, "noise-free");
    // the start is the record's own pole, of means over a sixteenth of a period
    EXPECT_REL(record.start.decay_per_s, Truth(drops[r]).decay_per_s, 1e-2, "a start");
    EXPECT_REL(std::sqrt(record.start.stiffness_per_s2) / (2 * std::numbers::pi),
               Truth(drops[r]).frequency_hz, 1e-3, "a start");
  }
}

TEST(PoleOfARecord, HasTheUncertaintyOfTheConstantsThatMakeIt) {
  // an open, held record: d = Bv/2M, f = sqrt(Kv/M - d^2)/2pi with d/w = 0.008; the mass moves none
  SyntheticDrop drop;
  drop.noise_v = 3e-3;
  auto knowns = ThesisKnowns();
  knowns.moving_mass_kg = Quantity{1.4e-3, 3e-5};
  const auto fit = Fit({MakeRecord(drop)}, knowns);
  const UncertainPole& pole = fit.records[0].pole;
  const auto share = [](const FittedValue& value) {
    return value.combined_standard_uncertainty / value.value;
  };
  EXPECT_REL(std::sqrt(pole.covariance[1][1]) / pole.decay_per_s, share(fit.damping_over_mass),
             1e-6, "the same sums; the mass by differences of 1e-6");
  EXPECT_REL(std::sqrt(pole.covariance[0][0]) / pole.frequency_hz, share(fit.natural_frequency),
             0.01, "d moves f by d^2/w^2 = 7e-5 times 123 of its share");
  EXPECT_EQ(pole.covariance[0][1], pole.covariance[1][0]);
}

TEST(PoleOfARecord, FollowsTheClockThatIsStated) {
  SyntheticDrop drop;
  auto record = MakeRecord(drop);
  record.time_scale = Quantity{1.01, 1e-3};
  const auto fit = Fit({record});
  const FittedRecord& fitted = fit.records[0];
  EXPECT_REL(fitted.pole.frequency_hz, 1.01 * Truth(drop).frequency_hz, 1e-12, "noise-free");
  EXPECT_REL(std::sqrt(fitted.start.stiffness_per_s2) / (2 * std::numbers::pi),
             1.01 * Truth(drop).frequency_hz, 1e-3, "a start");
  EXPECT_REL(std::sqrt(fitted.pole.covariance[0][0]) / fitted.pole.frequency_hz, 1e-3 / 1.01, 1e-6,
             "all of it is the clock's");
}

TEST(PoleOfARecord, IsNoneWhereNothingOscillates) {
  SyntheticDrop drop;
  drop.damping_n_s_per_m = 3 * std::sqrt(2800 * 1.4e-3);
  drop.step_s = 2e-5;
  drop.length_s = 0.02;
  // an aperiodic motion is refused unless a height says what began it (ring_evidence.h)
  EXPECT_FALSE(FitDropTest({MakeRecord(drop)}, tests::ThesisKnowns()));
  const auto fit = Fit({tests::MakeRecordWithHeight(drop)});
  ASSERT_FALSE(fit.records.empty());
  EXPECT_FALSE(fit.records[0].pole.determined);
  EXPECT_EQ(fit.records[0].damped_frequency_hz, 0);
}

TEST(PoleOfARecord, TheEllipseHoldsTheTruth) {
  // 50 pairs: each pole within its 95 % region 43 times at least (binomial, 2.9 deviations), and
  // not in a region so wide that it misses none of 100
  constexpr int kPairs = tests::kIsSanitized ? 4 : 50;
  std::array<int, 2> held{};
  for (unsigned k = 0; k < kPairs; ++k) {
    std::array<SyntheticDrop, 2> drops;
    for (std::size_t r = 0; r < 2; ++r) {
      drops[r].step_s = 5e-4;
      drops[r].length_s = 0.2;
      drops[r].noise_v = 5e-3;
      drops[r].seed = 5000 + 2 * k + static_cast<unsigned>(r);
    }
    drops[1].load_ohm = 33;
    const auto fit = Fit({MakeRecord(drops[0]), MakeRecord(drops[1])});
    for (std::size_t r = 0; r < 2; ++r) {
      const bool inside = SquareDistance(fit.records[r].pole, Truth(drops[r])) <= kTwoOfNinetyFive;
      held[r] += inside ? 1 : 0;
    }
  }
  for (const int inside : held)
    EXPECT_GE(inside, kPairs * 88 / 100 - (tests::kIsSanitized ? 1 : 0));
}

TEST(ResidualOfARecord, IsTheSampleLessTheClosedForm) {
  SyntheticDrop drop;
  auto record = MakeRecord(drop);
  record.voltage_v[130] = std::nan("");
  record.voltage_v[400] += 1e-3;  // 5 of 1240 samples' own weight: the fit hardly follows
  const auto fit = Fit({record});
  const FittedRecord& fitted = fit.records[0];
  ASSERT_EQ(fitted.first_sample + fitted.residual_v.size(), record.voltage_v.size());
  ASSERT_EQ(fitted.model_v.size(), fitted.residual_v.size());
  const auto clean = MakeRecord(drop);
  double square = 0;
  std::size_t samples = 0;
  for (std::size_t n = 0; n < fitted.residual_v.size(); ++n) {
    const std::size_t row = fitted.first_sample + n;
    EXPECT_ABS(fitted.model_v[n], clean.voltage_v[row], 1e-5, "the disturbed sample moves the fit");
    if (row == 130) {
      EXPECT_TRUE(std::isnan(fitted.residual_v[n]));
      continue;
    }
    EXPECT_ABS(fitted.residual_v[n], row == 400 ? 1e-3 : 0.0, 1e-5, "the same");
    square += fitted.residual_v[n] * fitted.residual_v[n];
    ++samples;
  }
  EXPECT_EQ(samples, fitted.samples);
  EXPECT_REL(std::sqrt(square / static_cast<double>(samples)), fitted.residual_rms_v, 1e-12,
             "the same sum");
}

}  // namespace
}  // namespace haptometer::fit
