// What the effects cost that a scene does not call for, counted by tests/long/effects_off.py:
//
//   effects_off_cost bare OUTPUTS        the adapter scene by a plain loop over its matrix
//   effects_off_cost scene OUTPUTS       the same by the engine, every effect there and off
//   effects_off_cost single OUTPUTS      the same, asked for one by one
//   effects_off_cost bare-waves OUTPUTS  the plain loop, keeping all waveforms
//   effects_off_cost waves OUTPUTS       the same by what `simulate --waveforms` calls
//   effects_off_cost none OUTPUTS        nothing: what the program itself takes
//
// from rest, at 10 kHz, all seven states in blocks of 4096. Prints the last state or the last row
// of waveforms, which are the same to the last bit for the first 16384 outputs; later the engine
// has the better digits.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "sim/effective_scene.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/waveforms.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

constexpr double kRateHz = 1e4;
constexpr Eigen::Index kBlock = 4096;

Scene FromRest() {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  return scene;
}

// Calls take(i, x, [sin, cos]) for outputs 1, 2, ...
template <typename Take>
void StepBarely(const Scene& scene, Eigen::Index outputs, const Take& take) {
  const Eigen::MatrixXd whole = ModelStep(AssembleModel(scene), scene.drive, 1 / kRateHz);
  DriveSequence drive(scene.drive.frequency_hz, 0, kRateHz);
  // a row of zeros makes columns of whole vectors
  Eigen::Matrix<double, 8, 9> step = Eigen::Matrix<double, 8, 9>::Zero();
  step.topRows<7>() = whole;
  Eigen::Matrix<double, 8, 1> x = Eigen::Matrix<double, 8, 1>::Zero();
  for (Eigen::Index i = 1; i <= outputs; ++i) {
    const Eigen::Vector2d now = drive.At(static_cast<std::uint64_t>(i));
    Eigen::Matrix<double, 8, 1> next = step.col(7) * now[0] + step.col(8) * now[1];
    for (int k = 0; k < 7; ++k) next += step.col(k) * x[k];
    x = next;
    take(i, x, now);
  }
}

Eigen::VectorXd Bare(Eigen::Index outputs) {
  Eigen::MatrixXd samples(7, kBlock);
  StepBarely(FromRest(), outputs, [&](Eigen::Index i, const auto& x, const Eigen::Vector2d&) {
    samples.col(i % kBlock) = x.template head<7>();
  });
  return samples.col(outputs % kBlock);
}

// voltage, current, six of motion and the force on the skin, of every output
Eigen::VectorXd BareWaves(Eigen::Index outputs) {
  const Scene scene = FromRest();
  const LinearModel model = AssembleModel(scene);
  const Eigen::Index skin = model.skin(), speed = model.skin_velocity(),
                     current = model.states() - 1;
  std::array<Eigen::VectorXd, 9> waves;
  for (Eigen::VectorXd& wave : waves) wave.setZero(outputs + 1);
  StepBarely(scene, outputs, [&](Eigen::Index i, const auto& x, const Eigen::Vector2d& drive) {
    waves[0](i) = scene.drive.amplitude_v * drive[0];
    waves[1](i) = x[current];
    waves[2](i) = x[LinearModel::kMover];
    waves[3](i) = x[LinearModel::kMoverVelocity];
    waves[4](i) = x[LinearModel::kCase];
    waves[5](i) = x[LinearModel::kCaseVelocity];
    waves[6](i) = x[skin];
    waves[7](i) = x[speed];
    waves[8](i) = scene.skin.stiffness_n_per_m * x[skin] + scene.skin.damping_n_s_per_m * x[speed];
  });
  Eigen::VectorXd last(waves.size());
  for (std::size_t k = 0; k < waves.size(); ++k) {
    last(static_cast<Eigen::Index>(k)) = waves[k](outputs);
  }
  return last;
}

EffectiveScene SceneWithEffectsOff() {
  // the inductance is the actuator's and stays
  EffectSet on{};
  on[PlaceOf(Effect::kInductance)] = true;
  return WithEffects(FromRest(), on);
}

PiecewiseMotion SceneMotion() {
  const EffectiveScene scene = SceneWithEffectsOff();
  return {AssemblePiecewise(scene.scene, scene.piecewise), scene.scene.drive,
          PiecewiseStartOf(scene.scene), kRateHz};
}

Eigen::VectorXd InBlocks(Eigen::Index outputs) {
  PiecewiseMotion motion = SceneMotion();
  Eigen::MatrixXd samples(7, kBlock);
  for (Eigen::Index done = 0; done < outputs;) {
    const Eigen::Index taken =
        motion.NextUnwatched(std::min(kBlock, outputs - done),
                             [&](Eigen::Index i, const auto& x, double) { samples.col(i) = x; });
    if (taken == 0) motion.Next();
    done = static_cast<Eigen::Index>(motion.index());
  }
  return motion.x();
}

Eigen::VectorXd OneByOne(Eigen::Index outputs) {
  PiecewiseMotion motion = SceneMotion();
  Eigen::MatrixXd samples(7, kBlock);
  for (Eigen::Index i = 0; i < outputs; ++i) {
    motion.Next();
    samples.col(i % kBlock) = motion.x();
  }
  return motion.x();
}

Eigen::VectorXd Waves(Eigen::Index outputs) {
  const EffectiveScene scene = SceneWithEffectsOff();
  const Waveforms waves =
      PlayWaveforms(scene, BeginningOf(scene), static_cast<double>(outputs) / kRateHz, kRateHz);
  Eigen::VectorXd last(9);
  last << waves.voltage_v(outputs), waves.current_a(outputs), waves.mover_m(outputs),
      waves.mover_m_per_s(outputs), waves.case_m(outputs), waves.case_m_per_s(outputs),
      waves.skin_m(outputs), waves.skin_m_per_s(outputs), waves.force_n(outputs);
  return last;
}

std::optional<Eigen::VectorXd> Last(std::string_view way, Eigen::Index outputs) {
  if (way == "bare") return Bare(outputs);
  if (way == "scene") return InBlocks(outputs);
  if (way == "single") return OneByOne(outputs);
  if (way == "bare-waves") return BareWaves(outputs);
  if (way == "waves") return Waves(outputs);
  if (way == "none") return Eigen::VectorXd::Zero(7);
  return std::nullopt;
}

}  // namespace
}  // namespace haptometer::sim

int main(int argc, char** argv) {
  const Eigen::Index outputs = argc > 2 ? std::atol(argv[2]) : 0;
  const auto x = outputs > 0 ? haptometer::sim::Last(argv[1], outputs) : std::nullopt;
  if (!x) {
    fmt::print(stderr, "usage: effects_off_cost bare|scene|single|bare-waves|waves|none OUTPUTS\n");
    return 2;
  }
  fmt::print("{:a}\n", fmt::join(x->begin(), x->end(), " "));
  return 0;
}
