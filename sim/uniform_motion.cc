#include "sim/uniform_motion.h"

namespace haptometer::sim {

Eigen::MatrixXd UniformMotion(const LinearModel& model, const SineDrive& drive,
                              const Eigen::VectorXd& initial, double start_s, double rate_hz,
                              std::size_t count) {
  HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz);
  HAPTOMETER_CHECK(initial.size() == model.states(), "{} of {} states", initial.size(),
                   model.states());
  Eigen::MatrixXd samples(model.states(), static_cast<Eigen::Index>(count));
  if (count == 0) return samples;
  samples.col(0) = initial;
  Eigen::VectorXd x = initial;
  DriveSequence sequence(drive.frequency_hz, start_s, rate_hz);
  StepUniformly(DrivenStep(model, drive, 1 / rate_hz), sequence, 0, samples.cols() - 1, x,
                [&](Eigen::Index i, const auto& state, const Eigen::Vector2d&) {
                  samples.col(i + 1) = state;
                });
  return samples;
}

}  // namespace haptometer::sim
