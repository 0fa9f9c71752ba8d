// What the exact solution of the adapter scene costs, and what the same seconds buy with Runge and
// Kutta's method of order 4. Counters: error is the largest deviation of any sample from the exact
// answer over that state's largest value, for the skin's position and for the worst state (the coil
// current); steps is the number of time steps.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/sensor_model.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

constexpr double kRunS = 0.1;
constexpr double kRateHz = 1e4;
constexpr Eigen::Index kSamples = 1001;

// Lindsay 2013, Tables 2.1 and 2.4
Scene AdapterScene() {
  Scene scene;
  scene.actuator = ThesisC10100();
  scene.adapter = Adapter{.motor_side_mass_kg = 0.25e-3,
                          .skin_side_mass_kg = 4.35e-3,
                          .stiffness_n_per_m = 8200,
                          .damping_n_s_per_m = 0.01};
  scene.skin = {.stiffness_n_per_m = 600, .damping_n_s_per_m = 0.75};
  scene.drive = {.amplitude_v = 5, .frequency_hz = 225};
  scene.start = Start::kRest;
  return scene;
}

void Phasor(benchmark::State& state) {
  const Scene scene = AdapterScene();
  for (auto _ : state) benchmark::DoNotOptimize(SolveSteadyState(scene));
}
BENCHMARK(Phasor);

void Exponential(benchmark::State& state) {
  const Eigen::MatrixXd a = AssembleModel(AdapterScene()).a * 1e-4;
  for (auto _ : state) benchmark::DoNotOptimize(MatrixExponential(a));
}
BENCHMARK(Exponential);

void PrepareAnyTime(benchmark::State& state) {
  const Scene scene = AdapterScene();
  const LinearModel model = AssembleModel(scene);
  for (auto _ : state) {
    benchmark::DoNotOptimize(TimeResponse(model, scene.drive, Start::kRest));
  }
}
BENCHMARK(PrepareAnyTime);

void StateAtAnyTime(benchmark::State& state) {
  const Scene scene = AdapterScene();
  const TimeResponse response(AssembleModel(scene), scene.drive, Start::kRest);
  double t_s = 0;
  for (auto _ : state) {
    t_s += 1.2345e-4;
    benchmark::DoNotOptimize(response.StateAt(t_s));
  }
}
BENCHMARK(StateAtAnyTime);

void MotionInSteadyState(benchmark::State& state) {
  Scene scene = AdapterScene();
  scene.start = Start::kSteady;
  const trial::Displacement motion = MotionOf(scene, SensorTarget::kSkin);
  double t_s = 0;
  for (auto _ : state) {
    t_s += 1e-4;
    benchmark::DoNotOptimize(motion(t_s));
  }
}
BENCHMARK(MotionInSteadyState);

void WindowRms(benchmark::State& state) {
  const Scene scene = AdapterScene();
  const LinearModel model = AssembleModel(scene);
  const TimeResponse response(model, scene.drive, Start::kRest);
  for (auto _ : state) {
    benchmark::DoNotOptimize(response.WindowRms(model.skin(), kRunS - 10 / 225.0, kRunS));
  }
}
BENCHMARK(WindowRms);

// The reference of the ladder: every sample asked for on its own, without stepping.
Eigen::MatrixXd Reference() {
  const Scene scene = AdapterScene();
  const TimeResponse response(AssembleModel(scene), scene.drive, Start::kRest);
  Eigen::MatrixXd samples(7, kSamples);
  for (Eigen::Index i = 0; i < kSamples; ++i) {
    samples.col(i) = response.StateAt(static_cast<double>(i) / kRateHz);
  }
  return samples;
}

void CountErrors(benchmark::State& state, const Eigen::MatrixXd& samples) {
  const Eigen::MatrixXd reference = Reference();
  const Eigen::VectorXd largest = reference.cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd error =
      (samples - reference).cwiseAbs().rowwise().maxCoeff().cwiseQuotient(largest);
  state.counters["error_skin"] = error(4);
  state.counters["error_worst"] = error.maxCoeff();
}

// From the scene's numbers on: the model, one exponential, a product a sample. range(0): the
// inductance in uH; errors are counted where it is the thesis's.
void LadderExact(benchmark::State& state) {
  Scene scene = AdapterScene();
  scene.actuator.inductance_h = static_cast<double>(state.range(0)) * 1e-6;
  Eigen::MatrixXd samples;
  for (auto _ : state) {
    const LinearModel model = AssembleModel(scene);
    samples = UniformMotion(model, scene.drive, Eigen::VectorXd::Zero(model.states()), 0, kRateHz,
                            kSamples);
    benchmark::DoNotOptimize(samples.data());
  }
  if (state.range(0) == 130) CountErrors(state, samples);
  state.counters["steps"] = static_cast<double>(kSamples - 1);
}
BENCHMARK(LadderExact)->Arg(130)->Arg(50)->Arg(1)->Arg(0)->Unit(benchmark::kMicrosecond);

using State7 = Eigen::Matrix<double, 7, 1>;

// the classical fourth-order step of x' = A x + b V sin(w t)
class RungeKutta4 {
 public:
  RungeKutta4(const LinearModel& model, const SineDrive& drive)
      : a_(model.a),
        b_(drive.amplitude_v * model.b),
        omega_rad_per_s_(2 * std::numbers::pi * drive.frequency_hz) {}

  void Step(double t_s, double h_s, State7& x) const {
    const State7 k1 = Rate(t_s, x);
    const State7 k2 = Rate(t_s + h_s / 2, x + h_s / 2 * k1);
    const State7 k3 = Rate(t_s + h_s / 2, x + h_s / 2 * k2);
    const State7 k4 = Rate(t_s + h_s, x + h_s * k3);
    x += h_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

 private:
  State7 Rate(double t_s, const State7& x) const {
    return a_ * x + std::sin(omega_rad_per_s_ * t_s) * b_;
  }
  Eigen::Matrix<double, 7, 7> a_;
  State7 b_;
  double omega_rad_per_s_;
};

// range(0): steps between two samples; fewer than 8 lie beyond the method's stability
void LadderRungeKutta4(benchmark::State& state) {
  const Scene scene = AdapterScene();
  const RungeKutta4 method(AssembleModel(scene), scene.drive);
  const auto inner = static_cast<Eigen::Index>(state.range(0));
  const double h_s = 1 / (kRateHz * static_cast<double>(inner));
  Eigen::MatrixXd samples(7, kSamples);
  for (auto _ : state) {
    State7 x = State7::Zero();
    samples.col(0) = x;
    for (Eigen::Index i = 1; i < kSamples; ++i) {
      for (Eigen::Index k = 0; k < inner; ++k) {
        method.Step(static_cast<double>((i - 1) * inner + k) * h_s, h_s, x);
      }
      samples.col(i) = x;
    }
    benchmark::DoNotOptimize(samples.data());
  }
  CountErrors(state, samples);
  state.counters["steps"] = static_cast<double>((kSamples - 1) * inner);
}
BENCHMARK(LadderRungeKutta4)
    ->Arg(7)
    ->Arg(8)
    ->Arg(16)
    ->Arg(32)
    ->Arg(64)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace haptometer::sim
