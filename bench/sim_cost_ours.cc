#include "bench/sim_cost_ours.h"

#include <cmath>

#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/smooth/smooth_motion.h"
#include "tests/sim/thesis_scenes.h"
#include "tests/sim/uniform_motion.h"

namespace haptometer::sim {
namespace {

using State7 = Eigen::Matrix<double, 7, 1>;
using Step7 = Eigen::Matrix<double, 7, 7>;

}  // namespace

Scene SceneOf(const Question& question) {
  Scene scene = tests::AdapterScene();
  scene.actuator.inductance_h = question.bodies.L;
  scene.start = Start::kRest;
  return scene;
}

PiecewiseEffects PiecewiseOf(const Question& question) {
  PiecewiseEffects effects;
  if (question.gap_m > 0) {
    effects.stops = TravelStops{.gap_up_m = question.gap_m,
                                .gap_down_m = question.gap_m,
                                .restitution = question.restitution};
  }
  if (question.preload_n > 0) effects.contact_loss = ContactLoss{question.preload_n};
  return effects;
}

SmoothEffects SmoothOf(const Question& question) {
  SmoothEffects effects;
  if (question.cubic_n_per_m3 > 0) {
    effects.spring =
        StiffeningSpring{.cubic_n_per_m3 = question.cubic_n_per_m3, .sag_m = question.sag_m};
  }
  if (question.heat_capacity_j_per_k > 0) {
    effects.heating =
        CoilHeating{.heat_capacity_j_per_k = question.heat_capacity_j_per_k,
                    .thermal_resistance_k_per_w = question.thermal_resistance_k_per_w};
  }
  return effects;
}

Answer ByExactSteps(const Question& question, std::size_t outputs) {
  const Scene scene = SceneOf(question);
  const LinearModel model = AssembleModel(scene);
  return {.samples = UniformMotion(model, scene.drive, Eigen::VectorXd::Zero(model.states()), 0,
                                   question.rate_hz, outputs + 1),
          .steps = static_cast<std::int64_t>(outputs)};
}

Answer ByQuestions(const Question& question, std::size_t outputs) {
  const Scene scene = SceneOf(question);
  const TimeResponse response(AssembleModel(scene), scene.drive, Start::kRest);
  Answer answer = EmptyAnswer(question, outputs);
  for (std::size_t i = 1; i <= outputs; ++i) {
    answer.samples.col(static_cast<Eigen::Index>(i)) = response.StateAt(question.TimeOf(i));
  }
  return answer;
}

Answer ByHolding(const Question& question, std::size_t outputs, Hold hold, int inner) {
  const LinearModel model = AssembleModel(SceneOf(question));
  const double h_s = 1 / (question.rate_hz * inner);
  // [x, u, h u'] with u' constant: x after = E x + B0 u + B1 (u after - u)
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(9, 9);
  generator.topLeftCorner(7, 7) = model.a * h_s;
  generator.block(0, 7, 7, 1) = model.b * h_s;
  generator(7, 8) = 1;
  const Eigen::MatrixXd exponential = MatrixExponential(generator);
  const Step7 step = exponential.topLeftCorner(7, 7);
  const State7 of_value = exponential.block(0, 7, 7, 1);
  State7 of_change = State7::Zero();
  if (hold == Hold::kFirstOrder) of_change = exponential.block(0, 8, 7, 1);

  Answer answer = EmptyAnswer(question, outputs);
  State7 x = State7::Zero();
  const double omega_rad_per_s = AngularFrequency(question);
  double volt = 0;
  for (std::size_t i = 1; i <= outputs; ++i) {
    for (int k = 0; k < inner; ++k) {
      ++answer.steps;
      const double after = question.bodies.volt *
                           std::sin(omega_rad_per_s * static_cast<double>(answer.steps) * h_s);
      x = (step * x + volt * of_value + (after - volt) * of_change).eval();
      volt = after;
    }
    answer.samples.col(static_cast<Eigen::Index>(i)) = x;
  }
  return answer;
}

Answer ByPieces(const Question& question, std::size_t outputs) {
  const Scene scene = SceneOf(question);
  Answer answer = EmptyAnswer(question, outputs);
  PiecewiseMotion motion(AssemblePiecewise(scene, PiecewiseOf(question)), scene.drive,
                         PiecewiseStartOf(scene), question.rate_hz);
  for (std::size_t i = 1; i <= outputs; ++i) {
    motion.Next();
    answer.samples.col(static_cast<Eigen::Index>(i)) = motion.Positions();
  }
  for (const Event& event : motion.events()) answer.events_s.push_back(event.time_s);
  if (motion.stalled_at_s()) answer.failure = "stalled";
  return answer;
}

Answer BySmoothMotion(const Question& question, std::size_t outputs, double tolerance) {
  const Scene scene = SceneOf(question);
  Answer answer = EmptyAnswer(question, outputs);
  SmoothMotion motion(AssembleSmooth(scene, PiecewiseOf(question), SmoothOf(question)), scene.drive,
                      PiecewiseStartOf(scene), question.rate_hz, {.tolerance = tolerance});
  for (std::size_t i = 1; i <= outputs; ++i) {
    motion.Next();
    const auto output = static_cast<Eigen::Index>(i);
    answer.samples.col(output).head(7) = motion.Positions();
    if (answer.samples.rows() > 7) answer.samples(7, output) = motion.temperature_rise_k();
  }
  for (const Event& event : motion.events()) answer.events_s.push_back(event.time_s);
  if (motion.stalled_at_s()) answer.failure = "stalled";
  answer.steps = motion.work().steps;
  answer.evaluations = motion.work().evaluations;
  return answer;
}

}  // namespace haptometer::sim
