#include "sim/smooth/smooth_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <vector>

#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/smooth/smooth_system.h"
#include "tests/residual.h"
#include "tests/sim/reference/smooth_reference.h"
#include "tests/sim/smooth_scenes.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

using tests::Alone;
using tests::DrawnApart;
using tests::FromRest;
using tests::ReducedMass;
using tests::Rigid;
using tests::RunTo;
using tests::Travel;

SmoothMotion MotionOf(const Scene& scene, const PiecewiseEffects& piecewise,
                      const SmoothEffects& smooth, const SmoothSettings& settings,
                      double rate_hz = 1e4) {
  return {AssembleSmooth(scene, piecewise, smooth), scene.drive, PiecewiseStartOf(scene), rate_hz,
          settings};
}

// ------------------------------------------------------------------------------- no smooth effect

struct Comparison {
  double error = 0;    // of the worst position over its largest value
  double event_s = 0;  // of the worst event
  double speed = 0;    // of the worst guard's fall, over the fastest
  double imbalance = 0;
};

Comparison CompareWithExact(const PiecewiseEffects& effects, const SmoothSettings& settings,
                            const Scene& scene = FromRest(tests::AdapterScene())) {
  const OutputGrid grid{.rate_hz = 1e4};
  const Excitation excitation(scene.drive, scene.finger.tones);
  PiecewiseMotion exact(AssemblePiecewise(scene, effects), excitation, PiecewiseStartOf(scene),
                        grid);
  SmoothMotion motion(AssembleSmooth(scene, effects, {}), excitation, PiecewiseStartOf(scene), grid,
                      settings);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(exact.Positions().size()), apart = largest;
  for (int i = 0; i < 300; ++i) {
    exact.Next();
    motion.Next();
    largest = largest.cwiseMax(exact.Positions().cwiseAbs());
    apart = apart.cwiseMax((motion.Positions() - exact.Positions()).cwiseAbs());
  }
  Comparison comparison{.error = apart.cwiseQuotient(largest).maxCoeff(),
                        .imbalance = motion.Ledger().Imbalance()};
  EXPECT_EQ(motion.events().size(), exact.events().size());
  const std::size_t count = std::min(motion.events().size(), exact.events().size());
  double fastest = 0, speed = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Event &event = motion.events()[k], &other = exact.events()[k];
    EXPECT_EQ(event.transition, other.transition);
    comparison.event_s = std::max(comparison.event_s, std::abs(event.time_s - other.time_s));
    speed = std::max(speed, std::abs(event.guard_rate - other.guard_rate));
    fastest = std::max(fastest, std::abs(other.guard_rate));
  }
  if (fastest > 0) comparison.speed = speed / fastest;
  return comparison;
}

TEST(SmoothMotion, HandsOutTheOutputsFromTheFirstOnOrBehindItsBegin) {
  const Scene scene = FromRest(tests::AdapterScene());
  const auto begun = [&](double origin_s) {
    return SmoothMotion(AssembleSmooth(scene, {}, {}), scene.drive, PiecewiseStartOf(scene),
                        OutputGrid{.rate_hz = 1e4, .origin_s = origin_s}, {});
  };
  // a step of the grid is 0.1 ms
  static_cast<void>(begun(-0.9e-4));
  EXPECT_DEATH(static_cast<void>(begun(-1e-4)), "check failed");
  EXPECT_DEATH(static_cast<void>(begun(1e-6)), "check failed");
}

TEST(SmoothMotion, WithoutSmoothEffectsItIsTheExactMotion) {
  const TravelStops soft{
      .gap_up_m = 0.3e-3, .gap_down_m = 0.3e-3, .stiffness_n_per_m = 1e6, .damping_n_s_per_m = 1};
  const std::vector<PiecewiseEffects> cases{
      {},
      {.stops = Rigid(0.3e-3, 0.5)},
      {.stops = soft, .contact_loss = ContactLoss{0.07}},
      {.stops = Rigid(0.3e-3, 0.5), .contact_loss = ContactLoss{0.07}}};
  for (const PiecewiseEffects& effects : cases) {
    for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
      const Comparison found =
          CompareWithExact(effects, {.tolerance = tolerance, .with_energy = true});
      EXPECT_ABS(found.error, 0, tolerance, "what was asked for");
      EXPECT_ABS(found.event_s, 0, 4e-4 * tolerance, "a velocity's error over its acceleration");
      EXPECT_ABS(found.speed, 0, 10 * tolerance, "a velocity is a state");
      EXPECT_ABS(found.imbalance, 0, tolerance, "integrals as good as the states");
    }
  }
}

TEST(SmoothMotion, ACoilWithoutInductanceIsOneStateLess) {
  Scene scene = FromRest(tests::AdapterScene());
  scene.actuator.inductance_h = 0;
  const std::vector<PiecewiseEffects> cases{
      {},
      {.stops = Rigid(0.2e-3, 0.0)},  // at rest the force between the two feels the voltage
      {.stops = Rigid(0.3e-3, 0.5), .contact_loss = ContactLoss{0.07}}};
  for (const PiecewiseEffects& effects : cases) {
    const SmoothSettings settings{.tolerance = 1e-7, .with_energy = true};
    const Comparison found = CompareWithExact(effects, settings, scene);
    EXPECT_ABS(found.error, 0, 1e-7, "what was asked for");
    EXPECT_ABS(found.event_s, 0, 4e-11, "a velocity's error over its acceleration");
    EXPECT_ABS(found.imbalance, 0, 1e-7, "integrals as good as the states");
  }
  // and where it heats, no heat is lost, nor what the source takes
  scene.drive.source_resistance_ohm = 5;
  const CoilHeating heating{.heat_capacity_j_per_k = 1e-4,
                            .thermal_resistance_k_per_w = std::numeric_limits<double>::infinity()};
  SmoothMotion motion =
      MotionOf(scene, {}, {.heating = heating}, {.tolerance = 1e-8, .with_energy = true});
  RunTo(motion, 300);
  EXPECT_GT(motion.temperature_rise_k(), 50);
  EXPECT_REL(motion.Ledger().dissipated_j[0], 1e-4 * motion.temperature_rise_k(), 1e-8,
             "the tolerance");
  EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-8, "the tolerance");
}

// what moves the finger, and drives that come in pieces, some of which end between outputs
TEST(SmoothMotion, UnderAnyExcitationItIsTheExactMotion) {
  Scene scene = FromRest(tests::AdapterScene());
  scene.finger.tones = {{.amplitude = 50e-6, .frequency_hz = 9, .phase_rad = 1},
                        {.amplitude = 5e-6, .frequency_hz = 340}};
  const Drive sine = scene.drive;
  Drive burst = sine;
  burst.kind = DriveKind::kBurst;
  burst.start_s = 1.23456e-3;
  burst.rise_s = 4e-3;
  burst.hold_s = 11e-3;
  burst.fall_s = 5e-3;
  Drive pulse{.amplitude_v = 5, .kind = DriveKind::kPulse};
  pulse.start_s = 2e-3;
  pulse.hold_s = 3.14159e-3;
  const std::vector<PiecewiseEffects> cases{
      {}, {.stops = Rigid(0.2e-3, 0.5), .contact_loss = ContactLoss{0.07}}};
  for (const Drive& drive : {sine, burst, pulse}) {
    scene.drive = drive;
    for (const double inductance_h : {130e-6, 0.0}) {
      scene.actuator.inductance_h = inductance_h;
      for (const PiecewiseEffects& effects : cases) {
        const SmoothSettings settings{.tolerance = 1e-7, .with_energy = true};
        const Comparison found = CompareWithExact(effects, settings, scene);
        EXPECT_ABS(found.error, 0, 1e-7, "what was asked for");
        EXPECT_ABS(found.event_s, 0, 1e-9, "1e-7 of 0.3 mm over a slow impact's 0.03 m/s");
        EXPECT_ABS(found.imbalance, 0, 1e-7, "integrals as good as the states");
      }
    }
  }
}

TEST(SmoothMotion, TheErrorFallsWithTheTolerance) {
  const PiecewiseEffects effects{.stops = Rigid(0.3e-3, 0.5)};
  double before = 1;
  for (const double tolerance : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
    const Comparison found =
        CompareWithExact(effects, {.tolerance = tolerance, .with_energy = true});
    EXPECT_ABS(found.error, 0, tolerance, "what was asked for");
    EXPECT_LT(found.error, std::max(before, 2e-12)) << "rounding of events, 1e-12 at last";
    before = found.error;
  }
}

TEST(SmoothMotion, WhatIsNeverReachedAndHowOftenOneLooksLeaveNoTrace) {
  const Scene scene = FromRest(tests::AdapterScene());
  const SmoothEffects smooth{.spring = StiffeningSpring{3e9}};
  const SmoothSettings settings{.tolerance = 1e-6};
  SmoothMotion bare = MotionOf(scene, {}, smooth, settings);
  const PiecewiseEffects far{.stops = Rigid(1, 0.5), .contact_loss = ContactLoss{100.0}};
  SmoothMotion guarded = MotionOf(scene, far, smooth, settings);
  SmoothMotion often = MotionOf(scene, far, smooth, settings, 8e4);
  for (std::uint64_t i = 1; i <= 200; ++i) {
    RunTo(bare, i);
    RunTo(guarded, i);
    RunTo(often, 8 * i);
    EXPECT_EQ(bare.x(), guarded.x());
    EXPECT_EQ(bare.x(), often.x());
  }
}

// of spring, heat and stops, looked at every output, in outputs of an eighth, or at the ends alone
TEST(SmoothMotion, RangesDoNotDependOnHowOftenTheyAreAskedFor) {
  const Scene scene = FromRest(tests::AdapterScene());
  const PiecewiseEffects effects{.stops = Rigid(0.3e-3, 0.5)};
  SmoothSystem system = AssembleSmooth(
      scene, effects, {.spring = StiffeningSpring{3e9}, .heating = CoilHeating{1e-3, 100}});
  WatchTravelAndForce(scene, effects, system.linear);
  const auto motion_at = [&](double rate_hz) {
    return SmoothMotion(system, scene.drive, PiecewiseStartOf(scene), rate_hz, {.tolerance = 1e-6});
  };
  SmoothMotion seldom = motion_at(1e4), always = motion_at(1e4), often = motion_at(8e4);
  ValueRange outputs;
  const auto go_to = [&](std::uint64_t end) {
    while (always.index() < end) {
      always.Next();
      std::ignore = always.Ranges();
      outputs.Include(Travel(always));
    }
    RunTo(seldom, end);
    RunTo(often, 8 * end);
  };
  const auto expect_equal = [&] {
    for (SmoothMotion* motion : {&seldom, &often}) {
      for (std::size_t k = 0; k < always.Ranges().size(); ++k) {
        const ValueRange &expected = always.Ranges()[k], &found = motion->Ranges()[k];
        EXPECT_REL(found.largest, expected.largest, 1e-12, "rounding of the steps' polynomials");
        EXPECT_REL(found.least, expected.least, 1e-12, "rounding of the steps' polynomials");
      }
      EXPECT_REL(motion->temperature_peak_k(), always.temperature_peak_k(), 1e-14, "rounding");
    }
    const double largest_m = always.Ranges()[kWatchedTravel].largest;
    EXPECT_GE(largest_m, outputs.largest - 1e-15) << "rounding, m";
    EXPECT_LE(largest_m, 0.3e-3 * (1 + 1e-6)) << "the stop";
  };
  go_to(95);
  expect_equal();
  // forgotten in the midst of steps that two of them were not looked at; then two outputs alone
  for (std::uint64_t begin = 100; begin < 200; begin += 7) {
    go_to(begin);
    for (SmoothMotion* motion : {&seldom, &always, &often}) motion->ForgetRanges();
    outputs = {};
    go_to(begin + 2);
    expect_equal();
  }
}

// d = A cos w t falls for half a period: between outputs within one step it comes to no other
// values than those at its ends
TEST(SmoothMotion, RangesEndWithTheOutput) {
  const Scene scene = Alone();
  constexpr double A = 0.5e-3;
  SmoothSystem system = AssembleSmooth(scene, {}, {});
  WatchTravelAndForce(scene, {}, system.linear);
  SmoothMotion motion(system, scene.drive, DrawnApart(scene, A), 2e4, {.tolerance = 1e-10});
  const double w = std::sqrt(scene.actuator.stiffness_n_per_m / ReducedMass(scene));
  for (int i = 1; i * w / 2e4 < 3; ++i) {
    motion.ForgetRanges();
    const double before = Travel(motion);
    motion.Next();
    const ValueRange& travel = motion.Ranges()[kWatchedTravel];
    EXPECT_ABS(travel.largest, before, 1e-14 * A, "rounding");
    EXPECT_ABS(travel.least, A * std::cos(w * i / 2e4), 1e-9 * A, "the tolerance");
  }
}

// solver's steps over 0.2 s of a linear scene that is steady from the first
std::int64_t StepsUnder(const Drive& drive, double rate_hz, const SmoothSettings& settings = {}) {
  Scene scene = FromRest(tests::AdapterScene());
  scene.drive = drive;
  SmoothMotion motion(AssembleSmooth(scene, {}, {}), Excitation(drive, {}), PiecewiseStartOf(scene),
                      OutputGrid{.rate_hz = rate_hz}, settings);
  RunTo(motion, static_cast<std::uint64_t>(0.2 * rate_hz));
  return motion.steps();
}

// steps of 2^-10 s and of 2^-11 s; some thirty shorter ones at the beginning
TEST(SmoothMotion, StepsAreAQuarterOfTheFastestPeriodAtMost) {
  const auto steps = [](double frequency_hz) {
    const Drive sine{.amplitude_v = 5, .frequency_hz = frequency_hz};
    return StepsUnder(sine, 1000, {.tolerance = 1e-5});
  };
  EXPECT_GE(steps(255), 205) << "0.25 periods are 980 us";
  EXPECT_LE(steps(255), 205 + 60);
  EXPECT_GE(steps(257), 410) << "0.25 periods are 973 us";
  EXPECT_LE(steps(257), 410 + 60);
  // the faster of two tones
  const Drive tones{
      .kind = DriveKind::kTones,
      .tones = {{.amplitude = 1, .frequency_hz = 257}, {.amplitude = 1, .frequency_hz = 20}}};
  EXPECT_GE(StepsUnder(tones, 1000, {.tolerance = 1e-5}), 410);
  // and as many as are set
  const Drive sine{.amplitude_v = 5, .frequency_hz = 127};
  EXPECT_GE(StepsUnder(sine, 1000, {.tolerance = 1e-5, .longest_step_periods = 0.12}), 205);
}

// without tones an output step, or a piece that is shorter
TEST(SmoothMotion, StepsWithoutTonesAreOutputStepsAtMost) {
  const Drive pulse{.amplitude_v = 5, .kind = DriveKind::kPulse, .hold_s = 0.2};
  EXPECT_GE(StepsUnder(pulse, 1025, {.tolerance = 1e-5}), 410) << "steps of 2^-11 s";
  EXPECT_LE(StepsUnder(pulse, 1023, {.tolerance = 1e-5}), 205 + 60) << "steps of 2^-10 s";
  EXPECT_GE(StepsUnder(pulse, 1000, {.tolerance = 1e-5, .longest_step_periods = 0.125}), 410);
}

TEST(SmoothMotion, StatesTheToleranceThatRoundingLets) {
  const Scene scene = FromRest(tests::AdapterScene());
  EXPECT_REL(MotionOf(scene, {}, {}, {.tolerance = 1e-9}).tolerance(), 1e-9, 1e-15, "as asked");
  EXPECT_REL(MotionOf(scene, {}, {}, {.tolerance = 2e-13}).tolerance(), 2e-13, 1e-15, "as asked");
  EXPECT_REL(MotionOf(scene, {}, {}, {.tolerance = 1e-13}).tolerance(), 1.9e-13, 0.003,
             "as stated, two digits");
}

// rates of the steady motion are j w X, of the current as well
TEST(SmoothMotion, RatesAreThoseOfTheSteadyMotion) {
  for (const double inductance_h : {1e-3, 0.0}) {
    Scene scene = tests::AdapterScene();
    scene.start = Start::kSteady;
    scene.actuator.inductance_h = inductance_h;
    const SteadyState steady = SolveSteadyState(scene);
    SmoothMotion motion = MotionOf(scene, {}, {}, {.tolerance = 1e-10});
    RunTo(motion, 7);
    const std::complex<double> jw(0, 2 * std::numbers::pi * 225);
    const Eigen::VectorXcd rates = jw * std::exp(jw * 7e-4) * steady.phasors;
    EXPECT_ABS(
        (motion.Rates() - rates.imag()).cwiseQuotient(rates.cwiseAbs()).cwiseAbs().maxCoeff(), 0,
        1e-7, "the current's rate: the tolerance times R/L over w");
  }
}

// ------------------------------------------------------------------------------ stiffening spring

TEST(SmoothMotion, AnUndampedDuffingSpringFollowsTheEllipticCosine) {
  const Scene scene = Alone();
  const double Kv = scene.actuator.stiffness_n_per_m, mass_kg = ReducedMass(scene);
  constexpr double A = 0.8e-3;
  for (const double K3 : {0.0, 1e8, 3e9, 1e12}) {
    // x = A cn(W t, k), W^2 = (Kv + K3 A^2)/m, k^2 = K3 A^2 / (2 (Kv + K3 A^2)); period 4 K(k)/W
    const double stiffness = Kv + K3 * A * A;
    const double W = std::sqrt(stiffness / mass_kg);
    const double k = std::sqrt(K3 * A * A / (2 * stiffness));
    const double period_s = 4 * std::comp_ellint_1(k) / W;
    SmoothMotion motion(AssembleSmooth(scene, {}, {.spring = StiffeningSpring{K3}}), scene.drive,
                        DrawnApart(scene, A), 16 / period_s,
                        {.tolerance = 1e-10, .with_energy = true});
    double worst = 0;
    for (std::uint64_t i = 1; i <= 160; ++i) {
      RunTo(motion, i);
      const double t_s = static_cast<double>(i) * period_s / 16;
      worst = std::max(worst, std::abs(Travel(motion) / A - boost::math::jacobi_cn(k, W * t_s)));
    }
    EXPECT_ABS(worst, 0, 1e-9, "ten periods at 1e-10: the phase's error grows with each");
    EXPECT_REL(Travel(motion), A, 1e-10, "a whole number of periods");
    EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-9, "no loss, no input: the stored energy stays");
    EXPECT_REL(motion.Ledger().initial_j, Kv * A * A / 2 + K3 * std::pow(A, 4) / 4, 1e-14,
               "Kv A^2/2 + K3 A^4/4");
  }
}

// a case that is held stays where it is, and the mover swings as against the ground
TEST(SmoothMotion, AgainstAHeldCaseTheMoverSwingsAlone) {
  Scene scene = Alone();
  scene.grip.holds = true;
  const double Kv = scene.actuator.stiffness_n_per_m, mass_kg = scene.actuator.moving_mass_kg;
  constexpr double A = 0.8e-3;
  for (const double K3 : {0.0, 1e8, 3e9, 1e12}) {
    const double stiffness = Kv + K3 * A * A;
    const double W = std::sqrt(stiffness / mass_kg);
    const double k = std::sqrt(K3 * A * A / (2 * stiffness));
    PiecewiseStart start{.x = Eigen::VectorXd::Zero(5)};
    start.x(LinearModel::kMover) = A;
    SmoothMotion motion(AssembleSmooth(scene, {}, {.spring = StiffeningSpring{K3}}), scene.drive,
                        start, 1e4, {.tolerance = 1e-10});
    double worst = 0;
    for (std::uint64_t i = 1; i <= 400; ++i) {
      RunTo(motion, i);
      EXPECT_EQ(motion.Positions()(LinearModel::kCase), 0);
      const double t_s = static_cast<double>(i) * 1e-4;
      worst = std::max(worst, std::abs(Travel(motion) / A - boost::math::jacobi_cn(k, W * t_s)));
    }
    EXPECT_ABS(worst, 0, 5e-9, "up to 40 periods at 1e-10: the phase's error grows with each");
  }
}

TEST(SmoothMotion, TheSagShiftsTheSwing) {
  // about s the spring is another one: Kv + 3 K3 s^2, 3 K3 s d^2 besides the cube; energy is kept,
  // and the far turning point is where U equals its value at the near one
  const Scene scene = Alone();
  const StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 3e-4};
  constexpr double A = 0.5e-3;
  const auto energy = [&](double d) {
    return scene.actuator.stiffness_n_per_m * d * d / 2 + spring.Energy(d);
  };
  double low = -2 * A, high = 0;
  while (high - low > 1e-18) {
    const double middle = (low + high) / 2;
    (energy(middle) > energy(A) ? low : high) = middle;
  }
  SmoothMotion motion(AssembleSmooth(scene, {}, {.spring = spring}), scene.drive,
                      DrawnApart(scene, A), 2e5, {.tolerance = 1e-10, .with_energy = true});
  double least = 0;
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    RunTo(motion, i);
    least = std::min(least, Travel(motion));
  }
  EXPECT_REL(least, low, 1e-5, "200 kHz: within 2.5 us of the turning point, (w t)^2/2");
  EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-10, "the tolerance");
}

// -------------------------------------------------------------------------------------- the coil

TEST(SmoothMotion, ConstantResistanceHeatsByTheClosedForm) {
  // Km = 0, alpha = 0: i = I sin(w t - phi) from its steady state on, P = R I^2/2 (1 - cos 2(...))
  Scene scene = Alone();
  scene.drive = {.amplitude_v = 5, .frequency_hz = 225};
  scene.start = Start::kSteady;
  const double R = scene.actuator.resistance_ohm, L = scene.actuator.inductance_h;
  const double w = 2 * std::numbers::pi * 225, phi = std::atan2(w * L, R);
  const double power_w = 12.5 * R / (R * R + w * w * L * L);
  const CoilHeating heating{
      .heat_capacity_j_per_k = 2e-3, .thermal_resistance_k_per_w = 5, .resistance_per_k = 0};
  const double C = heating.heat_capacity_j_per_k, a = 1 / (C * 5);
  PiecewiseStart start{.x = Eigen::VectorXd::Zero(5)};
  start.x(4) = -std::sqrt(2 * power_w / R) * std::sin(phi);
  SmoothMotion motion(AssembleSmooth(scene, {}, {.heating = heating}), scene.drive, start, 1e4,
                      {.tolerance = 1e-9});
  // theta' = -a theta + P/C (1 - cos(2 w t - 2 phi)); the ripple's particular solution
  const auto ripple = [&](double t) {
    return -power_w / C *
           (a * std::cos(2 * w * t - 2 * phi) + 2 * w * std::sin(2 * w * t - 2 * phi)) /
           (a * a + 4 * w * w);
  };
  const double last_k = power_w / C / a;
  for (std::uint64_t i = 1; i <= 500; ++i) {
    RunTo(motion, i);
    const double t = static_cast<double>(i) * 1e-4;
    const double expected =
        last_k * (1 - std::exp(-a * t)) + ripple(t) - ripple(0) * std::exp(-a * t);
    EXPECT_ABS(motion.temperature_rise_k() / last_k, expected / last_k, 1e-9, "the tolerance");
  }
}

TEST(SmoothMotion, NoHeatIsLost) {
  // without a way out all that the coil dissipates warms it, whatever R does meanwhile
  const Scene scene = FromRest(tests::AdapterScene());
  const CoilHeating heating{.heat_capacity_j_per_k = 1e-4,
                            .thermal_resistance_k_per_w = std::numeric_limits<double>::infinity()};
  SmoothMotion motion =
      MotionOf(scene, {}, {.heating = heating}, {.tolerance = 1e-8, .with_energy = true});
  RunTo(motion, 500);
  EXPECT_GT(motion.temperature_rise_k(), 50);
  EXPECT_REL(motion.Ledger().dissipated_j[0], 1e-4 * motion.temperature_rise_k(), 1e-8,
             "the tolerance");
  EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-8, "the tolerance");
}

// --------------------------------------------------------------------------- SciPy, all together

void ExpectReference(const PiecewiseEffects& effects, std::span<const double, 8> state,
                     std::span<const double> events_s) {
  const Scene scene = FromRest(tests::AdapterScene());
  const SmoothEffects smooth{
      .spring = StiffeningSpring{.cubic_n_per_m3 = 3e9, .sag_m = 5e-5},
      .heating = CoilHeating{.heat_capacity_j_per_k = 1e-3, .thermal_resistance_k_per_w = 100}};
  SmoothMotion motion =
      MotionOf(scene, effects, smooth, {.tolerance = 1e-10, .with_energy = true}, 9600);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(7);
  for (std::uint64_t i = 1; i <= 300; ++i) {
    RunTo(motion, i);
    largest = largest.cwiseMax(motion.Positions().cwiseAbs());
  }
  // the reference's first is the current, the program's last
  Eigen::VectorXd expected(7);
  for (Eigen::Index k = 0; k < 6; ++k) expected(k) = state[static_cast<std::size_t>(k) + 1];
  expected(6) = state[0];
  const double worst = (motion.Positions() - expected).cwiseAbs().cwiseQuotient(largest).maxCoeff();
  EXPECT_ABS(worst, 0, 1e-11, "the reference's 1e-13 a step over some hundred steps");
  EXPECT_ABS(motion.temperature_rise_k(), state[7], 1e-10, "1e-11 of the rise");
  EXPECT_ABS(motion.Ledger().Imbalance(), 0, 1e-11, "integrals as good as the states");
  ASSERT_EQ(motion.events().size(), events_s.size());
  for (std::size_t k = 0; k < events_s.size(); ++k) {
    EXPECT_ABS(motion.events()[k].time_s, events_s[k], 1e-14, "velocities to 1e-11 of 1 m/s");
  }
}

TEST(SmoothMotion, SpringAndHeatAgreeWithSciPy) { ExpectReference({}, tests::kSmoothState, {}); }

TEST(SmoothMotion, StopsAgreeWithSciPy) {
  ExpectReference({.stops = Rigid(0.3e-3, 0.5)}, tests::kSmoothStopsState,
                  tests::kSmoothStopsEventsS);
}

TEST(SmoothMotion, BreakingContactAgreesWithSciPy) {
  ExpectReference({.contact_loss = ContactLoss{0.07}}, tests::kSmoothContactState,
                  tests::kSmoothContactEventsS);
}

// of spring, heat over several linear parts of the coil, and stops
TEST(SmoothMotion, RestartLeavesNoTrace) {
  const Scene scene = FromRest(tests::AdapterScene());
  const SmoothEffects smooth{
      .spring = StiffeningSpring{.cubic_n_per_m3 = 3e9},
      .heating = CoilHeating{.heat_capacity_j_per_k = 2e-4, .thermal_resistance_k_per_w = 100}};
  const PiecewiseEffects effects{.stops = Rigid(0.3e-3, 0.5)};
  const SmoothSettings settings{.tolerance = 1e-8};
  SmoothMotion used = MotionOf(scene, effects, smooth, settings);
  RunTo(used, 500);
  ASSERT_GT(used.temperature_rise_k(), 30) << "beyond sqrt(1.2), where the linear part changes";
  ASSERT_FALSE(used.events().empty());
  used.Restart(PiecewiseStartOf(scene), 0);
  SmoothMotion fresh = MotionOf(scene, effects, smooth, settings);
  for (std::uint64_t i = 1; i <= 500; ++i) {
    RunTo(used, i);
    RunTo(fresh, i);
    ASSERT_EQ(used.x(), fresh.x()) << i;
  }
  EXPECT_EQ(used.temperature_rise_k(), fresh.temperature_rise_k());
  EXPECT_EQ(used.events().size(), fresh.events().size());
}

TEST(SolverLadder, DescendsByWhatAHalvedStepLeavesOut) {
  SolverLadder ladder(1e-6);
  EXPECT_REL(ladder.settings().tolerance, 1e-7, 1e-15, "a tenth");
  EXPECT_REL(ladder.before().tolerance, 2048e-7, 1e-15, "2^11 times that");
  EXPECT_EQ(ladder.before().longest_step_periods, 2 * ladder.settings().longest_step_periods);
  EXPECT_TRUE(ladder.EndsWith(0.25e-6));
  EXPECT_FALSE(ladder.EndsWith(0.26e-6));
  ladder.Refine();
  EXPECT_REL(ladder.settings().tolerance, 1e-7 / 2048, 1e-15, "2^11 times less");
  ladder.Refine();
  EXPECT_EQ(ladder.settings().tolerance, 4e-12);
  EXPECT_TRUE(ladder.EndsWith(1)) << "no less is left";
  EXPECT_EQ(SolverLadder(0.5).settings().tolerance, 1e-5);
}

TEST(SmoothMotion, WorkIsCounted) {
  const Scene scene = FromRest(tests::AdapterScene());
  SmoothMotion motion = MotionOf(scene, {.stops = Rigid(0.3e-3, 0.5)}, {}, {.tolerance = 1e-4});
  RunTo(motion, 300);
  const SolverWork work = motion.work();
  EXPECT_GT(work.steps, 27) << "four a period at least, of 6.75";
  EXPECT_EQ(work.evaluations, 0) << "nothing is nonlinear";
  EXPECT_GT(work.operators, 0);
  EXPECT_EQ(work.restarts, static_cast<std::int64_t>(motion.events().size()) + 1);

  SmoothMotion limited = MotionOf(scene, {}, {}, {.tolerance = 1e-4, .most_steps = 10});
  for (int i = 0; i < 300; ++i) limited.Next();
  ASSERT_TRUE(limited.stalled_at_s().has_value());
  EXPECT_EQ(limited.stall_reason(), FindingKind::kTooManySteps);
}

}  // namespace
}  // namespace haptometer::sim
