#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "fit/impedance/impedance_fit.h"
#include "tests/residual.h"

namespace haptometer::fit {
namespace {

using Complex = std::complex<double>;

// Lindsay 2013, Table 2.1
constexpr double kMv = 1.4e-3, kMc = 0.6e-3;

struct Coil {
  double stiffness = 2800;
  double damping = 0.0322;
  double force_constant = 1;
  double resistance = 27;
  double inductance = 130e-6;
  double mass = kMv;
};

// a sweep of that coil, each point off by a share and an angle of `noise`
std::vector<ImpedancePoint> Points(const Coil& coil, const std::vector<double>& frequencies_hz,
                                   double noise) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal;
  std::vector<ImpedancePoint> points;
  for (const double hz : frequencies_hz) {
    const Complex s(0, 2 * std::numbers::pi * hz);
    const Complex ohm = coil.resistance + s * coil.inductance +
                        coil.force_constant * coil.force_constant /
                            (coil.mass * s + coil.damping + coil.stiffness / s);
    const double share = noise * normal(engine);
    points.push_back({hz, ohm * std::polar(std::exp(share), noise * normal(engine))});
  }
  return points;
}

// nine points in the resonance of the thesis's coil, and ten from 100 to 4000 Hz
std::vector<double> Frequencies() {
  std::vector<double> hertz;
  for (int k = -4; k <= 4; ++k) hertz.push_back(225 + 2 * k);
  for (int k = 0; k < 10; ++k) hertz.push_back(100 * std::pow(40, k / 9.0));
  return hertz;
}

ImpedanceFit Fit(const std::vector<ImpedancePoint>& points, const ActuatorKnowns& knowns,
                 CaseCondition condition = CaseCondition::kHeld) {
  const auto fit = FitImpedance(points, knowns, condition, "z.csv");
  EXPECT_TRUE(fit) << fit.error().Text();
  return fit ? *fit : ImpedanceFit{};
}

TEST(ImpedanceInputs, BothMassesOfAFreeCaseCountByTheOthersShare) {
  // M = Mv Mc/(Mv + Mc): 1 % of Mv is 0.3 % of it, 1 % of Mc is 0.7 %
  const Coil coil{.mass = kMv * kMc / (kMv + kMc)};
  std::vector<double> hertz;
  for (int k = 0; k < 25; ++k) hertz.push_back(200 * std::pow(4, k / 24.0));
  const auto fit =
      Fit(Points(coil, hertz, 1e-6), {Quantity{kMv, 0.02 * kMv}, Quantity{kMc, 0.05 * kMc}, {}, {}},
          CaseCondition::kFree);
  ASSERT_EQ(fit.influences.size(), 2U);
  const double shares[]{0.3, 0.7};
  const double relative[]{0.02, 0.05};
  const char* names[]{"moving mass", "case mass"};
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(fit.influences[k].input, names[k]);
    EXPECT_EQ(fit.influences[k].unit, "kg");
    EXPECT_REL(fit.influences[k].relative_standard_uncertainty, relative[k], 1e-12, "as stated");
    EXPECT_REL(fit.influences[k].percent_per_percent[0], shares[k], 1e-12, "closed form");
    EXPECT_REL(fit.influences[k].percent_per_percent[1], shares[k], 1e-12, "closed form");
    EXPECT_REL(fit.influences[k].percent_per_percent[2], shares[k] / 2, 1e-12, "closed form");
  }
  const double share = std::hypot(0.3 * 0.02, 0.7 * 0.05);
  const auto relative_of = [](const FittedValue& value) {
    return value.combined_standard_uncertainty / value.value;
  };
  EXPECT_REL(relative_of(fit.stiffness), share, 1e-5, "noise of 1e-6");
  EXPECT_REL(relative_of(fit.damping), share, 1e-5, "noise of 1e-6");
  EXPECT_REL(relative_of(fit.force_constant), share / 2, 1e-5, "noise of 1e-6");
  EXPECT_REL(fit.relative_covariance[0][1], share * share, 1e-5, "both go by M");
  EXPECT_REL(fit.relative_covariance[1][2], share * share / 2, 1e-5, "Km by its root");
  EXPECT_EQ(fit.mass_symbol, "Mv Mc/(Mv+Mc)");
  EXPECT_REL(fit.stiffness.value, coil.stiffness, 1e-5, "noise of 1e-6");
}

// ln |Z| and arg Z at each frequency, in units of the fit's noises
Eigen::VectorXd Weighted(const Coil& coil, const ImpedanceFit& fit) {
  const auto points = Points(coil, Frequencies(), 0);
  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::VectorXd values(2 * count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const Complex ohm = points[static_cast<std::size_t>(n)].ohm;
    values[n] = std::log(std::abs(ohm)) / fit.magnitude_noise;
    values[n + count] = std::arg(ohm) / fit.phase_noise_rad;
  }
  return values;
}

TEST(ImpedanceInputs, AStatedInductanceCountsAsInTheLinearLeastSquares) {
  const Coil truth{.inductance = 1e-3};
  const auto fit =
      Fit(Points(truth, Frequencies(), 1e-3), {Quantity{kMv, 0}, {}, {}, Quantity{1e-3, 4e-5}});
  ASSERT_EQ(fit.influences.size(), 2U);
  const InputInfluence& influence = fit.influences[0];
  EXPECT_EQ(influence.input, "inductance");
  EXPECT_EQ(influence.unit, "H");
  EXPECT_EQ(influence.value, 1e-3);
  EXPECT_EQ(influence.standard_uncertainty, 4e-5);
  EXPECT_REL(influence.relative_standard_uncertainty, 0.04, 1e-12, "as stated");
  const Coil found{fit.stiffness.value, fit.damping.value, fit.force_constant.value,
                   fit.resistance.value, 1e-3};
  // per share of Kv, Bv, Km and R, then of L
  const auto slope = [&](double Coil::* number) {
    constexpr double kShare = 1e-5;
    Coil more = found;
    Coil less = found;
    more.*number *= 1 + kShare;
    less.*number *= 1 - kShare;
    const Eigen::VectorXd difference = Weighted(more, fit) - Weighted(less, fit);
    return Eigen::VectorXd(difference / (2 * kShare));
  };
  Eigen::MatrixXd slopes(2 * static_cast<Eigen::Index>(fit.points), 4);
  slopes << slope(&Coil::stiffness), slope(&Coil::damping), slope(&Coil::force_constant),
      slope(&Coil::resistance);
  const Eigen::Vector4d response = -slopes.colPivHouseholderQr().solve(slope(&Coil::inductance));
  const FittedValue* values[]{&fit.stiffness, &fit.damping, &fit.force_constant};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_ABS(influence.percent_per_percent[k], response[static_cast<Eigen::Index>(k)], 1e-6,
               "differences of 1e-5");
    EXPECT_REL(values[k]->combined_standard_uncertainty,
               std::hypot(values[k]->standard_uncertainty,
                          0.04 * influence.percent_per_percent[k] * values[k]->value),
               1e-9, "squares add");
  }
  EXPECT_GT(std::abs(influence.percent_per_percent[2]), 1e-3) << "else it would not matter";
  // L is what was stated
  EXPECT_TRUE(fit.inductance.determined);
  EXPECT_EQ(fit.inductance.value, 1e-3);
  EXPECT_EQ(fit.inductance.standard_uncertainty, 0);
  EXPECT_EQ(fit.inductance.combined_standard_uncertainty, 4e-5);
  EXPECT_REL(fit.inductance.upper, 1e-3 + 1.96 * 4e-5, 1e-12, "a normal distribution's 95 %");
  EXPECT_REL(fit.inductance.lower, 1e-3 - 1.96 * 4e-5, 1e-12, "a normal distribution's 95 %");
  EXPECT_REL(fit.relative_covariance[4][4], 0.04 * 0.04, 1e-9, "as stated");
  EXPECT_REL(fit.relative_covariance[4][3], 0.04 * 0.04 * response[3], 1e-4, "L moves R");
  EXPECT_FALSE(fit.findings.Has(FindingKind::kInductanceBelow));
}

TEST(ImpedanceInputs, AnInductanceThatIsStatedAsZeroLeavesFiniteNumbers) {
  const auto fit = Fit(Points({.inductance = 0}, Frequencies(), 1e-3),
                       {Quantity{kMv, 0}, {}, {}, Quantity{0, 1e-6}});
  EXPECT_EQ(fit.influences.at(0).relative_standard_uncertainty, 0);
  EXPECT_EQ(fit.inductance.value, 0);
  EXPECT_EQ(fit.inductance.combined_standard_uncertainty, 1e-6);
  for (const FittedValue* value : {&fit.stiffness, &fit.damping, &fit.force_constant}) {
    EXPECT_TRUE(value->determined);
    EXPECT_EQ(value->combined_standard_uncertainty, value->standard_uncertainty);
  }
}

TEST(ImpedanceFit, QualitiesAreDoubtedAboveThreeHundredAndBelowAHalf) {
  const auto has = [](double quality) {
    Coil coil;
    coil.damping = std::sqrt(coil.stiffness * coil.mass) / quality;
    coil.force_constant = std::sqrt(coil.damping * 20);
    std::vector<double> hertz;
    for (int k = -4; k <= 4; ++k) hertz.push_back(225.0790790392765 * (1 + 0.2 * k / quality));
    if (quality < 1) hertz.clear();
    for (int k = 0; k < 12; ++k) hertz.push_back(30 * std::pow(60, k / 11.0));
    const auto fit = Fit(Points(coil, hertz, 0), {Quantity{kMv, 0}, {}, {}, {}});
    EXPECT_REL(fit.quality_factor.value, quality, 1e-9, "noise-free");
    return fit.findings.Has(FindingKind::kUnusualQuality);
  };
  EXPECT_FALSE(has(299));
  EXPECT_TRUE(has(301));
  EXPECT_FALSE(has(0.502));
  EXPECT_TRUE(has(0.498));
}

TEST(ImpedanceFit, TheStepThatIsProposedIsAFifthOfTheResonancesWidth) {
  const auto fit = Fit(Points({}, Frequencies(), 0), {Quantity{kMv, 0}, {}, {}, {}});
  EXPECT_REL(fit.natural_frequency.value / fit.quality_factor.value,
             0.0322 / kMv / 2 / std::numbers::pi, 1e-12, "g/2pi");
  EXPECT_EQ(fit.points, 19U);
}

// `count` pairs of points of one frequency each, `copies` of which agree, and a single point
std::vector<ImpedancePoint> Pairs(std::size_t count, std::size_t copies) {
  std::vector<ImpedancePoint> points{{10, 1.0}};
  for (std::size_t k = 0; k < count; ++k) {
    const double hz = 20 + static_cast<double>(k);
    points.push_back({hz, 2.0});
    points.push_back({hz, k < copies ? 2.0 : 3.0});
  }
  return points;
}

TEST(TakeOutCopies, TakesThreeAndMoreThatAreNineInTenOfTheRepeats) {
  struct Row {
    std::size_t pairs;
    std::size_t copies;
    std::size_t taken;
  };
  for (const Row& row : {Row{2, 2, 0}, Row{3, 3, 3}, Row{9, 8, 0}, Row{10, 9, 9}, Row{11, 9, 0},
                         Row{20, 18, 18}, Row{20, 17, 0}}) {
    auto points = Pairs(row.pairs, row.copies);
    const std::size_t before = points.size();
    EXPECT_EQ(TakeOutCopies(&points), row.taken) << row.copies << " of " << row.pairs;
    EXPECT_EQ(points.size(), before - row.taken);
  }
  // every point twice, of two sweeps: a third of the repeats are none, but no point is alone
  std::vector<ImpedancePoint> twice;
  for (int k = 0; k < 4; ++k) {
    for (const double ohm : {1.0, 1.0, 2.0, 2.0}) twice.push_back({20.0 + k, ohm});
  }
  auto alone = twice;
  EXPECT_EQ(TakeOutCopies(&twice), 8U);
  EXPECT_EQ(twice.size(), 8U);
  // one point that stands alone, at either end or between others, makes it a measurement
  for (const double hz : {10.0, 21.5, 30.0}) {
    auto points = alone;
    points.push_back({hz, 1.0});
    std::ranges::sort(points, {}, &ImpedancePoint::frequency_hz);
    EXPECT_EQ(TakeOutCopies(&points), 0U) << hz;
  }
  std::vector<ImpedancePoint> none;
  EXPECT_EQ(TakeOutCopies(&none), 0U);
}

TEST(StartImpedance, LooksAtFiveHundredPointsOfMore) {
  std::vector<double> hertz;
  for (int k = 0; k < 1000; ++k) hertz.push_back(100 + 0.4 * k);
  const auto all = Points({}, hertz, 1e-2);
  std::vector<ImpedancePoint> second;
  for (std::size_t k = 0; k < all.size(); k += 2) second.push_back(all[k]);
  const auto of_all = StartImpedance(all);
  const auto of_second = StartImpedance(second);
  ASSERT_TRUE(of_all && of_second);
  EXPECT_EQ(of_all->parameters, of_second->parameters);
  EXPECT_EQ(of_all->cost, of_second->cost);
  EXPECT_EQ(of_all->plain_cost, of_second->plain_cost);
}

TEST(StartImpedance, ItsCostsAreTheRelativeMisfitsOfItsModels) {
  // far from the resonance of little damping: a circle of 10 ohm on a coil of 27
  const auto points = Points({}, Frequencies(), 1e-2);
  const auto start = StartImpedance(points);
  ASSERT_TRUE(start);
  double cost = 0;
  for (const auto& point : points) {
    cost += std::norm(ImpedanceAt(start->parameters, point.frequency_hz).ohm / point.ohm - 1.0);
  }
  EXPECT_REL(start->cost, cost, 1e-9, "sums of squares of about 1");
  // the grid's neighbours are 2.4 % apart in frequency and a factor of 2 in damping
  EXPECT_ABS(start->parameters[Index(ImpedanceParameter::kAngular)], std::log(2e6) / 2, 0.02,
             "a step of the grid");
  EXPECT_ABS(start->parameters[Index(ImpedanceParameter::kDamping)], std::log(23.0),
             std::numbers::ln2, "a step of the grid");
  // R + j w L alone, by the normal equations of both
  double weights = 0, real = 0, inductive = 0, imaginary = 0;
  for (const auto& point : points) {
    const double w = 2 * std::numbers::pi * point.frequency_hz;
    const double weight = 1 / std::norm(point.ohm);
    weights += weight;
    real += weight * point.ohm.real();
    inductive += weight * w * w;
    imaginary += weight * w * point.ohm.imag();
  }
  double plain = 0;
  for (const auto& point : points) {
    const double w = 2 * std::numbers::pi * point.frequency_hz;
    const Complex coil(real / weights, w * imaginary / inductive);
    plain += std::norm(coil / point.ohm - 1.0);
  }
  EXPECT_REL(start->plain_cost, plain, 1e-9, "closed form");
}

TEST(ImpedanceProblem, ParametersBeyondAllNumbersAreNotDefined) {
  const auto points = Points({}, Frequencies(), 0);
  const LeastSquares problem = ImpedanceProblem(points);
  std::vector<double> residuals(problem.residuals);
  std::vector<double> at{std::log(1414.0), std::log(23.0), std::log(714.0), std::log(27.0), 0};
  EXPECT_TRUE(problem.evaluate(at, residuals, {}));
  at[Index(ImpedanceParameter::kResistance)] = 800;
  EXPECT_FALSE(problem.evaluate(at, residuals, {}));
}

}  // namespace
}  // namespace haptometer::fit
