// Linear scenes: runs against equations of motion integrated by Boost.Numeric.Odeint in long
// double, steady states against impedances solved in long double.
#include <algorithm>
#include <array>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "sim/linear/steady_state.h"
#include "sim/scene/scene.h"
#include "sim/scene_run.h"
#include "tests/search/draws.h"

namespace haptometer::search {
namespace {

using Complex = std::complex<Real>;

// everything within some decades of the mover's own frequency, so that an explicit method gets
// through
sim::Scene DrawScene() {
  sim::Scene scene;
  sim::Actuator& motor = scene.actuator;
  const double own = 2 * std::numbers::pi * Decades("own_hz", 10, 2000);
  const double mover = Decades("mover_kg", 1e-4, 0.1);
  motor.moving_mass_kg = mover;
  motor.case_mass_kg = mover * Decades("case_over_mover", 0.1, 10);
  motor.stiffness_n_per_m = mover * own * own;
  motor.damping_n_s_per_m = 2 * mover * own * Decades("damping_ratio", 1e-3, 1);
  motor.resistance_ohm = Decades("resistance_ohm", 0.1, 1000);
  motor.force_constant_n_per_a =
      std::sqrt(2 * mover * own * motor.resistance_ohm * Decades("coil_damping_ratio", 1e-4, 1));
  if (Flag("has_source")) scene.drive.source_resistance_ohm = Decades("source_ohm", 0.1, 100);
  if (Flag("has_inductance")) {
    const double ohms = motor.resistance_ohm + scene.drive.source_resistance_ohm;
    motor.inductance_h = ohms / own * Decades("inductive", 0.01, 10);
  }
  if (Flag("has_adapter")) {
    sim::Adapter& adapter = scene.adapter.emplace();
    adapter.motor_side_mass_kg = motor.case_mass_kg * Decades("motor_side_over_case", 0.01, 1);
    adapter.skin_side_mass_kg = motor.case_mass_kg * Decades("skin_side_over_case", 0.05, 5);
    adapter.stiffness_n_per_m = motor.stiffness_n_per_m * Decades("adapter_over_spring", 0.1, 100);
    adapter.damping_n_s_per_m = 2 * Decades("adapter_damping_ratio", 1e-3, 1) *
                                std::sqrt(adapter.stiffness_n_per_m * adapter.skin_side_mass_kg);
  }
  scene.skin.stiffness_n_per_m = motor.stiffness_n_per_m * Decades("skin_over_spring", 0.01, 100);
  scene.skin.damping_n_s_per_m = 2 * Decades("skin_damping_ratio", 1e-3, 1) *
                                 std::sqrt(scene.skin.stiffness_n_per_m * motor.case_mass_kg);
  if (Flag("has_grip")) {
    scene.grip.stiffness_n_per_m = motor.stiffness_n_per_m * Decades("grip_over_spring", 0.01, 10);
    scene.grip.damping_n_s_per_m = motor.damping_n_s_per_m * Decades("grip_over_damper", 0.01, 10);
  }
  scene.drive.amplitude_v = Decades("amplitude_v", 1e-3, 10);
  scene.drive.frequency_hz = own / (2 * std::numbers::pi) * Decades("drive_over_own", 0.2, 5);
  return scene;
}

// the scene's numbers as long doubles; what is absent is 0
struct Bodies {
  bool has_adapter = false;
  Real mover_kg, case_kg, skin_kg;
  Real kv, bv, ka = 0, ba = 0, ks, bs, kg, bg;
  Real km, ohms, henry;
  Real volts, offset_v, omega;
};

Bodies BodiesOf(const sim::Scene& scene) {
  const sim::Actuator& motor = scene.actuator;
  const sim::Adapter adapter = scene.adapter.value_or(sim::Adapter{});
  return {.has_adapter = scene.adapter.has_value(),
          .mover_kg = Long(motor.moving_mass_kg),
          .case_kg = Long(motor.case_mass_kg) + Long(adapter.motor_side_mass_kg),
          .skin_kg = Long(adapter.skin_side_mass_kg),
          .kv = Long(motor.stiffness_n_per_m),
          .bv = Long(motor.damping_n_s_per_m),
          .ka = Long(adapter.stiffness_n_per_m),
          .ba = Long(adapter.damping_n_s_per_m),
          .ks = Long(scene.skin.stiffness_n_per_m),
          .bs = Long(scene.skin.damping_n_s_per_m),
          .kg = Long(scene.grip.stiffness_n_per_m),
          .bg = Long(scene.grip.damping_n_s_per_m),
          .km = Long(motor.force_constant_n_per_a),
          .ohms = Long(motor.resistance_ohm) + Long(scene.drive.source_resistance_ohm),
          .henry = Long(motor.inductance_h),
          .volts = Long(scene.drive.amplitude_v),
          .offset_v = Long(scene.drive.offset_v),
          .omega = 2 * std::numbers::pi_v<Real> * Long(scene.drive.frequency_hz)};
}

// positions, velocities, current, and the integrals of xs^2, xa^2, i^2 and v i
enum State : std::size_t { kXv, kVv, kXa, kVa, kXs, kVs, kI, kSkin, kCase, kCurrent, kPower };
using States = std::array<Real, 11>;

// the rates of change at t, as odeint asks for them
void Move(const Bodies& b, const States& x, States& rate, Real t) {
  const Real voltage = b.offset_v + b.volts * std::sin(b.omega * t);
  const Real driving = voltage + b.km * (x[kVv] - x[kVa]);
  const Real current = b.henry > 0 ? x[kI] : driving / b.ohms;
  const Real motor = b.kv * (x[kXv] - x[kXa]) + b.bv * (x[kVv] - x[kVa]) + b.km * current;
  const Real grip = b.kg * x[kXa] + b.bg * x[kVa];
  const Real skin = b.ks * x[kXs] + b.bs * x[kVs];
  const Real between = b.has_adapter ? b.ka * (x[kXa] - x[kXs]) + b.ba * (x[kVa] - x[kVs]) : skin;
  rate[kXv] = x[kVv];
  rate[kVv] = -motor / b.mover_kg;
  rate[kXa] = x[kVa];
  rate[kVa] = (motor - grip - between) / b.case_kg;
  rate[kXs] = x[kVs];
  rate[kVs] = b.has_adapter ? (between - skin) / b.skin_kg : rate[kVa];
  rate[kI] = b.henry > 0 ? (driving - b.ohms * current) / b.henry : 0;
  rate[kSkin] = x[kXs] * x[kXs];
  rate[kCase] = x[kXa] * x[kXa];
  rate[kCurrent] = current * current;
  rate[kPower] = voltage * current;
}

void Integrate(const Bodies& bodies, Real from_s, Real to_s, States& x) {
  namespace odeint = boost::numeric::odeint;
  if (!(to_s > from_s)) return;
  // relative 1e-17; the absolute one only forbids 0 / 0 at rest
  auto stepper = odeint::make_controlled(Real{1e-30L}, Real{1e-17L},
                                         odeint::runge_kutta_fehlberg78<States, Real>());
  const auto move = [&](const States& at, States& rate, Real t) { Move(bodies, at, rate, t); };
  odeint::integrate_adaptive(stepper, move, x, from_s, to_s,
                             std::min(to_s - from_s, Real{1e-2L} / bodies.omega));
}

double Relative(double ours, Real truth) {
  return static_cast<double>(std::abs(Long(ours) / truth - 1));
}

// The waveform at every eighth output; what the window adds to the integrals. Outputs count back
// from the run's end; the first of a whole run is at its begin, which may be less than a step
// before the second.
States CheckWindow(const Bodies& bodies, const sim::SceneRun& run, double bar) {
  States x{};
  Real time_s = Long(run.begin_s);
  Integrate(bodies, 0, time_s, x);
  std::fill(x.begin() + kSkin, x.end(), Real{0});
  Real worst = 0;
  Real peak = 0;
  for (Eigen::Index k = 0; k < run.skin_m.size(); k += 8) {
    const auto left = static_cast<Real>(run.skin_m.size() - 1 - k);
    const Real next_s =
        std::max(Long(run.begin_s), Long(run.end_s) - left / Long(run.outputs_rate_hz));
    Integrate(bodies, time_s, next_s, x);
    time_s = next_s;
    worst = std::max(worst, std::abs(x[kXs] - Long(run.skin_m[k])));
    peak = std::max(peak, std::abs(x[kXs]));
  }
  Integrate(bodies, time_s, Long(run.end_s), x);
  Hold("waveform", static_cast<double>(worst / peak), bar);
  return x;
}

void CheckRun(sim::Scene scene) {
  if (Flag("has_offset")) {
    scene.drive.offset_v = scene.drive.amplitude_v * Decades("offset", 0.01, 10);
  }
  const double periods = Even("periods", 0.3, 25);
  scene.duration_s = periods / scene.drive.frequency_hz;
  sim::EffectSet on;
  on.set(sim::PlaceOf(sim::Effect::kInductance));
  const sim::SceneRun run = sim::RunScene(sim::WithEffects(scene, on), *scene.duration_s);
  Require("a linear scene's numbers are finite", run.IsFinite());
  // above the tolerance where a number is small beside what it is made of, as a power near 0
  Hold("the stated error", run.error_estimate, sim::kLargestPredictedError);
  // the window is the last ten periods, or all of it; the bar: rounding of the times
  Hold("window's begin, in periods",
       run.begin_s * scene.drive.frequency_hz - std::max(0.0, periods - 10), 1e-12);
  // the bar: what is stated, and the reference's 1e-17 in each of up to 1e4 steps
  const double bar = run.error_estimate + 1e-13;
  const States end = CheckWindow(BodiesOf(scene), run, bar);
  const Real window_s = Long(run.end_s) - Long(run.begin_s);
  const Real current_a = std::sqrt(end[kCurrent] / window_s);
  Hold("skin RMS", Relative(run.skin_rms_m, std::sqrt(end[kSkin] / window_s)), bar);
  Hold("case RMS", Relative(run.case_rms_m, std::sqrt(end[kCase] / window_s)), bar);
  Hold("current RMS", Relative(run.current_rms_a, current_a), bar);
  // a mean that may be 0: over volts times amperes
  const Real watts = Long(std::abs(scene.drive.offset_v) + scene.drive.amplitude_v) * current_a;
  Hold("power", static_cast<double>((Long(run.power_w) - end[kPower] / window_s) / watts), bar);
}

// forces on mover, case and skin side, and the circuit's voltage, by [Xv, Xa, Xs, I]; under 1 V
using Impedances = std::array<std::array<Complex, 5>, 4>;

Impedances ImpedancesOf(const Bodies& b) {
  const Complex jw(0, b.omega);
  const Complex own = b.kv + jw * b.bv;
  const Complex between = b.ka + jw * b.ba;
  const Complex skin = b.ks + jw * b.bs;
  const Complex held = b.kg + jw * b.bg + (b.has_adapter ? between : skin);
  Impedances m{};
  m[0] = {jw * jw * b.mover_kg + own, -own, 0, b.km, 0};
  m[1] = {-own, jw * jw * b.case_kg + own + held, -between, -b.km, 0};
  m[2] = {0, -between, jw * jw * b.skin_kg + between + skin, 0, 0};
  if (!b.has_adapter) m[2] = {0, -1, 1, 0, 0};
  m[3] = {-jw * b.km, jw * b.km, 0, b.ohms + jw * b.henry, 1};
  return m;
}

// by Gauss and Jordan with the largest pivot of each column
std::array<Complex, 4> Solved(Impedances m) {
  for (std::size_t k = 0; k < 4; ++k) {
    std::size_t best = k;
    for (std::size_t i = k; i < 4; ++i) {
      if (std::abs(m[i][k]) > std::abs(m[best][k])) best = i;
    }
    std::swap(m[k], m[best]);
    for (std::size_t i = 0; i < 4; ++i) {
      if (i == k) continue;
      const Complex factor = m[i][k] / m[k][k];
      for (std::size_t c = k; c < 5; ++c) m[i][c] -= factor * m[k][c];
    }
  }
  std::array<Complex, 4> x;
  for (std::size_t k = 0; k < 4; ++k) x[k] = m[k][4] / m[k][k];
  return x;
}

void CheckSteady(const sim::Scene& scene) {
  const sim::SteadyState steady = sim::SolveSteadyState(scene);
  const Bodies bodies = BodiesOf(scene);
  const auto [xv, xa, xs, current] = Solved(ImpedancesOf(bodies));
  const Real rms_v = bodies.volts / std::numbers::sqrt2_v<Real>;
  Hold("the stated error of a damped scene", steady.error_estimate, scene.tolerance);
  // the bar: what is stated, and the reference's rounding, 5e-20 by conditions of up to 1e4
  const double bar = steady.error_estimate + 1e-15;
  Hold("skin RMS", Relative(steady.skin_rms_m, std::abs(xs) * rms_v), bar);
  Hold("case RMS", Relative(steady.case_rms_m, std::abs(xa) * rms_v), bar);
  Hold("current RMS", Relative(steady.current_rms_a, std::abs(current) * rms_v), bar);
  Hold("mover's peak", Relative(steady.mover_peak_m, std::abs(xv - xa) * bodies.volts), bar);
  Hold("power", Relative(steady.power_w, current.real() * rms_v * rms_v), bar);
}

}  // namespace

bool SceneCase() {
  const bool is_steady = Flag("is_steady");
  const sim::Scene scene = DrawScene();
  if (is_steady) {
    CheckSteady(scene);
  } else {
    CheckRun(scene);
  }
  return true;
}

}  // namespace haptometer::search
