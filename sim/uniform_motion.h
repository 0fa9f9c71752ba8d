#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "base/error.h"
#include "sim/driven_step.h"
#include "sim/linear_model.h"
#include "sim/scene.h"

namespace haptometer::sim {

/// The states at start_s + i / rate_hz, i = 0 .. count - 1, one column each: (n, count).
///
/// Exact at any rate: the exponential of one step (driven_step.h), then a product a sample; the
/// drive's phase is that of the sample's number, so it does not drift. Of 1000 samples of the
/// thesis's adapter scene every state is within 2e-13 of its peak.
///
/// @param initial (n) the states at start_s
/// Cost: one exponential and some 15 ns a sample of seven states; no allocation but the result's
/// and the exponential's.
[[nodiscard]] Eigen::MatrixXd UniformMotion(const LinearModel& model, const SineDrive& drive,
                                            const Eigen::VectorXd& initial, double start_s,
                                            double rate_hz, std::size_t count);

/// StepUniformly of so many states. Rows are filled up to a multiple of four with zeros, which
/// keeps every product in whole vectors.
template <int kStates, typename Take>
void StepStates(const Eigen::MatrixXd& step, DriveSequence& drive, std::uint64_t first,
                Eigen::Index count, Eigen::VectorXd& state, const Take& take) {
  constexpr int kRows = (kStates + 3) / 4 * 4;
  Eigen::Matrix<double, kRows, kStates + 2> padded =
      Eigen::Matrix<double, kRows, kStates + 2>::Zero();
  padded.template topRows<kStates>() = step;
  Eigen::Matrix<double, kRows, 1> x = Eigen::Matrix<double, kRows, 1>::Zero();
  x.template head<kStates>() = state;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d now = drive.At(first + 1 + static_cast<std::uint64_t>(i));
    Eigen::Matrix<double, kRows, 1> next =
        padded.col(kStates) * now[0] + padded.col(kStates + 1) * now[1];
    for (int k = 0; k < kStates; ++k) next += padded.col(k) * x[k];
    x = next;
    take(i, x.template head<kStates>(), now);
  }
  state = x.template head<kStates>();
}

/// What UniformMotion steps with: goes on from `x`, the state at sample `first`, by `count` samples
/// and calls take(i, state, [sin w t, cos w t]) for i = 0 .. count - 1, the samples behind `first`.
/// (n, n + 2) `step` of 4 <= n <= 7 states.
template <typename Take>
void StepUniformly(const Eigen::MatrixXd& step, DriveSequence& drive, std::uint64_t first,
                   Eigen::Index count, Eigen::VectorXd& x, const Take& take) {
  switch (x.size()) {
    case 4:
      return StepStates<4>(step, drive, first, count, x, take);
    case 5:
      return StepStates<5>(step, drive, first, count, x, take);
    case 6:
      return StepStates<6>(step, drive, first, count, x, take);
    case 7:
      return StepStates<7>(step, drive, first, count, x, take);
    default:
      HAPTOMETER_CHECK(false, "{} states", x.size());
  }
}

}  // namespace haptometer::sim
