#include "fit/impedance/impedance_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "sim/linear/steady_state.h"
#include "tests/findings.h"
#include "tests/fit/bound.h"
#include "tests/fit/pulls.h"
#include "tests/repetitions.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Complex = std::complex<double>;

// Lindsay 2013, Table 2.1
constexpr double kKv = 2800, kBv = 0.0322, kKm = 1.0, kR = 27, kL = 130e-6;
constexpr double kMv = 1.4e-3, kMc = 0.6e-3;
constexpr double kTwoPi = 2 * std::numbers::pi;

// the circuit once more: impedance of a coil that moves a mass M
Complex TrueImpedance(double hz, double mass, double km = kKm) {
  const Complex s(0, kTwoPi * hz);
  return kR + s * kL + km * km / (mass * s + kBv + kKv / s);
}

struct Sweep {
  std::vector<double> frequencies_hz;
  double magnitude_noise = 0;
  double phase_noise_rad = 0;
  double mass_kg = kMv;
  unsigned seed = 1;
};

// 21 points within 10 Hz of the resonance and 24 from 100 to 500 Hz
std::vector<double> GoodFrequencies() {
  std::vector<double> hertz;
  for (int k = -10; k <= 10; ++k) hertz.push_back(225 + k);
  for (int k = 0; k < 24; ++k) hertz.push_back(100 * std::pow(5, k / 23.0));
  return hertz;
}

std::vector<ImpedancePoint> Points(const Sweep& sweep) {
  std::mt19937_64 engine(sweep.seed);
  std::normal_distribution<double> noise;
  std::vector<ImpedancePoint> points;
  for (const double hz : sweep.frequencies_hz) {
    Complex z = TrueImpedance(hz, sweep.mass_kg);
    z *= std::polar(std::exp(sweep.magnitude_noise * noise(engine)),
                    sweep.phase_noise_rad * noise(engine));
    points.push_back({hz, z});
  }
  return points;
}

ActuatorKnowns Masses() { return {Quantity{kMv, 0}, Quantity{kMc, 0}, {}, {}}; }

ImpedanceFit Fit(const std::vector<ImpedancePoint>& points, const ActuatorKnowns& knowns = Masses(),
                 CaseCondition condition = CaseCondition::kHeld) {
  const auto fit = FitImpedance(points, knowns, condition, "z.csv");
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit ? *fit : ImpedanceFit{};
}

// voltage over current of the 5-state solver with the case in the air
TEST(ImpedanceModel, IsTheSolversOfSimWithAFreeCase) {
  const auto actuator = sim::ThesisC10100();
  const auto model = sim::AssembleModel(actuator, {}, {});
  const double mass = kMv * kMc / (kMv + kMc);
  const std::vector<double> parameters{0.5 * std::log(kKv / mass), std::log(kBv / mass),
                                       std::log(kKm * kKm / mass), std::log(kR), kL};
  for (const double hz : {20.0, 150.0, 225.0, 405.0, 410.9, 415.0, 600.0, 3000.0}) {
    const auto steady = sim::SolveSteadyState(model, {.amplitude_v = 5, .frequency_hz = hz}, {});
    const Complex z = 5.0 / steady.current_a;
    const Complex own = ImpedanceAt(parameters, hz).ohm;
    EXPECT_ABS(std::abs(own - z) / std::abs(z), 0.0, 1e-13, "rounding of both");
  }
}

TEST(ImpedanceModel, DerivativesAreThoseOfTheModel) {
  const std::vector<double> parameters{std::log(1414.0), std::log(23.0), std::log(714.0),
                                       std::log(27.0), 130e-6};
  constexpr double kStep = 1e-5;
  for (const double hz : {100.0, 224.0, 225.5, 400.0}) {
    const auto at = ImpedanceAt(parameters, hz);
    for (std::size_t k = 0; k < kImpedanceParameters; ++k) {
      auto up = parameters;
      auto down = parameters;
      up[k] += kStep;
      down[k] -= kStep;
      const Complex slope = (ImpedanceAt(up, hz).ohm - ImpedanceAt(down, hz).ohm) / (2 * kStep);
      EXPECT_ABS(std::abs(slope - at.slopes[k]) / std::abs(at.slopes[k]), 0.0, 3e-6,
                 "central differences: step^2 (w/g)^2");
    }
  }
}

TEST(ImpedanceFit, ACleanSweepGivesTheConstantsToRounding) {
  const auto fit = Fit(Points({GoodFrequencies()}));
  EXPECT_REL(fit.stiffness.value, kKv, 1e-13, "noise-free");
  EXPECT_REL(fit.damping.value, kBv, 1e-13, "noise-free");
  EXPECT_REL(fit.force_constant.value, kKm, 1e-13, "noise-free");
  EXPECT_REL(fit.resistance.value, kR, 1e-13, "noise-free");
  EXPECT_REL(fit.inductance.value, kL, 1e-12, "noise-free");
  EXPECT_REL(fit.natural_frequency.value, 225.0790790392765, 1e-13, "sqrt(2e6)/2pi");
  EXPECT_EQ(fit.mass_symbol, "Mv");
  EXPECT_THAT(fit.findings.list(), IsEmpty());
}

TEST(ImpedanceFit, AFreeCaseRingsWithTheReducedMass) {
  std::vector<double> hertz;
  for (int k = 0; k < 60; ++k) hertz.push_back(200 * std::pow(4, k / 59.0));
  const auto fit = Fit(Points({.frequencies_hz = hertz, .mass_kg = kMv * kMc / (kMv + kMc)}),
                       Masses(), CaseCondition::kFree);
  EXPECT_REL(fit.stiffness.value, kKv, 1e-13, "noise-free");
  EXPECT_REL(fit.damping.value, kBv, 1e-13, "noise-free");
  EXPECT_REL(fit.force_constant.value, kKm, 1e-13, "noise-free");
}

struct Case {
  std::string name;
  Sweep sweep;
};

std::vector<double> Between(double first, double last, int count) {
  std::vector<double> hertz;
  for (int k = 0; k < count; ++k) hertz.push_back(first + (last - first) * k / (count - 1));
  return hertz;
}

class ImpedanceSweeps : public ::testing::TestWithParam<Case> {};

// bounds of ln Kv, ln Bv, ln Km, R by the circuit above, all noise known
std::vector<double> Bounds(const Sweep& sweep) {
  const auto residuals = [&](const std::vector<double>& p) {
    std::vector<double> weighted;
    for (const double hz : sweep.frequencies_hz) {
      const Complex s(0, kTwoPi * hz);
      const double km = std::exp(p[2]);
      const Complex z =
          p[3] + s * p[4] + km * km / (sweep.mass_kg * s + std::exp(p[1]) + std::exp(p[0]) / s);
      weighted.push_back(std::log(std::abs(z)) / sweep.magnitude_noise);
      weighted.push_back(std::arg(z) / sweep.phase_noise_rad);
    }
    return weighted;
  };
  return tests::CramerRaoDeviations(residuals,
                                    {std::log(kKv), std::log(kBv), std::log(kKm), kR, kL},
                                    {1e-4, 1e-3, 1e-3, 1e-2, 1e-5});
}

TEST_P(ImpedanceSweeps, ErrorsAreAtTheBoundAndAsStated) {
  const int repetitions = tests::Repetitions(tests::kIsSanitized ? 10 : 100);
  tests::Pulls stiffness, damping, force_constant, resistance;
  int doubted = 0;
  for (int k = 0; k < repetitions; ++k) {
    Sweep sweep = GetParam().sweep;
    sweep.seed = static_cast<unsigned>(k) + 1;
    const auto fit = Fit(Points(sweep));
    ASSERT_TRUE(fit.force_constant.determined);
    stiffness.Add(fit.stiffness.value, kKv, fit.stiffness.standard_uncertainty);
    damping.Add(fit.damping.value, kBv, fit.damping.standard_uncertainty);
    force_constant.Add(fit.force_constant.value, kKm, fit.force_constant.standard_uncertainty);
    resistance.Add(fit.resistance.value, kR, fit.resistance.standard_uncertainty);
    const bool is_outside = GetParam().name == "OneSideOnly";  // of the sweep: said each time
    doubted += tests::DoubtsOf(fit.findings).size() > (is_outside ? 1 : 0) ? 1 : 0;
  }
  const auto bounds = Bounds(GetParam().sweep);
  ExpectEfficient(stiffness, bounds[0] * kKv, "Kv");
  ExpectEfficient(damping, bounds[1] * kBv, "Bv");
  ExpectEfficient(force_constant, bounds[2] * kKm, "Km");
  ExpectEfficient(resistance, bounds[3], "R");
  EXPECT_LE(doubted, 0.01 * repetitions) << "false alarms";
}

INSTANTIATE_TEST_SUITE_P(
    Noise, ImpedanceSweeps,
    ::testing::Values(Case{"BridgeOfATenthOfAPercent", {GoodFrequencies(), 1e-3, 1e-3}},
                      Case{"MagnitudesBetterThanPhases", {GoodFrequencies(), 2e-3, 2e-2}},
                      Case{"OscilloscopeOfTwoPercent", {GoodFrequencies(), 2e-2, 2e-2}},
                      Case{"OneSideOnly", {Between(150, 222, 40), 2e-3, 2e-3}},
                      Case{"FivePointsInTheResonance", {Between(100, 340, 121), 3e-3, 3e-3}}),
    [](const auto& tried) { return tried.param.name; });

TEST(ImpedanceFit, WithoutAMassTheRatiosAreGiven) {
  const auto fit = Fit(Points({GoodFrequencies(), 1e-3, 1e-3}), {});
  EXPECT_FALSE(fit.stiffness.determined);
  EXPECT_FALSE(fit.force_constant.determined);
  EXPECT_TRUE(fit.findings.Has(FindingKind::kMassMissing));
  EXPECT_REL(fit.stiffness_over_mass.value, 2e6, 1e-3, "noise");
  EXPECT_REL(fit.coupling_over_mass.value, 1 / 1.4e-3, 0.01, "noise");
  EXPECT_REL(fit.quality_factor.value, 61.4875, 0.01, "noise");
  // held was assumed for a free case without the case's mass
  const auto free = Fit(Points({GoodFrequencies(), 1e-3, 1e-3}), {Quantity{kMv, 0}, {}, {}, {}},
                        CaseCondition::kFree);
  EXPECT_FALSE(free.stiffness.determined);
  EXPECT_TRUE(free.findings.Has(FindingKind::kMassesMissing));
}

TEST(ImpedanceFit, TheMassIsTypeB) {
  auto knowns = Masses();
  knowns.moving_mass_kg = Quantity{kMv, 0.02 * kMv};
  const auto fit = Fit(Points({GoodFrequencies(), 1e-4, 1e-4}), knowns);
  EXPECT_REL(fit.stiffness.combined_standard_uncertainty, 0.02 * kKv, 1e-3, "Kv = M w0^2");
  EXPECT_REL(fit.force_constant.combined_standard_uncertainty, 0.01, 1e-2, "Km = sqrt(M k)");
  ASSERT_EQ(fit.influences.size(), 1U);
  EXPECT_REL(fit.influences[0].percent_per_percent[2], 0.5, 1e-12, "closed form");
}

TEST(ImpedanceFit, CovarianceIsThatOfTheConstants) {
  auto knowns = Masses();
  knowns.moving_mass_kg = Quantity{kMv, 0.02 * kMv};
  const auto fit = Fit(Points({GoodFrequencies(), 1e-3, 1e-3}), knowns);
  const FittedValue* values[]{&fit.stiffness, &fit.damping, &fit.force_constant, &fit.resistance,
                              &fit.inductance};
  for (std::size_t k = 0; k < 5; ++k) {
    ASSERT_TRUE(values[k]->determined) << k;
    EXPECT_REL(std::sqrt(fit.relative_covariance[k][k]),
               values[k]->combined_standard_uncertainty / values[k]->value, 1e-9, "the same sums");
  }
  // Kv and Bv go by M, Km by its root; R and L do not
  EXPECT_REL(fit.relative_covariance[0][1], 4e-4, 1e-2, "noise of 1e-5");
  EXPECT_REL(fit.relative_covariance[0][2], 2e-4, 1e-2, "noise of 1e-5");
  EXPECT_LT(std::abs(fit.relative_covariance[0][3]), 1e-6);
  EXPECT_EQ(fit.relative_covariance[2][3], fit.relative_covariance[3][2]);
  const auto faint = Fit(Points({GoodFrequencies(), 5e-2, 5e-2}));
  ASSERT_FALSE(faint.inductance.determined);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(faint.relative_covariance[4][k], 0);
}

TEST(ImpedanceFit, AStatedResistanceServesWhereTheSweepTellsNone) {
  // eight points within a sixth of the resonance's width: a circle's small arc
  const Sweep sweep{
      .frequencies_hz = Between(224.8, 225.4, 8), .magnitude_noise = 1e-2, .phase_noise_rad = 1e-2};
  const auto without = Fit(Points(sweep));
  EXPECT_FALSE(without.resistance.determined && without.force_constant.determined);
  EXPECT_TRUE(without.findings.Has(FindingKind::kSweepTooCoarse));
  auto knowns = Masses();
  knowns.resistance_ohm = Quantity{kR, 0.27};
  knowns.inductance_h = Quantity{kL, 0};
  const auto with = Fit(Points(sweep), knowns);
  EXPECT_TRUE(with.findings.Has(FindingKind::kResistanceAsStated));
  ASSERT_TRUE(with.force_constant.determined);
  EXPECT_ABS(with.force_constant.value, kKm, 3 * with.force_constant.combined_standard_uncertainty,
             "3 deviations");
  EXPECT_GT(with.force_constant.combined_standard_uncertainty,
            with.force_constant.standard_uncertainty);
  knowns.inductance_h.reset();
  const auto fitted = Fit(Points(sweep), knowns);
  EXPECT_GT(fitted.inductance.combined_standard_uncertainty, fitted.inductance.standard_uncertainty)
      << "R moves L, too";
  knowns.inductance_h = Quantity{kL, 0};
  // the response to R against the fit with another R
  auto other = knowns;
  other.resistance_ohm = Quantity{kR * 1.001, 0.27};
  const auto moved = Fit(Points(sweep), other);
  const double percent = std::log(moved.force_constant.value / with.force_constant.value) / 1e-3;
  const auto& influence = with.influences.at(0);
  EXPECT_EQ(influence.input, "resistance");
  EXPECT_ABS(influence.percent_per_percent[2], percent, 0.02 * std::abs(percent) + 1e-3,
             "second order of 0.1 %, and the noises that are estimated again");
}

TEST(ImpedanceFit, AnInductanceThatIsNotSeenIsALimit) {
  const auto fit = Fit(Points({GoodFrequencies(), 5e-2, 5e-2}));
  EXPECT_FALSE(fit.inductance.determined);
  EXPECT_EQ(tests::NumberOf(fit.findings, FindingKind::kInductanceBelow, "at_most_h"),
            *fit.inductance.at_most);
  EXPECT_GT(*fit.inductance.at_most, 0);
  EXPECT_TRUE(fit.force_constant.determined);
}

TEST(ImpedanceFit, OtherReadingsOfThePhaseAreRefused) {
  auto reversed = Points({GoodFrequencies(), 1e-3, 1e-3});
  auto radians = reversed;
  for (auto& point : reversed) point.ohm = std::conj(point.ohm);
  for (auto& point : radians) {
    point.ohm = std::polar(std::abs(point.ohm), std::arg(point.ohm) * std::numbers::pi / 180);
  }
  const auto fit = FitImpedance(reversed, Masses(), CaseCondition::kHeld, "z.csv");
  ASSERT_FALSE(fit);
  EXPECT_THAT(fit.error().Text(), HasSubstr("other sign"));
  const auto other = FitImpedance(radians, Masses(), CaseCondition::kHeld, "z.csv");
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().Text(), HasSubstr("radians"));
}

TEST(ImpedanceFit, WhatHoldsNoResonanceIsRefused) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> noise(0, 0.01);
    std::vector<ImpedancePoint> coil;
    for (const double hz : GoodFrequencies()) {
      coil.push_back(
          {hz, Complex(27, kTwoPi * hz * kL) * std::polar(std::exp(noise(engine)), noise(engine))});
    }
    const auto fit = FitImpedance(coil, Masses(), CaseCondition::kHeld, "z.csv");
    ASSERT_FALSE(fit) << "seed " << seed;
    EXPECT_THAT(fit.error().Text(), HasSubstr("no resonance"));
  }
}

TEST(ImpedanceFit, ASlipIsNamed) {
  auto points = Points({GoodFrequencies(), 1e-3, 1e-3});
  points[5].ohm *= 1.1;
  EXPECT_EQ(tests::NumberOf(Fit(points).findings, FindingKind::kOutlyingPoint, "frequency_hz"),
            220);
}

// 30 % off at the peak of a sweep with few points there: the fit runs through it, and its own
// residual is small
TEST(ImpedanceFit, AFitThatFollowsOnePointIsNotDetermined) {
  std::vector<double> hertz;
  for (int k = 0; k < 23; ++k) hertz.push_back(80 * std::pow(8, k / 22.0));
  auto points = Points({hertz, 1e-3, 1e-3});
  EXPECT_THAT(tests::DoubtsOf(Fit(points).findings), IsEmpty());
  points[11].ohm *= 1.3;
  const auto fit = Fit(points);
  EXPECT_EQ(tests::NumberOf(fit.findings, FindingKind::kFollowsOnePoint, "frequency_hz"),
            hertz[11]);
  EXPECT_FALSE(fit.stiffness.determined);
  EXPECT_FALSE(fit.damping_over_mass.determined);
}

TEST(ImpedanceFit, BadTablesAreRefusedOrThinned) {
  const auto refused = [](std::vector<ImpedancePoint> points) {
    return !FitImpedance(points, Masses(), CaseCondition::kHeld, "z.csv");
  };
  EXPECT_TRUE(refused({}));
  EXPECT_TRUE(refused(Points({{224, 226}})));
  EXPECT_TRUE(refused(Points({std::vector<double>(50, 225.0)})));
  auto zero = Points({GoodFrequencies()});
  zero[3].ohm = 0;
  EXPECT_TRUE(refused(zero));
  auto negative = Points({GoodFrequencies()});
  negative[3].frequency_hz = -1;
  EXPECT_TRUE(refused(negative));
  auto constant = Points({GoodFrequencies()});
  for (auto& point : constant) point.ohm = 27;
  EXPECT_TRUE(refused(constant));
  auto holes = Points({GoodFrequencies()});
  holes[5].ohm = std::nan("");
  holes[6].frequency_hz = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Fit(holes).points, holes.size() - 2);
}

// any numbers, from 1e-300 to 1e300, give a refusal or finite numbers
TEST(ImpedanceFit, GarbageIsRefusedOrFinite) {
  std::mt19937_64 engine(6);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < 60; ++k) {
    const double spread = k % 3 == 0 ? 300 : k % 3 == 1 ? 10 : 1;
    std::vector<ImpedancePoint> points;
    for (int n = 0; n < 12; ++n) {
      points.push_back({std::pow(10, spread * uniform(engine)),
                        std::polar(std::pow(10, spread * uniform(engine)), 4 * uniform(engine))});
    }
    const auto fit = FitImpedance(points, Masses(), CaseCondition::kHeld, "garbage");
    if (!fit) continue;
    for (const FittedValue* value : {&fit->stiffness, &fit->damping, &fit->force_constant}) {
      if (!value->determined) continue;
      EXPECT_TRUE(std::isfinite(value->value) &&
                  std::isfinite(value->combined_standard_uncertainty));
    }
  }
}

TEST(ImpedanceFit, WrongUnitsAndWrongModelsAreDoubted) {
  auto kilohertz = Points({GoodFrequencies(), 1e-3, 1e-3});
  for (auto& point : kilohertz) point.frequency_hz *= 1e-3;
  EXPECT_TRUE(Fit(kilohertz).findings.Has(FindingKind::kUnusualFrequency));
  auto kilohm = Points({GoodFrequencies(), 1e-3, 1e-3});
  for (auto& point : kilohm) point.ohm *= 1e-3;
  EXPECT_TRUE(Fit(kilohm).findings.Has(FindingKind::kUnusualResistance));
  auto knowns = Masses();
  knowns.moving_mass_kg = Quantity{1.4, 0};
  EXPECT_TRUE(Fit(Points({GoodFrequencies(), 1e-3, 1e-3}), knowns)
                  .findings.Has(FindingKind::kUnusualMovingMass));
  knowns = Masses();
  knowns.resistance_ohm = Quantity{22, 0};
  EXPECT_EQ(tests::NumberOf(Fit(Points({GoodFrequencies(), 1e-3, 1e-3}), knowns).findings,
                            FindingKind::kResistanceDiffers, "stated_ohm"),
            22);
  // a second resonance
  auto second = Points({GoodFrequencies(), 1e-3, 1e-3});
  for (auto& point : second) {
    const Complex s(0, kTwoPi * point.frequency_hz);
    point.ohm += 0.02 / (1e-4 * s + 0.02 + 400.0 / s);
  }
  EXPECT_TRUE(Fit(second).findings.Has(FindingKind::kResidualsCorrelated));
}

// 7 points within 6 Hz of the resonance and 6 from 100 to 2000 Hz
std::vector<double> FewFrequencies() {
  std::vector<double> hertz;
  for (int k = -3; k <= 3; ++k) hertz.push_back(225 + 2 * k);
  for (int k = 0; k < 6; ++k) hertz.push_back(100 * std::pow(20, k / 5.0));
  return hertz;
}

TEST(ImpedanceFit, TheInductancesLimitIsTheIntervalsUpperEnd) {
  int below_zero = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const auto fit = Fit(Points({.frequencies_hz = GoodFrequencies(),
                                 .magnitude_noise = 0.2,
                                 .phase_noise_rad = 0.2,
                                 .seed = seed}));
    const FittedValue& inductance = fit.inductance;
    EXPECT_EQ(inductance.determined,
              inductance.value > 3 * inductance.combined_standard_uncertainty);
    if (inductance.determined) continue;
    below_zero += inductance.value < 0 ? 1 : 0;
    EXPECT_REL(*inductance.at_most,
               std::max(inductance.value, 0.0) + inductance.upper - inductance.value, 1e-12,
               "of no less than 0");
  }
  EXPECT_GT(below_zero, 0) << "an inductance that is lost in its uncertainty";
}

TEST(ImpedanceFit, AnInductanceIsSeenFromThreeStandardUncertaintiesOn) {
  double seen_noise = 0.005;
  double unseen_noise = 0.1;
  double seen = 0;
  double unseen = 0;
  for (int halving = 0; halving < 8; ++halving) {
    const double noise = std::sqrt(seen_noise * unseen_noise);
    const FittedValue inductance = Fit(Points({FewFrequencies(), noise, noise})).inductance;
    const double ratio = inductance.value / inductance.combined_standard_uncertainty;
    (inductance.determined ? seen_noise : unseen_noise) = noise;
    (inductance.determined ? seen : unseen) = ratio;
  }
  EXPECT_GT(seen, 3);
  EXPECT_LE(unseen, 3);
  EXPECT_REL(seen, unseen, 0.015, "a twentyfold range, halved 8 times");
}

TEST(ImpedanceFit, PointsThatWereWrittenTwiceCountOnce) {
  const auto once = Points({GoodFrequencies(), 1e-3, 1e-3});
  auto twice = once;
  twice.insert(twice.end(), once.begin(), once.end());
  const ImpedanceFit single = Fit(once);
  const ImpedanceFit copied = Fit(twice);
  EXPECT_EQ(copied.points, once.size());
  EXPECT_EQ(copied.measured.size(), copied.model.size());
  EXPECT_EQ(
      tests::NumberOf<std::int64_t>(copied.findings, FindingKind::kPointsWrittenTwice, "copies"),
      static_cast<std::int64_t>(once.size()));
  EXPECT_EQ(copied.force_constant.value, single.force_constant.value);
  EXPECT_EQ(copied.force_constant.lower, single.force_constant.lower);
  EXPECT_THAT(tests::DoubtsOf(copied.findings), IsEmpty()) << "no residuals that are correlated";
  // a part that overlaps, as when a sweep is continued
  auto overlap = once;
  overlap.insert(overlap.end(), once.begin(), once.begin() + 3);
  EXPECT_EQ(Fit(overlap).points, once.size());
}

TEST(ImpedanceFit, PointsThatWereMeasuredTwiceCountTwice) {
  auto points = Points({GoodFrequencies(), 1e-3, 1e-3});
  const std::size_t count = points.size();
  // two that agree by chance are no pattern
  auto chance = points;
  chance.insert(chance.end(), points.begin(), points.begin() + 2);
  EXPECT_EQ(Fit(chance).points, count + 2);
  // neither is a third of a second sweep, of few digits
  const auto again = Points({.frequencies_hz = GoodFrequencies(),
                             .magnitude_noise = 1e-3,
                             .phase_noise_rad = 1e-3,
                             .seed = 2});
  for (std::size_t k = 0; k < count; ++k) points.push_back(k % 3 == 0 ? points[k] : again[k]);
  const ImpedanceFit fit = Fit(points);
  EXPECT_EQ(fit.points, 2 * count);
  EXPECT_FALSE(fit.findings.Has(FindingKind::kPointsWrittenTwice));
  // both sweeps written twice
  auto copied = points;
  copied.insert(copied.end(), points.begin(), points.end());
  EXPECT_TRUE(Fit(copied).findings.Has(FindingKind::kPointsWrittenTwice));
}

TEST(ImpedanceFit, AResistanceDiffersBeyondOnePercentAndThreeUncertainties) {
  const auto differs = [](double stated, double uncertainty) {
    auto knowns = Masses();
    knowns.resistance_ohm = Quantity{stated, uncertainty};
    return Fit(Points({FewFrequencies()}), knowns).findings.Has(FindingKind::kResistanceDiffers);
  };
  // the sweep has no noise: 27 ohm
  EXPECT_FALSE(differs(27 / 1.0099, 0));
  EXPECT_TRUE(differs(27 / 1.0101, 0));
  EXPECT_FALSE(differs(27 / 0.9901, 0));
  EXPECT_TRUE(differs(27 / 0.9899, 0));
  EXPECT_FALSE(differs(25, 2.01 / 3));
  EXPECT_TRUE(differs(25, 1.99 / 3));
}

TEST(ImpedanceFit, PointsNearTheResonanceAreThoseWithinHalfABandwidth) {
  const auto frequencies_hz = GoodFrequencies();
  const auto fit = Fit(Points({frequencies_hz}));
  // f0 = 225.079 Hz, Q = 61.4875: sqrt(3)/2 f0/Q = 3.1701 Hz on either side
  const auto near = std::ranges::count_if(
      frequencies_hz, [](double hz) { return std::abs(hz - 225.0790790392765) <= 3.1701; });
  EXPECT_EQ(fit.points_near_resonance, static_cast<std::size_t>(near));
  EXPECT_GE(near, 7) << "222 to 228 Hz";
  EXPECT_EQ(fit.lowest_hz, 100);
  EXPECT_REL(fit.highest_hz, 500.0, 1e-14, "rounding");
  EXPECT_REL(fit.degrees_of_freedom, 85.0, 1e-6, "45 magnitudes and phases, five numbers");
}

TEST(ImpedanceFit, IntervalsHaveStudentsFactorOfTheirDegreesOfFreedom) {
  const auto fit = Fit(Points({GoodFrequencies(), 1e-2, 1e-2}));
  double largest = 0;
  for (const FittedValue* value :
       {&fit.stiffness, &fit.damping, &fit.force_constant, &fit.natural_frequency,
        &fit.quality_factor, &fit.resistance, &fit.inductance}) {
    const double half = value->upper - value->value;
    EXPECT_REL(value->value - value->lower, half, 1e-9, "rounding") << value->unit;
    // from those of all residuals, qt(0.975, 85), to those of either noise alone, some 40
    const double factor = half / value->combined_standard_uncertainty;
    EXPECT_GE(factor, 1.98826) << value->unit;
    EXPECT_LE(factor, 2.04) << value->unit;
    largest = std::max(largest, factor);
  }
  EXPECT_REL(fit.coverage_95, largest, 0.02, "of four of these and their like");
}

TEST(ImpedanceFit, RoundedMagnitudesWidenTheResistance) {
  // most points away from the resonance are 27.0 ohm: one error of up to 0.05 ohm
  auto points = Points({GoodFrequencies()});
  const auto rounded_to = [&points](double step) {
    auto rounded = points;
    for (auto& point : rounded) {
      const double ohm = std::round(std::abs(point.ohm) / step) * step;
      // phases to 0.01 degrees
      const double unit = kTwoPi / 36000;
      point.ohm = std::polar(ohm, std::round(std::arg(point.ohm) / unit) * unit);
    }
    return Fit(rounded).resistance;
  };
  const FittedValue coarse = rounded_to(0.1);
  EXPECT_LE(coarse.lower, kR);
  EXPECT_GE(coarse.upper, kR);
  EXPECT_GE(coarse.combined_standard_uncertainty, 3 * coarse.standard_uncertainty);
  // a common error of 0.1/sqrt(12) ohm at all points would be the most
  EXPECT_LE(coarse.combined_standard_uncertainty, 0.1 / std::sqrt(12.0));
  EXPECT_GE(coarse.combined_standard_uncertainty, 0.2 * 0.1 / std::sqrt(12.0));
  // nothing is added where the noise is a step
  points = Points({GoodFrequencies(), 3e-3, 3e-3});
  const FittedValue fine = rounded_to(0.1);
  EXPECT_REL(fine.combined_standard_uncertainty, fine.standard_uncertainty, 1e-3,
             "noise of 0.08 ohm leaves exp(-12.7) of the rounding");
}

TEST(ImpedanceFit, ACoarseSweepIsReportedWithItsPointsAndAStep) {
  const auto fit = Fit(Points({.frequencies_hz = Between(224.8, 225.4, 8),
                               .magnitude_noise = 1e-2,
                               .phase_noise_rad = 1e-2}));
  EXPECT_EQ(tests::NumberOf<std::int64_t>(fit.findings, FindingKind::kSweepTooCoarse, "points"), 8);
  EXPECT_EQ(tests::NumberOf<std::int64_t>(fit.findings, FindingKind::kSweepTooCoarse, "near"), 8);
  EXPECT_REL(tests::NumberOf(fit.findings, FindingKind::kSweepTooCoarse, "step_hz"),
             fit.natural_frequency.value / fit.quality_factor.value / 5, 1e-12,
             "a fifth of the resonance's width");
}

TEST(ImpedanceFit, FewPointsAndFrequenciesAreRefusedWithTheirNumber) {
  const auto error = [](const std::vector<double>& frequencies_hz) {
    // noise, so that no point is written twice
    const auto fit =
        FitImpedance(Points({frequencies_hz, 1e-6, 1e-6}), Masses(), CaseCondition::kHeld, "z.csv");
    return fit ? "" : fit.error().Text();
  };
  EXPECT_THAT(error({222, 224, 225, 226, 228}), HasSubstr("holds only 5 impedances"));
  EXPECT_EQ(error({222, 224, 225, 226, 228, 240}), "");
  EXPECT_THAT(error({222, 222, 222, 225, 225, 225, 225}), HasSubstr("has 2 different"));
}

}  // namespace
}  // namespace haptometer::fit
