#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "sim/linear/driven_step.h"
#include "sim/linear/excitation.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/mode.h"
#include "sim/linear/time_response.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

// DrivenStep of a model under a sine
inline Eigen::MatrixXd ModelStep(const LinearModel& model, const SineDrive& drive, double h_s) {
  const Mode mode{.name = {},
                  .a = model.a,
                  .b = model.b,
                  .positions = {},
                  .stored_j = {},
                  .current_row = {},
                  .a_rest = model.a_rest,
                  .b_rest = model.b_rest};
  const ExcitationShape shape = ShapeOf(Excitation(drive).Piece(0));
  if (mode.a_rest.size() == 0) {
    return DrivenStep(DrivenGenerator(mode.a, mode.Inputs(), shape), h_s, 2);
  }
  const auto length_s = static_cast<long double>(h_s);
  return LongDrivenStep(LongDrivenGenerator(mode, shape), length_s, 2).cast<double>();
}

// the states at start_s + i / rate_hz, i = 0 .. count - 1, one column each; `initial` is the first
inline Eigen::MatrixXd UniformMotion(const LinearModel& model, const SineDrive& drive,
                                     const Eigen::VectorXd& initial, double start_s, double rate_hz,
                                     std::size_t count) {
  Eigen::MatrixXd samples(model.states(), static_cast<Eigen::Index>(count));
  if (count == 0) return samples;
  samples.col(0) = initial;
  Eigen::VectorXd x = initial;
  DriveSequence sequence(drive.frequency_hz, start_s, rate_hz);
  StepUniformly(ModelStep(model, drive, 1 / rate_hz), sequence, 0, samples.cols() - 1, x,
                [&](Eigen::Index i, const auto& state, const Eigen::Vector2d&) {
                  samples.col(i + 1) = state;
                });
  return samples;
}

}  // namespace haptometer::sim
