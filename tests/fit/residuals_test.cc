#include "fit/residuals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "dsp/statistics/distributions.h"
#include "fit/drop_test/drop_test_fit.h"
#include "tests/findings.h"
#include "tests/fit/pulls.h"
#include "tests/fit/synthetic_drop.h"
#include "tests/fit/unprepared_drops.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

constexpr double kStepS = 1e-4;
constexpr double kResonanceHz = 225;

// x[n] = share x[n-1] + white noise
std::vector<double> Noise(double share, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<double> noise(20'000);
  double last = 0;
  for (double& x : noise) x = last = share * last + normal(engine);
  return noise;
}

TEST(ResidualDensity, OfWhiteNoiseIsOne) {
  int coloured = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const auto density = DensityAt(Noise(0, seed), kStepS, kResonanceHz);
    EXPECT_ABS(density.ratio, 1.0, 4 / std::sqrt(450.0), "450 lines, four deviations");
    coloured += density.is_coloured ? 1 : 0;
  }
  EXPECT_LE(coloured, 3) << "1 % of white records";
}

TEST(ResidualDensity, OfFilteredNoiseIsThatOfTheFilter) {
  // at frequencies far below the corner (1-a^2)/(1-a)^2 = (1+a)/(1-a) of the white density
  const auto density = DensityAt(Noise(0.5, 1), kStepS, kResonanceHz);
  EXPECT_TRUE(density.is_coloured);
  EXPECT_REL(density.ratio, 3.0, 0.2, "450 lines, four deviations");
}

TEST(ResidualDensity, NeedsLinesAndABandBelowHalfTheRate) {
  const auto noise = Noise(0.5, 1);
  EXPECT_EQ(DensityAt(noise, kStepS, 4000).ratio, 1);
  EXPECT_EQ(DensityAt({noise.begin(), noise.begin() + 300}, kStepS, kResonanceHz).ratio, 1)
      << "6.75 lines in the band";
  // too few lines for a tone in the middle of its band
  for (const std::size_t count : {1U, 15U}) {
    std::vector<double> tone(count);
    for (std::size_t n = 0; n < count; ++n) tone[n] = n % 4 < 2 ? 1 : -1;
    EXPECT_EQ(DensityAt(tone, 1, 0.25).ratio, 1) << count;
  }
  EXPECT_EQ(DensityAt(std::vector<double>(1000, 0.0), kStepS, kResonanceHz).ratio, 1);
}

using tests::SyntheticDrop;

std::vector<double> Normal(std::size_t count) {
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  std::vector<double> values(count);
  for (double& value : values) value = normal(engine);
  return values;
}

TEST(Huber, TheScaleOfNormalResidualsIsTheirDeviation) {
  const auto values = Normal(40'000);
  EXPECT_ABS(RobustScale(values), 1.0, 0.02, "1.17/sqrt(2 n) is its own deviation");
  auto spoiled = values;
  for (std::size_t n = 0; n < spoiled.size(); n += 10) spoiled[n] = 1e6;
  EXPECT_ABS(RobustScale(spoiled), 1.14, 0.03, "quantile 5/9 of |t| in place of 1/2");
}

TEST(Huber, WeightsAreAFixedForceBeyondTheBend) {
  const std::vector<double> residuals{0, 2, -2.69, 26.9, -269};
  const auto roots = HuberRootWeights(residuals, 2);
  EXPECT_EQ(roots[0], 1.0);
  EXPECT_EQ(roots[1], 1.0);
  EXPECT_REL(roots[2] * roots[2], 1.0, 1e-15, "at the bend");
  EXPECT_REL(roots[3] * roots[3], 0.1, 1e-15, "rounding");
  EXPECT_REL(roots[4] * roots[4], 0.01, 1e-15, "rounding");
}

TEST(Huber, NormalNoiseCostsFivePercent) {
  // E[psi^2]/(E[psi'])^2 of the normal distribution is 1/0.95 (Huber 1964, table 1), mean(w) 0.96
  const double variance = HuberVariance(Normal(400'000), 0);
  EXPECT_ABS(variance, 0.9587 / 0.95, 0.01, "400 000 draws");
}

TEST(Huber, WithoutFarSamplesTheFitIsTheSame) {
  const auto fit =
      FitDropTest({tests::MakeRecordWithHeight({})}, tests::ThesisKnowns(), Loss::kHuber);
  ASSERT_TRUE(fit);
  EXPECT_TRUE(fit->converged);
  EXPECT_REL(fit->stiffness.value, 2800.0, 1e-12, "noise-free");
  EXPECT_REL(fit->damping.value, 0.0322, 1e-11, "noise-free");
  EXPECT_REL(fit->force_constant.value, 1.0, 1e-12, "noise-free");
}

SyntheticDrop NoisyDrop(int seed, double load_ohm) {
  SyntheticDrop drop;
  drop.noise_v = 0.01 * tests::SpeedVoltage(drop);
  drop.load_ohm = load_ohm;
  drop.seed = static_cast<unsigned>(seed);
  return drop;
}

// every fiftieth sample up to half of the amplitude off, as where a switch sparks nearby
ImpulseRecord Spoiled(const SyntheticDrop& drop) {
  auto record = tests::MakeRecord(drop);
  std::mt19937_64 engine(drop.seed + 1000);
  std::uniform_real_distribution<double> where;
  for (double& v : record.voltage_v) {
    if (where(engine) > 0.02) continue;
    v += (where(engine) - 0.5) * tests::SpeedVoltage(drop);
  }
  return record;
}

TEST(Huber, SpikesHardlyMoveTheFitAndAreCovered) {
  // of clean records, by least squares: the bound for these
  tests::Pulls clean;
  tests::Pulls squares;
  tests::Pulls stiffness;
  tests::Pulls damping;
  tests::Pulls force;
  for (int k = 0; k < tests::Repetitions(tests::kIsSanitized ? 4 : 40); ++k) {
    const auto open = NoisyDrop(2 * k + 1, tests::kOpen);
    const auto loaded = NoisyDrop(2 * k + 2, 33);
    const auto fit_of = [&](auto make, Loss loss) {
      auto fit = FitDropTest({make(open), make(loaded)}, tests::ThesisKnowns(), loss);
      EXPECT_TRUE(fit && fit->converged) << (fit ? "" : fit.error().Text());
      return fit ? *fit : DropTestFit{};
    };
    const auto plain = fit_of(tests::MakeRecord, Loss::kSquares).damping;
    clean.Add(plain.value, 0.0322, plain.standard_uncertainty);
    const auto moved = fit_of(Spoiled, Loss::kSquares).damping;
    squares.Add(moved.value, 0.0322, moved.standard_uncertainty);
    const auto fit = fit_of(Spoiled, Loss::kHuber);
    stiffness.Add(fit.stiffness.value, 2800, fit.stiffness.standard_uncertainty);
    damping.Add(fit.damping.value, 0.0322, fit.damping.standard_uncertainty);
    force.Add(fit.force_constant.value, 1, fit.force_constant.standard_uncertainty);
    ASSERT_FALSE(fit.records.empty());
    EXPECT_GT(fit.records[0].drawn_samples, 10U);
  }
  if (tests::kIsSanitized) return;
  const double slack = 2.5 / std::sqrt(2.0 * damping.count());
  std::printf("  Bv: RMSE over that of clean records %.3f, by squares %.2f\n",
              damping.rms() / clean.rms(), squares.rms() / clean.rms());
  EXPECT_LE(damping.rms() / clean.rms(), 1.15 + slack);
  EXPECT_GE(squares.rms() / clean.rms(), 2.0) << "least squares are moved";
  for (const auto* pulls : {&stiffness, &damping, &force}) {
    std::printf("  pulls %.3f +- %.3f\n", pulls->mean(), pulls->deviation());
    EXPECT_ABS(pulls->mean(), 0.0, 0.15 + std::sqrt(2.0) * slack, "of so many pulls");
    EXPECT_ABS(pulls->deviation(), 1.0, 0.1 + slack, "of so many pulls");
  }
}

TEST(LookAtResiduals, FindsThePointThatLiesFarFromTheOthers) {
  std::vector<double> residuals(40);
  for (std::size_t n = 0; n < residuals.size(); ++n) residuals[n] = n % 2 == 0 ? 1 : -1;
  residuals[27] = -20;
  // the second of two kinds: point 7 of 20
  const ResidualLook look = LookAtResiduals(residuals, 20);
  EXPECT_EQ(look.farthest, 7U);
  EXPECT_REL(look.farthest_spread, 20 / 1.4826022185056018, 1e-15, "rounding");
  // every neighbour has the other sign; the pair that changes the kind is none
  const double square = 39 + 400, product = -(36 + 2 * 20);
  EXPECT_REL(look.serial_correlation, product / square * std::sqrt(40.0), 1e-14, "rounding");
}

TEST(LookAtResiduals, SaysNothingOfZeros) {
  const ResidualLook look = LookAtResiduals({0, 0, 0, 0}, 4);
  EXPECT_EQ(look.farthest_spread, 0);
  EXPECT_EQ(look.serial_correlation, 0);
}

// `count` residuals of cosines at whole lines, with an offset and a share of alternating sign
std::vector<double> Tones(std::size_t count, std::size_t inside, double outside_amplitude) {
  std::vector<double> values(count);
  for (std::size_t n = 0; n < count; ++n) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(count);
    values[n] = 0.3 + std::cos(static_cast<double>(inside) * turn + 0.4) +
                outside_amplitude * std::cos(static_cast<double>(2 * inside) * turn + 1.3);
  }
  return values;
}

// line by line up to 3e5 products of lines and samples, by a transform beyond
TEST(ResidualDensity, OfTonesIsTheShareOfTheirPower) {
  for (const std::size_t count : {1000U, 1001U, 5000U, 5001U}) {
    SCOPED_TRACE(count);
    // A resonance near a tenth of the rate: a tone of amplitude a at a line has |X|^2 = (a N/2)^2.
    // Its line is odd, so that the band ends between two lines.
    const std::size_t inside = count / 20 * 2 + 1;
    const double resonance_hz = static_cast<double>(inside) / (static_cast<double>(count) * kStepS);
    const auto first = static_cast<std::size_t>(std::ceil(0.5 * static_cast<double>(inside)));
    const std::size_t end = inside + inside / 2 + 1;
    const double lines = static_cast<double>(end - first);
    const double all = std::floor(static_cast<double>(count) / 2);
    const auto alone = DensityAt(Tones(count, inside, 0), kStepS, resonance_hz);
    EXPECT_REL(alone.ratio, all / lines, 1e-9, "rounding of the tone's lines");
    EXPECT_TRUE(alone.is_coloured);
    const auto beside = DensityAt(Tones(count, inside, 0.7), kStepS, resonance_hz);
    EXPECT_REL(beside.ratio, all / lines / 1.49, 1e-9, "0.7^2 more in all");
    // the line at half the rate is one of all lines; it has no mirror image
    if (count % 2 != 0) continue;
    auto alternating = Tones(count, inside, 0);
    for (std::size_t n = 0; n < count; ++n) alternating[n] += n % 2 == 0 ? 0.5 : -0.5;
    EXPECT_REL(DensityAt(alternating, kStepS, resonance_hz).ratio, all / lines / 2, 1e-9,
               "(0.5 N)^2 more in all");
  }
}

TEST(ResidualDensity, IsColouredBeyondOneWhiteRecordInAHundred) {
  constexpr std::size_t kCount = 2010;
  constexpr std::size_t kInside = 201;
  const double lines = 201;  // from 101 to 301, of 1005
  // 2.33 deviations, each 1/sqrt(lines)
  for (const double excess : {0.99, 1.01}) {
    const double ratio = 1 + excess * 2.33 / std::sqrt(lines);
    const double outside = std::sqrt(1005 / lines / ratio - 1);
    const auto density = DensityAt(Tones(kCount, kInside, outside), kStepS, 1 / (10 * kStepS));
    EXPECT_REL(density.ratio, ratio, 1e-9, "closed form");
    EXPECT_EQ(density.is_coloured, excess > 1);
  }
}

TEST(OnGrid, LeavesZerosWhereThereIsNoSample) {
  const std::vector<double> residuals{1, 2, 3};
  const std::vector<double> times_s{-0.1, 0.1, 0.1999};
  EXPECT_EQ(OnGrid(residuals, times_s, 0.1), (std::vector<double>{1, 0, 2, 3}));
}

TEST(LookAtResiduals, TheFarthestIsTheLargestWhereverItStands) {
  EXPECT_EQ(LookAtResiduals({5, 1, 3, 2}, 4).farthest, 0U);
  EXPECT_EQ(LookAtResiduals({1, -5, 1, 3}, 4).farthest, 1U);
  EXPECT_EQ(LookAtResiduals({1, 2, 3, -5}, 4).farthest, 3U);
  EXPECT_EQ(LookAtResiduals({2, 5, 5, 1}, 4).farthest, 1U) << "of equal ones the first";
}

TEST(DoubtResiduals, BeginsWhereItsLimitsAre) {
  const auto doubts = [](double serial, double spread, double noise) {
    Findings findings;
    DoubtResiduals({.serial_correlation = serial, .farthest = 3, .farthest_spread = spread}, noise,
                   220, findings);
    return tests::DoubtsOf(findings);
  };
  EXPECT_TRUE(doubts(3.49, 7.95, 0.1).empty());
  EXPECT_EQ(doubts(3.51, 7.95, 0.1), std::vector{FindingKind::kResidualsCorrelated});
  EXPECT_EQ(doubts(3.49, 8.05, 0.1), std::vector{FindingKind::kOutlyingPoint});
  EXPECT_TRUE(doubts(-5, 7.95, 0.1).empty()) << "residuals of alternating sign";
  // noise below 1e-9 is rounding
  EXPECT_TRUE(doubts(5, 20, 0.995e-9).empty());
  EXPECT_EQ(doubts(5, 20, 1.005e-9).size(), 2U);
  Findings findings;
  DoubtResiduals({.serial_correlation = 0, .farthest = 3, .farthest_spread = 12.6}, 0.1, 220,
                 findings);
  EXPECT_EQ(tests::NumbersOf(findings, FindingKind::kOutlyingPoint), "frequency_hz=220 spread=13");
}

TEST(Huber, TheVarianceOfFewResidualsIsTheClosedForm) {
  // weights 1, 1, 1 and 0.5: psi 0.5, -1, 1, 1.345; three of four within the bend
  const std::vector<double> residuals{0.5, -1, 1, 2.69};
  const double psi = 0.25 + 1 + 1 + 1.345 * 1.345;
  EXPECT_REL(HuberVariance(residuals, 1), 3.5 / 4 * psi / (4 - 1) / (0.75 * 0.75), 1e-14,
             "rounding");
  EXPECT_REL(HuberVariance(residuals, 0), 3.5 / 4 * psi / 4 / (0.75 * 0.75), 1e-14, "rounding");
  // as many parameters as residuals leave one degree of freedom
  EXPECT_REL(HuberVariance(residuals, 4), 3.5 / 4 * psi / (0.75 * 0.75), 1e-14, "rounding");
}

// one mean of two groups of readings
LeastSquares MeanOf(const std::vector<double>& readings) {
  return {.residuals = readings.size(),
          .parameters = 1,
          .evaluate = [&readings](std::span<const double> at, std::span<double> residuals,
                                  std::span<double> jacobian) {
            for (std::size_t n = 0; n < readings.size(); ++n) residuals[n] = at[0] - readings[n];
            std::ranges::fill(jacobian, 1.0);
            return true;
          }};
}

TEST(SolveGroups, NoisesAreThoseOfTheResidualsWithoutWhatTheMeanTakes) {
  const std::vector<double> readings{0.9, 1.1, 1.05, 0.95, 3, -1, 0.5, 2, 1.9};
  const NoiseGroups groups{{0, 0, 0, 0, 1, 1, 1, 1, 1}, {0, 0}};
  std::vector<double> point{0};
  const auto solution = SolveGroups(MeanOf(readings), groups, {true}, {false}, &point);
  ASSERT_TRUE(solution.solver.converged);
  const double first = 4 / std::pow(solution.noise[0], 2);
  const double second = 5 / std::pow(solution.noise[1], 2);
  // the weighted mean, and s^2 = sum r^2 / (n - n w/(all w))
  EXPECT_REL(point[0], (first * 1.0 + second * 1.28) / (first + second), 1e-5, "converges to 1e-6");
  double squares[]{0, 0};
  for (std::size_t n = 0; n < readings.size(); ++n) {
    squares[groups.group_of[n]] += std::pow(readings[n] - point[0], 2);
  }
  EXPECT_REL(std::pow(solution.noise[0], 2), squares[0] / (4 - first / (first + second)), 1e-5,
             "converges to 1e-6");
  EXPECT_REL(std::pow(solution.noise[1], 2), squares[1] / (5 - second / (first + second)), 1e-5,
             "converges to 1e-6");
  EXPECT_REL(solution.degrees[0] + solution.degrees[1], 8.0, 1e-9, "nine readings, one mean");
}

TEST(SolveGroups, ANoiseIsNeverBelowItsLeast) {
  const std::vector<double> readings{0.9, 1.1, 1.05, 0.95, 3, -1, 0.5, 2, 1.9};
  std::vector<double> point{0};
  const auto solution = SolveGroups(MeanOf(readings), {{0, 0, 0, 0, 1, 1, 1, 1, 1}, {0.5, 0}},
                                    {true}, {false}, &point);
  EXPECT_EQ(solution.noise[0], 0.5);
  EXPECT_GT(solution.noise[1], 1);
}

// C + 2 L and the degrees of freedom of a weighted mean: C = 1/(w + v), a = w C, b = v C
TEST(SolveGroups, TheNoisesOwnUncertaintyWidensAWeightedMean) {
  const std::vector<double> readings{0.9, 1.1, 1.05, 0.95, 3, -1, 0.5, 2, 1.9};
  std::vector<double> point{0};
  const auto solution =
      SolveGroups(MeanOf(readings), {{0, 0, 0, 0, 1, 1, 1, 1, 1}, {0, 0}}, {true}, {false}, &point);
  const double first = 4 / std::pow(solution.noise[0], 2);
  const double second = 5 / std::pow(solution.noise[1], 2);
  const double a = first / (first + second), b = second / (first + second);
  // the last round's Jacobian is in units of the round before
  constexpr double kSettled = 1e-4;
  EXPECT_REL(solution.seen.covariance[0], 1 / (first + second), kSettled, "converges to 1e-6");
  EXPECT_REL(solution.parts[0][0], a / (first + second), kSettled, "converges to 1e-6");
  // I = ((4 - 2 a + a^2, a b), (a b, 5 - 2 b + b^2))/2
  const double one = (4 - 2 * a + a * a) / 2, other = (5 - 2 * b + b * b) / 2;
  const double both = a * b / 2, determinant = one * other - both * both;
  const double W[]{other / determinant, -both / determinant, one / determinant};
  const double c = std::sqrt(1 + 6 / (4 - a)), d = std::sqrt(1 + 6 / (5 - b));
  const double share = (W[0] * c * c + W[2] * d * d - 2 * W[1] * c * d) * a * b;
  EXPECT_REL(solution.type_a.covariance[0] / solution.seen.covariance[0], 1 + 2 * share, kSettled,
             "a - a^2 = a b");
  EXPECT_REL(DegreesOf(solution, {1}), 2 / (a * a * W[0] + 2 * a * b * W[1] + b * b * W[2]),
             kSettled, "converges to 1e-6");
}

TEST(SolveGroups, OneGroupHasItsDegreesOfFreedomAndNothingMore) {
  const std::vector<double> readings{0.9, 1.1, 1.05, 0.95, 3};
  std::vector<double> point{0};
  const auto solution =
      SolveGroups(MeanOf(readings), {{0, 0, 0, 0, 0}, {0}}, {true}, {false}, &point);
  EXPECT_REL(DegreesOf(solution, {1}), 4.0, 1e-12, "rounding");
  EXPECT_EQ(solution.type_a.covariance, solution.seen.covariance);
}

// how often intervals of a line's two constants hold, whose first readings and others differ in
// their noise
std::array<double, 2> HeldByLine(std::size_t points, double first_noise, double second_noise,
                                 int lines) {
  const std::size_t rows = 2 * points;
  NoiseGroups groups{std::vector<std::size_t>(rows, 0), {0, 0}};
  std::fill(groups.group_of.begin() + static_cast<std::ptrdiff_t>(points), groups.group_of.end(),
            1);
  std::vector<double> readings(rows);
  const LeastSquares line{.residuals = rows,
                          .parameters = 2,
                          .evaluate = [&](std::span<const double> at, std::span<double> residuals,
                                          std::span<double> jacobian) {
                            for (std::size_t n = 0; n < rows; ++n) {
                              const double x = static_cast<double>(n % points);
                              residuals[n] = at[0] + at[1] * x - readings[n];
                              if (jacobian.empty()) continue;
                              jacobian[2 * n] = 1;
                              jacobian[2 * n + 1] = x;
                            }
                            return true;
                          }};
  std::mt19937_64 engine(1);
  std::normal_distribution<double> noise;
  std::array<double, 2> held{};
  for (int k = 0; k < lines; ++k) {
    for (std::size_t n = 0; n < rows; ++n) {
      readings[n] = noise(engine) * (n < points ? first_noise : second_noise);
    }
    std::vector<double> at{0, 0};
    const auto solution = SolveGroups(line, groups, {true, true}, {false, false}, &at);
    for (std::size_t p = 0; p < 2; ++p) {
      std::vector<double> weights(2, 0.0);
      weights[p] = 1;
      const double half = dsp::StudentCritical(DegreesOf(solution, weights)) *
                          std::sqrt(Variance(solution.type_a, weights));
      held[p] += std::abs(at[p]) <= half ? 1.0 / lines : 0;
    }
  }
  return held;
}

TEST(SolveGroups, IntervalsOfFewPointsHoldTheTruth) {
  const int lines = tests::Repetitions(300);
  // 2.5 deviations of so many lines on either side of 93 and 97 %
  const double slack = 2.5 * std::sqrt(0.95 * 0.05 / lines);
  for (const std::size_t points : {4U, 6U, 12U}) {
    for (const auto& [first, second] : {std::pair{1.0, 1.0}, {1.0, 5.0}, {5.0, 1.0}}) {
      for (const double held : HeldByLine(points, first, second, lines)) {
        std::printf("  %zu points, noise %g and %g: %.3f\n", points, first, second, held);
        EXPECT_GE(held, 0.93 - slack);
        EXPECT_LE(held, 0.97 + slack);
      }
    }
  }
}

TEST(RoundingResponses, EqualReadingsErrTogether) {
  // three equal ones, two equal ones and a single one, in steps of 0.1
  const std::vector<double> readings{1.1, 1.0, 1.1, 1.3, 1.0, 1.1};
  std::vector<double> point{0};
  const NoiseGroups groups{{0, 0, 0, 0, 0, 0}, {0}};
  auto solution = SolveGroups(MeanOf(readings), groups, {true}, {false}, &point);
  const TabulatedValues tabulated{readings, std::vector<double>(6, -1.0), 0};
  const auto square = [&](double noise) {
    // slopes in units of the noise
    solution.noise[0] = noise;
    std::ranges::fill(solution.jacobian.values, 1 / noise);
    solution.seen.covariance = {noise * noise / 6};
    const auto responses = RoundingResponses(solution, groups, tabulated);
    return CovarianceBy(responses, {1}, {1});
  };
  // the mean takes 3/6 of one error and 2/6 of another: q^2/12 (m - 1)/m (m/6)^2 each
  const double whole = 0.01 / 12 * (6.0 + 2.0) / 36;
  EXPECT_REL(square(0.1 / std::sqrt(12.0)), whole, 1e-12, "no noise but the rounding");
  EXPECT_REL(square(0.01), whole, 1e-12, "less than that");
  // of noise s the share exp(-2 pi^2 s^2/q^2) remains, squared here
  const double s = 0.03, kPi = std::numbers::pi;
  EXPECT_REL(square(std::hypot(s, 0.1 / std::sqrt(12.0))), whole * std::exp(-4 * kPi * kPi * 0.09),
             1e-9, "closed form");
  EXPECT_LT(square(0.1), 1e-10 * 0.01);
}

}  // namespace
}  // namespace haptometer::fit
