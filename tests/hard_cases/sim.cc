#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <cstddef>
#include <initializer_list>
#include <numbers>

#include "sim/effect_choice.h"
#include "sim/effective_scene.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/ring_down.h"
#include "sim/scene/effects.h"
#include "sim/scene/scene.h"
#include "sim/scene_run.h"
#include "sim/steady_run.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::hard_cases {
namespace {

// Bars: DampedFundamentals states 4e-16 + 2e-16 |r t|.

TEST(HardCasesSim, CriticalDamping) {
  const double s = 1000;
  const double t = 1e-3;
  const double r = std::sqrt(s * s - s * s);
  Check({"sim", "critical damping", "r = 0: sinh(r t)/r is 0/0", "e^(-s t) sinh(r t)/r", 4e-16},
        {std::exp(-1.0L) * static_cast<long double>(t), sim::DampedFundamentals(s, s * s, t).odd,
         std::exp(-s * t) * std::sinh(r * t) / r});
}

TEST(HardCasesSim, StrongDampingForALongTime) {
  const double s = 1e6;
  const double q = 1e6;
  const double t = 1;
  const double r = std::sqrt(s * s - q);
  // slow root q/(s + r), the fast one is e^-2e6
  const long double root = std::sqrt(1e12L - 1e6L);
  Check({"sim", "damping 1000 times critical, after 1 s", "cosh overflows, e^(-s t) underflows",
         "e^(-s t) cosh(r t)", 4e-16},
        {0.5L * std::exp(-1e6L / (1e6L + root)), sim::DampedFundamentals(s, q, t).even,
         std::exp(-s * t) * std::cosh(r * t)});
}

TEST(HardCasesSim, SlowRootOfStrongDamping) {
  const double s = 1e8;
  const double q = 1e4;
  const double t = 1e4;
  const long double root = std::sqrt(1e16L - 1e4L);
  const double r = std::sqrt(s * s - q);
  Check({"sim", "slow root, damping 1e6 times critical", "s - r cancels",
         "quadratic formula, e^(-(s - r) t)/2", 4e-16},
        {0.5L * std::exp(-1e8L / (1e8L + root)), sim::DampedFundamentals(s, q, t).even,
         0.5 * std::exp(-(s - r) * t)});
}

TEST(HardCasesSim, UndampedOscillationByForwardEuler) {
  const double w = 1024;
  const int steps = 1000;
  const double t = 1.0 / 1024;
  double x = 1;
  double v = 0;
  for (int i = 0; i < steps; ++i) {
    const double before = x;
    x += v * t / steps;
    v -= w * w * before * t / steps;
  }
  Check({"sim", "undamped oscillation, one radian", "a step method adds energy",
         "forward Euler, 1000 steps", 6e-16},
        {std::cos(1.0L), sim::DampedFundamentals(0.0, w * w, t).even, x});
}

TEST(HardCasesSim, StiffeningForceOfATinyTravelBesideASag) {
  const sim::StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 3e-4};
  const double d = 1e-12;
  const long double k3 = 3e9L, s = static_cast<long double>(spring.sag_m),
                    x = static_cast<long double>(d);
  Check({"sim", "stiffening force, 1 pm beside 0.3 mm at rest", "(d + s)^3 - s^3 cancels",
         "K3 ((d + s)^3 - s^3)", 1e-15},
        {k3 * x * (x * x + 3 * s * (x + s)), spring.Force(d),
         3e9 * (std::pow(d + spring.sag_m, 3) - std::pow(spring.sag_m, 3))});
}

TEST(HardCasesSim, StiffeningEnergyOfATinyTravelBesideASag) {
  const sim::StiffeningSpring spring{.cubic_n_per_m3 = 3e9, .sag_m = 3e-4};
  const double d = 1e-10;
  const double s = spring.sag_m;
  const long double k3 = 3e9L, sl = static_cast<long double>(s), x = static_cast<long double>(d);
  Check({"sim", "stiffening energy, 0.1 nm beside 0.3 mm at rest", "fourth powers cancel",
         "K3/4 ((d + s)^4 - s^4) - K3 s^3 d", 1e-15},
        {k3 * x * x * ((x + 2 * sl) * (x + 2 * sl) / 4 + sl * sl / 2), spring.Energy(d),
         3e9 / 4 * (std::pow(d + s, 4) - std::pow(s, 4)) - 3e9 * s * s * s * d});
}

// Cardano's formula of s^3 + p s = q
double Cardano(double p, double q) {
  const double root = std::sqrt(q * q / 4 + p * p * p / 27);
  return std::cbrt(q / 2 + root) + std::cbrt(q / 2 - root);
}

// s of Kv s + K3 s^3 = F by Newton's method in long double, which converges from above
long double SagByNewton(long double force, long double kv, long double k3, long double start) {
  long double s = start;
  for (int k = 0; k < 200; ++k) s -= (kv * s + k3 * s * s * s - force) / (kv + 3 * k3 * s * s);
  return s;
}

TEST(HardCasesSim, SagOfAnAlmostLinearSpring) {
  Check({"sim", "static deflection under 13.7 mN with a cubic of 1e-3 N/m^3",
         "two cube roots cancel", "Cardano's formula", 1e-15},
        {SagByNewton(0.0137L, 2800, 1e-3L, 0.0137L / 2800), sim::SagUnder(0.0137, 2800, 1e-3),
         Cardano(2800 / 1e-3, 0.0137 / 1e-3)});
}

TEST(HardCasesSim, SagOfASpringWithoutALinearPart) {
  Check({"sim", "static deflection of a purely cubic spring", "the linear stiffness is 0", "F / Kv",
         4e-16},
        {1e-3L, sim::SagUnder(1, 0, 1e9), 1 / 0.0});
}

// exp(A) by its Taylor series of 60 terms
Eigen::MatrixXd Taylor(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Identity(a.rows(), a.cols());
  Eigen::MatrixXd term = sum;
  for (int k = 1; k < 60; ++k) {
    term = (term * a / k).eval();
    sum += term;
  }
  return sum;
}

// the bar is eps |A|: what squaring leaves
TEST(HardCasesSim, ExponentialOfAStiffMatrix) {
  Eigen::MatrixXd a(2, 2);
  a << -1e6, 1e6, 0, -1;
  Check({"sim", "exp(A), rates of 1e6 and 1", "terms of 1e6^k cancel", "Taylor series of 60 terms",
         2.3e-10},
        {std::exp(-1.0L) * 1e6L / (1e6L - 1), sim::MatrixExponential(a)(0, 1), Taylor(a)(0, 1)});
}

TEST(HardCasesSim, ExponentialOfManyTurns) {
  Eigen::MatrixXd a(2, 2);
  a << 0, 100, -100, 0;
  Check({"sim", "exp(A), a turn of 100 radians", "terms of 100^k cancel",
         "Taylor series of 60 terms", 1e-13},
        {std::cos(100.0L), sim::MatrixExponential(a)(0, 0), Taylor(a)(0, 0)});
}

// ---------------------------------------------------------------- scenes with effects

// Truths "by another integrator": tests/sim/reference/scene_reference.cc, long double, of which 13
// digits hold. Bars of peaks and least values: 1e-10, what is located between two outputs; of runs
// by the solver the tolerance of the scene; 1e-9 where a steady motion is searched for.

sim::EffectSet With(std::initializer_list<sim::Effect> effects) {
  sim::EffectSet on;
  on.set(sim::PlaceOf(sim::Effect::kInductance));
  for (const sim::Effect effect : effects) on.set(sim::PlaceOf(effect));
  return on;
}

sim::TravelStops StopsAt(double gap_m, double restitution) {
  return {.gap_up_m = gap_m, .gap_down_m = gap_m, .restitution = restitution};
}

TEST(HardCasesSim, RestOnAStopOfAStiffeningSpring) {
  sim::Scene scene = tests::ConeScene();
  scene.start = sim::Start::kRest;
  scene.drive.frequency_hz = 60;
  scene.effects.travel_stops = StopsAt(3e-5, 0);
  scene.effects.stiffening = sim::StiffeningSpring{.cubic_n_per_m3 = 4e12};
  scene.tolerance = 1e-8;
  const sim::EffectSet on = With({sim::Effect::kTravelStops, sim::Effect::kStiffening});
  const sim::SceneRun run = sim::RunScene(sim::WithEffects(scene, on), 0.2);
  const sim::SceneRun linear =
      sim::RunScene(sim::WithEffects(scene, With({sim::Effect::kTravelStops})), 0.2);
  Check({"sim", "skin RMS where the mover rests on rigid stops with K3 = 4e12 N/m^3",
         "the force that holds it there has the cubic in it", "the linear spring alone", 1e-8},
        {1.1484635532232913e-05L, run.skin_rms_m, linear.skin_rms_m});
}

TEST(HardCasesSim, SpeedAfterComingToRest) {
  const sim::Scene scene = tests::ConeScene();
  const sim::PiecewiseLinearSystem system =
      sim::AssemblePiecewise(scene, {.stops = StopsAt(5e-6, 0.8)});
  // the free states begin with those of mover and case, and end with one that is 1
  Eigen::VectorXd x = Eigen::VectorXd::Zero(system.modes[0].a.rows());
  x.head(4) << 6e-6, 0.2, 1e-6, 0.05;
  x(x.size() - 1) = 1;
  double speed = 0;
  for (const sim::Guard& guard : system.modes[0].guards) {
    const sim::Transition& impact = system.transitions[guard.transition];
    if (impact.name != "impact up" || !impact.bounce) continue;
    const sim::Transition& rest = system.transitions[impact.bounce->rest_via];
    speed = (system.modes[rest.mode].positions * (rest.map * x + rest.shift))(1);
  }
  // momentum: (1.4 g 0.2 m/s + 0.6 g 0.05 m/s) / 2 g; the bar: rounding of the map
  Check({"sim", "speed of mover and case that come to rest against each other",
         "bounces that are not played exchange momentum", "the case's speed", 1e-15},
        {0.155L, speed, x(3)});
}

// a mover without damping that flies into a stop, both bodies free; positions from their centre
sim::Scene FreeBodies(double cubic_n_per_m3, double travel_m, double speed_m_per_s) {
  sim::Scene scene;
  scene.actuator = {.moving_mass_kg = 1e-3,
                    .case_mass_kg = 1e-3,
                    .stiffness_n_per_m = 1000,
                    .force_constant_n_per_a = 1e-9,
                    .resistance_ohm = 10};
  scene.drive = {.frequency_hz = 225};
  scene.start = sim::Start::kRest;
  scene.initial = {.mover_m = travel_m / 2,
                   .mover_m_per_s = speed_m_per_s / 2,
                   .case_m = -travel_m / 2,
                   .case_m_per_s = -speed_m_per_s / 2};
  scene.effects.stiffening = sim::StiffeningSpring{.cubic_n_per_m3 = cubic_n_per_m3};
  return scene;
}

TEST(HardCasesSim, PeakOfAShortContact) {
  sim::Scene scene = FreeBodies(0, 0, 0.3);
  constexpr double kStop = 1e8, kGap = 1e-4;
  scene.effects.travel_stops =
      sim::TravelStops{.gap_up_m = kGap, .gap_down_m = kGap, .stiffness_n_per_m = kStop};
  const sim::SceneRun run =
      sim::RunScene(sim::WithEffects(scene, With({sim::Effect::kTravelStops})), 5e-3);
  // m v^2 = Kv d^2 + k (d - g)^2, m the reduced mass: the larger root of a quadratic
  const long double k = 1e8L, g = static_cast<long double>(kGap);
  const long double energy = 5e-4L * 0.3L * 0.3L;
  const long double a = 1000 + k, b = k * g, c = k * g * g - energy;
  const long double peak = (b + std::sqrt(b * b - a * c)) / a;
  // the mover's travel at the outputs is twice the case's, which touches the skin
  const double naive = 2 * run.skin_m.cwiseAbs().maxCoeff();
  Check({"sim", "travel into a stop of 1e8 N/m", "the contact of 7 us lies between two outputs",
         "the largest output", 1e-10},
        {peak, run.mover_peak_m, naive});
}

// cn(u, m) by descending Landen steps (Abramowitz and Stegun 16.4)
long double JacobiCn(long double u, long double m) {
  long double a[12], c[12];
  a[0] = 1;
  long double b = std::sqrt(1 - m);
  c[0] = std::sqrt(m);
  int n = 0;
  for (; n < 10 && c[n] > 1e-19L; ++n) {
    a[n + 1] = (a[n] + b) / 2;
    c[n + 1] = (a[n] - b) / 2;
    b = std::sqrt(a[n] * b);
  }
  long double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = (phi + std::asin(c[n] / a[n] * std::sin(phi))) / 2;
  return std::cos(phi);
}

TEST(HardCasesSim, UndampedStiffeningSpring) {
  constexpr double kTravel = 4e-4, kCubic = 1e10;
  sim::Scene scene = FreeBodies(kCubic, kTravel, 0);
  const sim::SceneRun run =
      sim::RunScene(sim::WithEffects(scene, With({sim::Effect::kStiffening})), 0.02);
  // d'' = -(Kv d + K3 d^3)/m: d = A cn(W t, k), W^2 = (Kv + K3 A^2)/m, k^2 = K3 A^2/(2 m W^2)
  const long double bent = 1e10L * 16e-8L;
  const long double w = std::sqrt((1000 + bent) / 5e-4L);
  const long double truth = -2e-4L * JacobiCn(w * 0.02L, bent / (2 * (1000 + bent)));
  const double naive = -kTravel / 2 * std::cos(std::sqrt(1000 / 5e-4) * 0.02);
  // the bar: a hundred times the scene's tolerance of 1e-10, which is the RMS's
  Check({"sim", "place after seven periods of a spring that stiffens by 1.6",
         "the period depends on the amplitude", "cosine of the linear spring", 1e-8},
        {truth, run.skin_m(run.skin_m.size() - 1), naive});
}

TEST(HardCasesSim, PeakOfTravelIntoACompliantStop) {
  sim::Scene scene = tests::AdapterScene();
  scene.start = sim::Start::kRest;
  scene.effects.travel_stops =
      sim::TravelStops{.gap_up_m = 4e-4, .gap_down_m = 4e-4, .stiffness_n_per_m = 1e7};
  const sim::SceneRun run =
      sim::RunScene(sim::WithEffects(scene, With({sim::Effect::kTravelStops})), 0.1);
  Check({"sim", "mover's peak between stops of 1e7 N/m, 0.1 s",
         "it is reached within a contact of 40 us", "the gap", 1e-10},
        {4.0529825442004553e-04L, run.mover_peak_m, 4e-4});
}

TEST(HardCasesSim, LeastContactForceBetweenImpacts) {
  sim::Scene scene = tests::ConeScene();
  scene.start = sim::Start::kRest;
  scene.effects.travel_stops = StopsAt(5e-5, 0.5);
  const sim::SceneRun run =
      sim::RunScene(sim::WithEffects(scene, With({sim::Effect::kTravelStops})), 0.05);
  // Ks xs + Bs vs with central differences of the outputs; the integrator's scene has 0.07 N more
  double naive = 0;
  for (Eigen::Index k = 1; k + 1 < run.skin_m.size(); ++k) {
    const double speed = (run.skin_m(k + 1) - run.skin_m(k - 1)) / 2 * run.outputs_rate_hz;
    naive = std::fmin(naive, 600 * run.skin_m(k) + 0.75 * speed);
  }
  Check({"sim", "least contact force between rigid stops at 50 um",
         "the speed jumps at each impact", "the least of the outputs", 1e-10},
        {-0.082598570029467638L, run.skin_force_least_n, naive});
}

TEST(HardCasesSim, MotionThatRepeatsEverySixthPeriod) {
  sim::Scene scene = tests::AdapterScene();
  scene.start = sim::Start::kRest;
  scene.effects.travel_stops =
      sim::TravelStops{.gap_up_m = 4e-4, .gap_down_m = 4e-4, .stiffness_n_per_m = 1e6};
  const sim::EffectiveScene stopped = sim::WithEffects(scene, With({sim::Effect::kTravelStops}));
  const sim::SteadyRun steady = sim::PlaySteady(stopped);
  ASSERT_TRUE(steady.run.has_value());
  // ten periods of a run from rest to 0.5 s
  const sim::SceneRun run = sim::RunScene(stopped, 0.5);
  Check({"sim", "skin RMS of a motion that repeats itself every sixth period",
         "ten periods of the drive are no whole ones of the motion", "the last ten periods", 1e-9},
        {7.536454150263104e-05L, steady.run->skin_rms_m, run.skin_rms_m});
}

TEST(HardCasesSim, StatementOfAChaoticRun) {
  sim::Scene scene = tests::DirectScene();
  scene.start = sim::Start::kRest;
  scene.effects.contact_loss = sim::ContactLoss{0.02077};
  const sim::EffectSet on = With({sim::Effect::kContactLoss});
  const sim::SceneRun run = sim::RunScene(sim::WithEffects(scene, on), 0.3);
  scene.drive.amplitude_v = std::nextafter(std::nextafter(5.0, 6.0), 6.0);
  const sim::SceneRun other = sim::RunScene(sim::WithEffects(scene, on), 0.3);
  const double apart = std::fabs(run.skin_rms_m / other.skin_rms_m - 1);
  // 1 where the stated error holds what two units in the last place of the voltage change
  Check({"sim", "a run that two ulp of the voltage change: 1 where its stated error holds that",
         "deviations double every few periods", "the energy balance, which closes", 0},
        {1, run.error_estimate >= apart ? 1.0 : 0.0,
         std::fabs(run.ledger.Imbalance()) >= apart ? 1.0 : 0.0});
}

TEST(HardCasesSim, StatementOfWhatAutoNeglects) {
  sim::Scene scene = tests::ConeScene();
  scene.start = sim::Start::kRest;
  scene.duration_s = 0.05;
  scene.tolerance = 0.1;
  scene.effects.stiffening = sim::StiffeningSpring{.cubic_n_per_m3 = 1e7};
  const sim::SceneRun bent =
      sim::RunScene(sim::WithEffects(scene, With({sim::Effect::kStiffening})), 0.05);
  scene.effects[sim::Effect::kStiffening] = sim::Wish::kAuto;
  const auto choice = sim::ChooseEffects(scene);
  ASSERT_TRUE(choice.has_value());
  const sim::SceneRun linear = sim::RunScene(sim::WithEffects(scene, With({})), 0.05);
  const double apart = std::fabs(choice->run.skin_rms_m / bent.skin_rms_m - 1);
  // 1 where the stated error holds the deviation
  Check({"sim", "a spring that auto neglects: 1 where the stated error holds its share",
         "the run that is answered is exact by itself", "the error of the linear run", 0},
        {1, choice->run.error_estimate >= apart ? 1.0 : 0.0,
         linear.error_estimate >= apart ? 1.0 : 0.0});
}

TEST(HardCasesSim, CurrentOfACoilOfOneMicrohenry) {
  sim::Scene scene = FreeBodies(0, 0, 0);
  scene.actuator.inductance_h = 1e-6;
  const sim::SineDrive drive{.amplitude_v = 5, .frequency_hz = 225};
  const sim::LinearModel model = sim::AssembleModel(scene);
  const sim::TimeResponse response(model, drive, sim::Start::kRest);
  // V (R sin(w t) - w L cos(w t) + w L e^(-R t/L)) / (R^2 + w^2 L^2); the last term is e^-10000
  const long double w = 2 * std::numbers::pi_v<long double> * 225, t = 1e-3L, l = 1e-6L;
  const long double truth =
      5 * (10 * std::sin(w * t) - w * l * std::cos(w * t)) / (100 + w * w * l * l);
  // L i' = v - R i by steps of 1 us
  double naive = 0;
  for (int k = 0; k < 1000; ++k) {
    const double volts = 5 * std::sin(2 * std::numbers::pi * 225 * k * 1e-6);
    naive += (volts - 10 * naive) / 1e-6 * 1e-6;
  }
  Check({"sim", "current through 10 ohm and 1 uH after 1 ms", "L/R = 0.1 us",
         "forward Euler, steps of 1 us", 1e-12},
        {truth, response.StateAt(1e-3)(4), naive});
}

TEST(HardCasesSim, PowerIntoAnAlmostReactiveCoil) {
  // R and L alone: V^2 R / (2 (R^2 + w^2 L^2)), w L = 1e6 R
  sim::Scene scene = FreeBodies(0, 0, 0);
  scene.actuator.resistance_ohm = 1e-3;
  scene.actuator.force_constant_n_per_a = 1e-12;
  scene.actuator.inductance_h = 1e3 / (2 * std::numbers::pi * 225);
  scene.drive.amplitude_v = 5;
  const sim::SteadyState steady = sim::SolveSteadyState(scene);
  const long double x = 2 * std::numbers::pi_v<long double> * 225 *
                        static_cast<long double>(scene.actuator.inductance_h);
  const double phase = std::arg(steady.current_a);
  Check({"sim", "power into a coil of w L = 1e6 R",
         "the current is all but a quarter of a period from the voltage",
         "V I cos(phase)/2 in double", 1e-12},
        {25e-3L / (2 * (1e-6L + x * x)), steady.power_w,
         5 * std::abs(steady.current_a) * std::cos(phase) / 2});
}

}  // namespace
}  // namespace haptometer::hard_cases
