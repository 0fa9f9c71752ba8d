#include "sim/uniform_motion.h"

#include "base/check.h"

namespace haptometer::sim {
namespace {

// Rows are filled up to a multiple of four with zeros, which keeps every product in whole vectors.
template <int kStates>
void Step(const Eigen::MatrixXd& step, DriveSequence& drive, std::uint64_t first,
          const Eigen::VectorXd& begin, Eigen::Ref<Eigen::MatrixXd>& samples) {
  constexpr int kRows = (kStates + 3) / 4 * 4;
  Eigen::Matrix<double, kRows, kStates + 2> padded =
      Eigen::Matrix<double, kRows, kStates + 2>::Zero();
  padded.template topRows<kStates>() = step;
  Eigen::Matrix<double, kRows, 1> x = Eigen::Matrix<double, kRows, 1>::Zero();
  x.template head<kStates>() = begin;
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    const Eigen::Vector2d now = drive.At(first + 1 + static_cast<std::uint64_t>(i));
    Eigen::Matrix<double, kRows, 1> next =
        padded.col(kStates) * now[0] + padded.col(kStates + 1) * now[1];
    for (int k = 0; k < kStates; ++k) next += padded.col(k) * x[k];
    x = next;
    samples.col(i) = x.template head<kStates>();
  }
}

}  // namespace

void StepUniformly(const Eigen::MatrixXd& step, DriveSequence& drive, std::uint64_t first,
                   const Eigen::VectorXd& x, Eigen::Ref<Eigen::MatrixXd> samples) {
  switch (x.size()) {
    case 4:
      return Step<4>(step, drive, first, x, samples);
    case 5:
      return Step<5>(step, drive, first, x, samples);
    case 6:
      return Step<6>(step, drive, first, x, samples);
    case 7:
      return Step<7>(step, drive, first, x, samples);
    default:
      HAPTOMETER_CHECK(false, "{} states", x.size());
  }
}

Eigen::MatrixXd UniformMotion(const LinearModel& model, const SineDrive& drive,
                              const Eigen::VectorXd& initial, double start_s, double rate_hz,
                              std::size_t count) {
  HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz);
  HAPTOMETER_CHECK(initial.size() == model.states(), "{} of {} states", initial.size(),
                   model.states());
  Eigen::MatrixXd samples(model.states(), static_cast<Eigen::Index>(count));
  if (count == 0) return samples;
  samples.col(0) = initial;
  const Eigen::MatrixXd step = DrivenStep(model, drive, 1 / rate_hz);
  DriveSequence sequence(drive.frequency_hz, start_s, rate_hz);
  StepUniformly(step, sequence, 0, initial, samples.rightCols(samples.cols() - 1));
  return samples;
}

}  // namespace haptometer::sim
