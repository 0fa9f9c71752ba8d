#include "sim/superposition.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>

#include "sim/linear_model.h"
#include "sim/scene_mode.h"
#include "sim/steady_state.h"

namespace haptometer::sim {

namespace {

using Complex = std::complex<double>;

// all that moves at one frequency
struct Part {
  Eigen::VectorXcd states;
  Complex current_a;
  Complex finger_m;
};

double OmegaOf(double frequency_hz) { return 2 * std::numbers::pi * frequency_hz; }

// What the finger's tone does: its position and its rate each push the skin through `finger`.
Eigen::VectorXcd StatesUnder(const Tone& tone, Complex finger_m, const LinearModel& model,
                             const Eigen::MatrixXd& finger, double& error) {
  Eigen::VectorXcd states = Eigen::VectorXcd::Zero(model.states());
  const Complex rate = Complex(0, OmegaOf(tone.frequency_hz)) * finger_m;
  for (const Eigen::Index input : {0, 1}) {
    if (finger.col(input).isZero(0)) continue;
    LinearModel pushed = model;
    pushed.b = finger.col(input);
    const SteadyState unit =
        SolveSteadyState(pushed, {.amplitude_v = 1, .frequency_hz = tone.frequency_hz}, Skin{});
    error = std::max(error, unit.error_estimate);
    states += (input == 0 ? finger_m : rate) * unit.phasors;
  }
  return states;
}

void Add(const Scene& scene, const LinearModel& model, double frequency_hz, const Part& part,
         Superposition& sum) {
  const Eigen::VectorXcd& x = part.states;
  const Complex skin_m = x(model.skin());
  const Complex impedance(scene.skin.stiffness_n_per_m,
                          OmegaOf(frequency_hz) * scene.skin.damping_n_s_per_m);
  sum.skin_rms_m = std::hypot(sum.skin_rms_m, std::abs(skin_m) / std::numbers::sqrt2);
  sum.case_rms_m =
      std::hypot(sum.case_rms_m, std::abs(x(LinearModel::kCase)) / std::numbers::sqrt2);
  sum.current_rms_a = std::hypot(sum.current_rms_a, std::abs(part.current_a) / std::numbers::sqrt2);
  sum.mover_peak_m += std::abs(x(LinearModel::kMover) - x(LinearModel::kCase));
  const Complex force_n = impedance * (skin_m - part.finger_m);
  const Complex finger_m_per_s = Complex(0, OmegaOf(frequency_hz)) * part.finger_m;
  sum.skin_force_peak_n += std::abs(force_n);
  sum.power_w -= (std::conj(finger_m_per_s) * force_n).real() / 2;
  sum.state += x.imag();
}

// what the drive's offset holds
void AddMean(const Scene& scene, const LinearModel& model, const SteadyState& driven,
             Superposition& sum) {
  if (!IsHeldInPlace(scene)) sum.error_estimate = HUGE_VAL;
  sum.skin_rms_m = std::hypot(sum.skin_rms_m, driven.mean(model.skin()));
  sum.case_rms_m = std::hypot(sum.case_rms_m, driven.mean(LinearModel::kCase));
  sum.current_rms_a = std::hypot(sum.current_rms_a, driven.mean_current_a);
  sum.mean_travel_m = driven.mean_travel_m;
  sum.mean_skin_force_n = driven.mean_skin_force_n;
  sum.mover_peak_m += std::abs(driven.mean_travel_m);
  sum.skin_force_peak_n += std::abs(driven.mean_skin_force_n);
  sum.power_w += scene.drive.offset_v * driven.mean_current_a;
  sum.state += driven.mean;
}

}  // namespace

Superposition Superpose(const Scene& scene) {
  const LinearModel model = AssembleModel(scene);
  const SineDrive drive = scene.drive;
  const SteadyState driven = SolveSteadyState(model, drive, scene.skin);
  Superposition sum{.state = Eigen::VectorXd::Zero(model.states()),
                    .error_estimate = driven.error_estimate};
  std::map<double, Part> parts;
  parts[drive.frequency_hz] = {driven.phasors, driven.current_a, 0};
  const Mode mode = SceneMode(scene);
  for (const Tone& tone : scene.finger.tones) {
    const Complex finger_m = std::polar(tone.amplitude, tone.phase_rad);
    const Eigen::VectorXcd states =
        StatesUnder(tone, finger_m, model, mode.finger, sum.error_estimate);
    Part& part = parts[tone.frequency_hz];
    if (part.states.size() == 0) part.states = Eigen::VectorXcd::Zero(model.states());
    part.states += states;
    part.current_a += (model.current_row.cast<Complex>() * states).value();
    part.finger_m += finger_m;
  }
  sum.power_w = drive.amplitude_v * parts[drive.frequency_hz].current_a.real() / 2;
  for (const auto& [frequency_hz, part] : parts) Add(scene, model, frequency_hz, part, sum);
  if (drive.offset_v != 0) AddMean(scene, model, driven, sum);
  return sum;
}

}  // namespace haptometer::sim
