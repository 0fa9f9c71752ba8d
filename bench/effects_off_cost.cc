// What the effects cost that a scene does not call for, counted by tests/long/effects_off.py:
//
//   effects_off_cost bare OUTPUTS    the adapter scene by a plain loop over its step's matrix
//   effects_off_cost scene OUTPUTS   the same outputs by the engine, every effect there and off
//   effects_off_cost single OUTPUTS  the same, asked for one by one
//   effects_off_cost none OUTPUTS    nothing: what the program itself takes
//
// from rest, at 10 kHz, all seven states in blocks of 4096. Prints the last state, which is the
// same to the last bit for the first 16384 outputs; later the engine has the better digits.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "sim/driven_step.h"
#include "sim/effective_scene.h"
#include "sim/linear_model.h"
#include "sim/piecewise_motion.h"
#include "sim/piecewise_scene.h"
#include "tests/sim/thesis_scenes.h"

namespace haptometer::sim {
namespace {

constexpr double kRateHz = 1e4;
constexpr Eigen::Index kBlock = 4096;

Scene FromRest() {
  Scene scene = tests::AdapterScene();
  scene.start = Start::kRest;
  return scene;
}

Eigen::VectorXd Bare(Eigen::Index outputs) {
  const Scene scene = FromRest();
  const LinearModel model = AssembleModel(scene);
  const Eigen::MatrixXd whole = DrivenStep(model, scene.drive, 1 / kRateHz);
  DriveSequence drive(scene.drive.frequency_hz, 0, kRateHz);
  // a row of zeros makes columns of whole vectors
  Eigen::Matrix<double, 8, 9> step = Eigen::Matrix<double, 8, 9>::Zero();
  step.topRows<7>() = whole;
  Eigen::Matrix<double, 8, 1> x = Eigen::Matrix<double, 8, 1>::Zero();
  Eigen::MatrixXd samples(7, kBlock);
  for (Eigen::Index begin = 0; begin < outputs; begin += kBlock) {
    const Eigen::Index count = std::min(kBlock, outputs - begin);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Vector2d now = drive.At(static_cast<std::uint64_t>(begin + i + 1));
      Eigen::Matrix<double, 8, 1> next = step.col(7) * now[0] + step.col(8) * now[1];
      for (int k = 0; k < 7; ++k) next += step.col(k) * x[k];
      x = next;
      samples.col(i) = x.head<7>();
    }
  }
  return x.head<7>();
}

PiecewiseMotion SceneMotion() {
  // the inductance is the actuator's and stays
  EffectSet on{};
  on[PlaceOf(Effect::kInductance)] = true;
  const EffectiveScene scene = WithEffects(FromRest(), on);
  return {AssemblePiecewise(scene.scene, scene.piecewise), scene.scene.drive,
          PiecewiseStartOf(scene.scene), kRateHz};
}

Eigen::VectorXd InBlocks(Eigen::Index outputs) {
  PiecewiseMotion motion = SceneMotion();
  for (Eigen::Index begin = 0; begin < outputs; begin += kBlock) {
    const auto count = static_cast<std::size_t>(std::min(kBlock, outputs - begin));
    const Eigen::MatrixXd samples = motion.Advance(count);
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

std::optional<Eigen::VectorXd> LastState(std::string_view way, Eigen::Index outputs) {
  if (way == "bare") return Bare(outputs);
  if (way == "scene") return InBlocks(outputs);
  if (way == "single") return OneByOne(outputs);
  if (way == "none") return Eigen::VectorXd::Zero(7);
  return std::nullopt;
}

}  // namespace
}  // namespace haptometer::sim

int main(int argc, char** argv) {
  const Eigen::Index outputs = argc > 2 ? std::atol(argv[2]) : 0;
  const auto x = outputs > 0 ? haptometer::sim::LastState(argv[1], outputs) : std::nullopt;
  if (!x) {
    fmt::print(stderr, "usage: effects_off_cost bare|scene|single|none OUTPUTS\n");
    return 2;
  }
  fmt::print("{:a}\n", fmt::join(x->begin(), x->end(), " "));
  return 0;
}
