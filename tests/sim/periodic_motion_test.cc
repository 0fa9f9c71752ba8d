#include "sim/periodic_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include "base/jobs.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/smooth/smooth_system.h"
#include "tests/residual.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr Eigen::Index kMover = LinearModel::kMover;
constexpr Eigen::Index kMoverVelocity = LinearModel::kMoverVelocity;
constexpr Eigen::Index kCase = LinearModel::kCase;
constexpr Eigen::Index kCaseVelocity = LinearModel::kCaseVelocity;

Scene FromRest(Scene scene) {
  scene.start = Start::kRest;
  return scene;
}

PeriodMap ExactMap(const Scene& scene, const PiecewiseEffects& effects) {
  return {AssemblePiecewise(scene, effects), scene.drive};
}

PeriodPoint RestOf(const Scene& scene, const PeriodMap& map) {
  const PiecewiseStart start = PiecewiseStartOf(scene);
  return map.PointOf(start.mode, start.x);
}

std::optional<double> NumberOf(const Finding& finding, std::string_view name) {
  const auto found = std::ranges::find(finding.numbers, name, &FindingNumber::name);
  if (found == finding.numbers.end()) return std::nullopt;
  if (const auto* count = std::get_if<std::int64_t>(&found->value)) {
    return static_cast<double>(*count);
  }
  return std::get<double>(found->value);
}

Eigen::Index SkinOf(const Scene& scene) { return AssembleModel(scene).skin(); }

TEST(PeriodicMotion, OfALinearSceneIsThePhasor) {
  for (const Scene& scene : {FromRest(tests::AdapterScene()), FromRest(tests::DirectScene())}) {
    const PeriodMap map = ExactMap(scene, {});
    const PeriodicSearch search =
        FindPeriodicMotion(map, RestOf(scene, map), {.transient_periods = 1});
    ASSERT_TRUE(search.found.has_value());
    const PeriodicMotion& motion = *search.found;
    EXPECT_EQ(motion.drive_periods, 1);
    EXPECT_TRUE(motion.stable);
    const SteadyState steady = SolveSteadyState(scene);
    EXPECT_REL(std::sqrt(motion.means.mean_squares(SkinOf(scene))), steady.skin_rms_m, 1e-12,
               "a closed form; rounding of the sums");
    EXPECT_REL(std::sqrt(2 * motion.means.travel_mean_square), steady.mover_peak_m, 1e-12,
               "a closed form; rounding of the sums");
    EXPECT_REL(motion.means.power_w, steady.power_w, 1e-12, "a closed form; rounding of the sums");

    // multipliers exp(lambda T)
    const LinearModel model = AssembleModel(scene);
    Eigen::VectorXd expected =
        (model.a.eigenvalues() / scene.drive.frequency_hz).real().array().exp().matrix();
    std::ranges::sort(expected, std::greater<>());
    ASSERT_EQ(motion.multipliers.size(), expected.size());
    for (Eigen::Index k = 0; k < expected.size(); ++k) {
      EXPECT_ABS(std::abs(motion.multipliers(k)), expected(k), 1e-8,
                 "central differences of a linear map: rounding over the step");
    }
  }
}

TEST(PeriodicMotion, ACoilsTemperatureNeedsNoWaiting) {
  // Km = 0: theta = Rth R(theta) |I|^2/2 up to the ripple's square, P/(2 w C) of 1e-9 here; it
  // takes C Rth = 1e4 s to get there
  Scene scene = FromRest(tests::ConeScene());
  scene.actuator.force_constant_n_per_a = 0;
  const CoilHeating heating{.heat_capacity_j_per_k = 1e3, .thermal_resistance_k_per_w = 10};
  const double R0 = scene.actuator.resistance_ohm, L = scene.actuator.inductance_h;
  const double w = 2 * std::numbers::pi * scene.drive.frequency_hz;
  const auto power_w = [&](double theta) {
    const double R = R0 * (1 + heating.resistance_per_k * theta);
    return 12.5 * R / (R * R + w * w * L * L);
  };
  double expected = 0;
  for (int i = 0; i < 200; ++i) expected = 10 * power_w(expected);
  const PeriodMap map(AssembleSmooth(scene, {}, {.heating = heating}), scene.drive,
                      {.tolerance = 1e-10});
  const PeriodicSearch search =
      FindPeriodicMotion(map, RestOf(scene, map), {.transient_periods = 3});
  ASSERT_TRUE(search.found.has_value());
  const double found = search.found->point.x(search.found->point.x.size() - 1);
  EXPECT_TRUE(search.found->stable);
  EXPECT_REL(found, expected, 1e-7, "what a period's error of 1e-13 is where 4.5e-7 is lost in it");
  // the slowest multiplier: exp(-T/(C Rth) (1 - Rth P'))
  const double slope = (power_w(expected + 1e-3) - power_w(expected - 1e-3)) / 2e-3;
  EXPECT_ABS(1 - std::abs(search.found->multipliers(0)),
             (1 - 10 * slope) / (1e4 * scene.drive.frequency_hz), 1e-8, "noise of the differences");
}

// A coil that its current makes three times as resistive: its way to that temperature is no linear
// decay that could be foretold, and takes 10^4 s, so the search has to lead it there.
TEST(PeriodicMotion, ACoilIsLedToATemperatureFarFromItsStart) {
  Scene scene = FromRest(tests::ConeScene());
  scene.actuator.force_constant_n_per_a = 0;
  scene.actuator.inductance_h = 0;
  // Rth P(theta) = theta at alpha theta = 2: P = V^2 / (2 R0) / 3
  const double theta_k = 2 / CoilHeating::kCopperPerK;
  const double power_w = 12.5 / scene.actuator.resistance_ohm / 3;
  const double k_per_w = theta_k / power_w;
  const CoilHeating heating{.heat_capacity_j_per_k = 1e4 / k_per_w,
                            .thermal_resistance_k_per_w = k_per_w};
  const PeriodMap map(AssembleSmooth(scene, {}, {.heating = heating}), scene.drive,
                      {.tolerance = 1e-10});
  const PeriodicSearch search =
      FindPeriodicMotion(map, RestOf(scene, map), {.transient_periods = 3});
  ASSERT_TRUE(search.found.has_value());
  EXPECT_TRUE(search.found->stable);
  EXPECT_REL(search.found->point.x(search.found->point.x.size() - 1), theta_k, 1e-6,
             "a period's error of 1e-13 where 4.4e-7 is lost in it; the ripple's square");
}

// ------------------------------------------------------------------------------ harmonic balance

// A periodic motion of the scene with the spring by itself: d at 64 times of a period solves
// d = linear part - G f(d), G what a force between mover and case does, harmonic by harmonic.
class HarmonicBalance {
 public:
  HarmonicBalance(const Scene& scene, const StiffeningSpring& spring)
      : model_(AssembleModel(scene)),
        omega_(2 * std::numbers::pi * scene.drive.frequency_hz),
        push_(Eigen::VectorXd::Zero(model_.states())) {
    push_(kMoverVelocity) = 1 / scene.actuator.moving_mass_kg;
    push_(kCaseVelocity) = -1 / (scene.actuator.case_mass_kg +
                                 (scene.adapter ? scene.adapter->motor_side_mass_kg : 0));
    // v = V sin w t: harmonic 1 of half -j V and its conjugate
    driven_ = Response(1, std::complex<double>(0, -scene.drive.amplitude_v / 2) * model_.b);
    Solve(spring);
  }

  // harmonic m of all states
  [[nodiscard]] Eigen::VectorXcd Harmonic(int m) const {
    std::complex<double> force = 0;
    for (int k = 0; k < kTimes; ++k) force += force_(k) * Turn(-m * k) / double{kTimes};
    Eigen::VectorXcd x = Response(m, -force * push_);
    if (m == 1) x += driven_;
    if (m == -1) x += driven_.conjugate();
    return x;
  }
  [[nodiscard]] double MeanSquare(const Eigen::RowVectorXd& row) const {
    double sum = 0;
    for (int m = -kTimes / 2 + 1; m < kTimes / 2; ++m) sum += std::norm((row * Harmonic(m))(0));
    return sum;
  }
  [[nodiscard]] Eigen::RowVectorXd travel() const {
    return Eigen::RowVectorXd::Unit(model_.states(), kMover) -
           Eigen::RowVectorXd::Unit(model_.states(), kCase);
  }

 private:
  static constexpr int kTimes = 64;
  static std::complex<double> Turn(int k) {
    return std::polar(1.0, 2 * std::numbers::pi * k / kTimes);
  }
  [[nodiscard]] Eigen::VectorXcd Response(int m, const Eigen::VectorXcd& source) const {
    Eigen::MatrixXcd matrix = -model_.a.cast<std::complex<double>>();
    matrix.diagonal().array() += std::complex<double>(0, m * omega_);
    return matrix.partialPivLu().solve(source);
  }
  void Solve(const StiffeningSpring& spring) {
    Eigen::VectorXd linear(kTimes), compliance = Eigen::VectorXd::Zero(kTimes);
    for (int j = 0; j < kTimes; ++j) linear(j) = 2 * ((travel() * driven_)(0) * Turn(j)).real();
    for (int m = -kTimes / 2 + 1; m < kTimes / 2; ++m) {
      const std::complex<double> response = (travel() * Response(m, push_))(0);
      for (int j = 0; j < kTimes; ++j) compliance(j) += (response * Turn(m * j)).real() / kTimes;
    }
    Eigen::MatrixXd G(kTimes, kTimes);
    for (int j = 0; j < kTimes; ++j) {
      for (int k = 0; k < kTimes; ++k) G(j, k) = compliance((j - k + kTimes) % kTimes);
    }
    Eigen::VectorXd d = linear, stiffness(kTimes);
    force_.resize(kTimes);
    for (int i = 0; i < 30; ++i) {
      for (int k = 0; k < kTimes; ++k) {
        force_(k) = spring.Force(d(k));
        stiffness(k) = spring.Stiffness(d(k));
      }
      const Eigen::MatrixXd slope =
          Eigen::MatrixXd::Identity(kTimes, kTimes) + G * stiffness.asDiagonal();
      d -= slope.partialPivLu().solve(d - linear + G * force_);
    }
  }

  LinearModel model_;
  double omega_;
  Eigen::VectorXcd push_;
  Eigen::VectorXcd driven_;
  Eigen::VectorXd force_;
};

TEST(PeriodicMotion, OfADuffingSpringIsItsHarmonicBalance) {
  for (const Scene& scene : {FromRest(tests::AdapterScene()), FromRest(tests::DirectScene())}) {
    for (const StiffeningSpring& spring :
         {StiffeningSpring{1e8, 0}, StiffeningSpring{1e9, 0}, StiffeningSpring{1e9, 1e-4}}) {
      const PeriodMap map(AssembleSmooth(scene, {}, {.spring = spring}), scene.drive,
                          {.tolerance = 1e-10});
      const PeriodicSearch search =
          FindPeriodicMotion(map, RestOf(scene, map), {.transient_periods = 60});
      ASSERT_TRUE(search.found.has_value());
      EXPECT_EQ(search.found->drive_periods, 1);
      const HarmonicBalance balance(scene, spring);
      const Eigen::RowVectorXd skin =
          Eigen::RowVectorXd::Unit(AssembleModel(scene).states(), SkinOf(scene));
      EXPECT_REL(search.found->means.mean_squares(SkinOf(scene)), balance.MeanSquare(skin), 1e-8,
                 "1e-10 for each step of a ringing resonance");
      EXPECT_REL(search.found->means.travel_mean_square, balance.MeanSquare(balance.travel()), 1e-8,
                 "1e-10 for each step of a ringing resonance");
    }
  }
}

// ------------------------------------------------------------------------------- stops, contact

TEST(PeriodicMotion, WithStopsIsWhatALongTransientEndsIn) {
  const Scene scene = FromRest(tests::AdapterScene());
  const PiecewiseEffects effects{
      .stops = TravelStops{.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0.5}};
  const PeriodMap map = ExactMap(scene, effects);
  const PeriodicSearch search =
      FindPeriodicMotion(map, RestOf(scene, map), {.transient_periods = 30});
  ASSERT_TRUE(search.found.has_value());
  const PeriodicMotion& found = *search.found;
  EXPECT_TRUE(found.stable);
  EXPECT_EQ(found.means.events, 2U);
  EXPECT_LT(search.periods_played, 300);

  constexpr std::uint64_t kOutputs = 1 << 12;
  PiecewiseMotion motion(AssemblePiecewise(scene, effects), scene.drive, PiecewiseStartOf(scene),
                         kOutputs * scene.drive.frequency_hz);
  while (motion.index() < 200 * kOutputs) motion.Next();
  EXPECT_ABS((motion.Positions() - found.point.x)
                 .cwiseQuotient(map.ScaleOf(found.point))
                 .cwiseAbs()
                 .maxCoeff(),
             0, 1e-10, "0.78^200 of the transient is left");
  double sum = 0;
  while (motion.index() < 201 * kOutputs) {
    motion.Next();
    sum += std::pow(motion.Positions()(SkinOf(scene)), 2) / static_cast<double>(kOutputs);
  }
  EXPECT_REL(found.means.mean_squares(SkinOf(scene)), sum, 1e-6,
             "a sum of 4096 samples with kinks");
}

TEST(PeriodicMotion, TheDirectSceneUnderItsOwnWeightNeedsTwoPeriods) {
  const Scene scene = FromRest(tests::DirectScene());
  const PiecewiseEffects effects{.contact_loss = ContactLoss{2e-3 * 9.80665}};
  const PeriodMap map = ExactMap(scene, effects);
  const PeriodicSearch search = FindPeriodicMotion(map, RestOf(scene, map));
  ASSERT_TRUE(search.found.has_value());
  const PeriodicMotion& found = *search.found;
  EXPECT_EQ(found.drive_periods, 2);
  EXPECT_TRUE(found.stable);
  // it is where a long transient ends, and one period is not enough
  const PeriodPoint late = map.After(RestOf(scene, map), 2000)->point;
  const auto apart = [&](const PeriodPoint& a, const PeriodPoint& b) {
    if (a.mode != b.mode) return std::numeric_limits<double>::infinity();
    return (a.x - b.x).cwiseQuotient(map.ScaleOf(b)).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(std::min(apart(late, found.point), apart(map.After(late, 1)->point, found.point)),
            1e-10);
  EXPECT_GT(apart(map.After(found.point, 1)->point, found.point), 1e-2);
  // and of another integrator too
  const PeriodMap other(AssembleSmooth(scene, effects, {}), scene.drive, {.tolerance = 1e-10});
  EXPECT_ABS(apart(other.After(found.point, 2)->point, found.point), 0, 1e-8, "its tolerance");
}

TEST(PeriodicMotion, TheDirectSceneAt70MillinewtonsIsChaotic) {
  // it wanders in two bands for ever
  const Scene scene = FromRest(tests::DirectScene());
  const PeriodMap map = ExactMap(scene, {.contact_loss = ContactLoss{0.07}});
  const PeriodicSearch search = FindPeriodicMotion(map, RestOf(scene, map));
  EXPECT_FALSE(search.found.has_value());
  ASSERT_TRUE(search.chaotic.has_value());
  const ChaoticMotion& chaotic = *search.chaotic;
  EXPECT_GT(chaotic.exponent, 4 * chaotic.exponent_standard_uncertainty);
  // the averages are those of other stretches of it, to their own uncertainty
  const PeriodPoint later = map.After(chaotic.point, 5000)->point;
  const PeriodMeans other = map.After(later, chaotic.periods, true)->means.value();
  const Eigen::Index skin = SkinOf(scene);
  EXPECT_ABS(chaotic.means.mean_squares(skin), other.mean_squares(skin),
             5 * std::sqrt(2.0) * chaotic.standard_uncertainties.mean_squares(skin),
             "five standard uncertainties of the difference of two averages");
  EXPECT_LT(chaotic.standard_uncertainties.mean_squares(skin),
            0.05 * chaotic.means.mean_squares(skin));
}

// Drives that differ in the last digits have one attractor, which flies high now and then: the
// averages agree to their uncertainties, or are not given.
TEST(PeriodicMotion, AveragesOfNeighboursAgreeOrAreNotGiven) {
  std::vector<PeriodMeans> means, uncertainties;
  Eigen::Index skin = 0;
  for (const double preload_n : {0.02077, 0.02079, 0.02081, 0.0208100002}) {
    Scene scene = FromRest(tests::DirectScene());
    scene.skin = {.stiffness_n_per_m = 1861.2, .damping_n_s_per_m = 2.2185};
    skin = SkinOf(scene);
    const PeriodMap map = ExactMap(scene, {.contact_loss = ContactLoss{preload_n}});
    const PeriodicSearch search = FindPeriodicMotion(map, RestOf(scene, map));
    if (!search.chaotic) {
      ASSERT_TRUE(search.refusal);
      EXPECT_EQ(search.refusal->kind, FindingKind::kNoPeriodicMotion);
      EXPECT_TRUE(NumberOf(*search.refusal, "averaged_periods")) << "one batch saw something rare";
      continue;
    }
    EXPECT_LT(search.chaotic->standard_uncertainties.mean_squares(skin),
              0.01 * search.chaotic->means.mean_squares(skin))
        << "no batch saw what the others did not";
    means.push_back(search.chaotic->means);
    uncertainties.push_back(search.chaotic->standard_uncertainties);
  }
  ASSERT_GE(means.size(), 2U);
  for (std::size_t k = 1; k < means.size(); ++k) {
    EXPECT_ABS(
        means[k].mean_squares(skin), means[0].mean_squares(skin),
        5 * std::hypot(uncertainties[k].mean_squares(skin), uncertainties[0].mean_squares(skin)),
        "five standard uncertainties of the difference of two averages");
  }
}

// The attractor is the one that the transient from the start comes to, whatever else there is.
TEST(PeriodicMotion, IsTheOneThatTheTransientComesTo) {
  struct Case {
    double gap_m, amplitude_v, frequency_hz;
  };
  for (const Case& c : {Case{4e-4, 5, 225}, Case{3.6e-4, 5, 225}, Case{3.2e-4, 4.6, 221},
                        Case{2.8e-4, 5.3, 228}, Case{4.4e-4, 5.2, 224}}) {
    Scene scene = FromRest(tests::AdapterScene());
    scene.drive.amplitude_v = c.amplitude_v;
    scene.drive.frequency_hz = c.frequency_hz;
    const PiecewiseEffects effects{
        .stops = TravelStops{.gap_up_m = c.gap_m, .gap_down_m = c.gap_m, .stiffness_n_per_m = 1e6}};
    const PeriodMap map = ExactMap(scene, effects);
    const PeriodicSearch search = FindPeriodicMotion(map, RestOf(scene, map));
    ASSERT_TRUE(search.found) << c.gap_m;
    PeriodPoint late = map.After(RestOf(scene, map), 6000)->point;
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < search.found->drive_periods; ++k) {
      if (late.mode == search.found->point.mode) {
        nearest = std::min(nearest, (late.x - search.found->point.x)
                                        .cwiseQuotient(map.ScaleOf(late))
                                        .cwiseAbs()
                                        .maxCoeff());
      }
      late = map.After(late, 1)->point;
    }
    EXPECT_ABS(nearest, 0, 1e-8, "6000 periods of transient have died out");
    EXPECT_TRUE(search.found->stable);
  }
}

// From rest it repeats itself every sixth period; a motion of one period exists beside it.
TEST(PeriodicMotion, SixPeriodsBesideOne) {
  const Scene scene = FromRest(tests::AdapterScene());
  const PiecewiseEffects effects{
      .stops = TravelStops{.gap_up_m = 4e-4, .gap_down_m = 4e-4, .stiffness_n_per_m = 1e6}};
  const PeriodMap map = ExactMap(scene, effects);
  const PeriodicSearch search = FindPeriodicMotion(map, RestOf(scene, map));
  ASSERT_TRUE(search.found.has_value());
  EXPECT_EQ(search.found->drive_periods, 6);
  // by scene_reference.cc: 1200 periods from rest, in which states come back after six, not three
  EXPECT_REL(std::sqrt(search.found->means.mean_squares(SkinOf(scene))), 7.536454150263104e-05,
             1e-12, "another integrator in long double");
  // where the mover is then at phase 0
  constexpr double kMover_m[] = {401.98506873e-6, 267.09641479e-6, -54.23186214e-6,
                                 70.48451331e-6,  217.18078126e-6, 331.32641840e-6};
  double nearest_m = 1;
  for (const double mover_m : kMover_m) {
    nearest_m = std::min(nearest_m, std::abs(search.found->point.x(kMover) - mover_m));
  }
  EXPECT_ABS(nearest_m, 0, 1e-14, "the printed digits");
}

TEST(PeriodicMotion, ASearchReportsItsWork) {
  const Scene scene = FromRest(tests::AdapterScene());
  const PeriodMap map = ExactMap(scene, {.stops = TravelStops{.gap_up_m = 1, .gap_down_m = 1}});
  std::vector<double> shares;
  {
    const WatchedWork watched([&](std::string_view what, double share) {
      EXPECT_EQ(what, "looking for the steady motion");
      shares.push_back(share);
    });
    ASSERT_TRUE(FindPeriodicMotion(map, RestOf(scene, map)).found.has_value());
  }
  ASSERT_GT(shares.size(), 2);
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_GT(shares.back(), 0);
  EXPECT_LT(shares.back(), 1);
  const std::size_t so_far = shares.size();
  ReportWork("nobody looks on", 1);
  EXPECT_EQ(shares.size(), so_far);
}

TEST(PeriodicMotion, WhatIsNotFoundIsSaid) {
  const Scene scene = FromRest(tests::AdapterScene());
  const PeriodMap map = ExactMap(scene, {});
  const PeriodicSearch none = FindPeriodicMotion(
      map, RestOf(scene, map), {.transient_periods = 8, .most_periods = 8, .newton_steps = 0});
  EXPECT_FALSE(none.found.has_value());
  EXPECT_FALSE(none.chaotic.has_value()) << "deviations of a linear motion die out";
  ASSERT_TRUE(none.refusal);
  EXPECT_EQ(none.refusal->kind, FindingKind::kNoPeriodicMotion);
  EXPECT_LE(NumberOf(*none.refusal, "transient_periods"), NumberOf(*none.refusal, "periods"));
  EXPECT_LT(NumberOf(*none.refusal, "growth").value_or(0), 0);
  EXPECT_FALSE(NumberOf(*none.refusal, "most_steps")) << "the work is not spent";
  EXPECT_GT(none.periods_played, 0);

  const PeriodMap smooth(AssembleSmooth(scene, {}, {}), scene.drive, {});
  PeriodPoint broken = RestOf(scene, smooth);
  broken.x(0) = std::nan("");
  const PeriodicSearch stopped = FindPeriodicMotion(smooth, broken);
  ASSERT_TRUE(stopped.refusal);
  EXPECT_EQ(stopped.refusal->kind, FindingKind::kSolverStopped);
  EXPECT_TRUE(NumberOf(*stopped.refusal, "periods"));

  const PeriodMap stops = ExactMap(scene, {.stops = TravelStops{.gap_up_m = 1, .gap_down_m = 1}});
  const PeriodicSearch spent = FindPeriodicMotion(stops, RestOf(scene, stops), {.most_steps = 0});
  EXPECT_FALSE(spent.found.has_value());
  ASSERT_TRUE(spent.refusal);
  EXPECT_EQ(spent.refusal->kind, FindingKind::kNoPeriodicMotion);
  EXPECT_EQ(NumberOf(*spent.refusal, "most_steps"), 0);

  // a current that settles in 3e-12 s beside a drive of 500 Hz
  Scene fast = scene;
  fast.actuator.inductance_h = 1e-9;
  fast.actuator.resistance_ohm = 300;
  const PeriodMap watched = ExactMap(fast, {.stops = TravelStops{.gap_up_m = 1, .gap_down_m = 1}});
  const PeriodicSearch stalled = FindPeriodicMotion(watched, RestOf(fast, watched));
  EXPECT_FALSE(stalled.found.has_value());
  ASSERT_TRUE(stalled.refusal);
  EXPECT_EQ(stalled.refusal->kind, FindingKind::kBodiesTooFast);
}

// Multipliers on the unit circle are not within it by more than their error, on whichever side
// rounding puts them.
TEST(PeriodicMotion, IsNotStableWhereNothingDamps) {
  for (const double frequency_hz : {31.0, 47.0, 83.0, 120.0, 190.0, 260.0, 333.0, 410.0}) {
    Scene scene = tests::DirectScene();
    scene.actuator.damping_n_s_per_m = 0;
    scene.actuator.force_constant_n_per_a = 1e-9;
    scene.skin.damping_n_s_per_m = 0;
    scene.drive.frequency_hz = frequency_hz;
    scene.start = Start::kSteady;
    const PeriodMap map = ExactMap(scene, {});
    const PeriodicSearch search = FindPeriodicMotion(
        map, RestOf(scene, map), {.transient_periods = 2, .most_periods = 2, .most_steps = 400});
    EXPECT_FALSE(search.found) << frequency_hz;
    ASSERT_TRUE(search.refusal) << frequency_hz;
    EXPECT_LT(NumberOf(*search.refusal, "nearest_recurrence").value_or(1), 1e-6)
        << "it repeats itself all the same";
  }
}

// deviations of a linear motion fall as its slowest pole does, ln |exp(p / f)| each period; the
// search has 32 x 32 periods for it, beside those of its transient
TEST(PeriodicMotion, MeasuresTheGrowthOfDeviations) {
  for (const Scene& scene : {FromRest(tests::AdapterScene()), FromRest(tests::DirectScene())}) {
    const PeriodMap map = ExactMap(scene, {});
    const PeriodicSearch none = FindPeriodicMotion(
        map, RestOf(scene, map), {.transient_periods = 8, .most_periods = 8, .newton_steps = 0});
    ASSERT_TRUE(none.refusal);
    const double slowest = AssembleModel(scene).a.eigenvalues().real().maxCoeff();
    EXPECT_ABS(NumberOf(*none.refusal, "growth").value_or(0), slowest / scene.drive.frequency_hz,
               0.01, "ln 1e4 of how a deviation turns into that of the slowest mode, over 1024");
    const double uncertainty = NumberOf(*none.refusal, "growth_uncertainty").value_or(1);
    EXPECT_GT(uncertainty, 0);
    EXPECT_LT(uncertainty, 0.05);
    EXPECT_EQ(NumberOf(*none.refusal, "transient_periods"), 8 + 32 * 32);
    EXPECT_EQ(NumberOf(*none.refusal, "most_periods"), 32);
    EXPECT_EQ(NumberOf(*none.refusal, "periods"), static_cast<double>(none.periods_played));
    EXPECT_EQ(NumberOf(*none.refusal, "steps"), static_cast<double>(none.steps));
  }
}

// with other settings it is the same motion, to the smaller error
TEST(PeriodicMotion, IsFoundAgainFromBesideIt) {
  const Scene scene = FromRest(tests::AdapterScene());
  const PeriodMap map = ExactMap(
      scene, {.stops = TravelStops{.gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .restitution = 0.5}});
  const PeriodicSearch search = FindPeriodicMotion(map, RestOf(scene, map));
  ASSERT_TRUE(search.found);
  PeriodicMotion beside = *search.found;
  const Eigen::VectorXd scale = map.ScaleOf(beside.point);
  beside.point.x += 1e-5 * scale;
  PeriodicSearch work;
  const auto again = RefinePeriodicMotion(map, beside, {}, work);
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->stable);
  EXPECT_ABS((again->point.x - search.found->point.x).cwiseQuotient(scale).cwiseAbs().maxCoeff(), 0,
             1e-11, "what both state of their places");
  EXPECT_GT(work.periods_played, 0);
  EXPECT_REL(again->means.power_w, search.found->means.power_w, 1e-10, "the same motion");
  beside.drive_periods = 2;
  EXPECT_FALSE(RefinePeriodicMotion(map, beside, {}, work)) << "it is one of one period";
}

}  // namespace
}  // namespace haptometer::sim
