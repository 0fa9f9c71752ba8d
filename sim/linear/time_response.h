#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/error.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/mode.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// A position with its first two derivatives by time.
struct MotionJet {
  double x = 0;
  double v = 0;
  double a = 0;
};

/// The quintic through two jets h apart: its six conditions are met, its error is
/// h^6 max|x''''''| / 46080, for 64 points in a period 2e-11 of the amplitude.
class HermiteQuintic {
 public:
  HermiteQuintic(const MotionJet& begin, const MotionJet& end, double h_s);
  /// At begin + u h, 0 <= u <= 1.
  [[nodiscard]] double At(double u) const;
  /// What it comes to where its rate has one zero at most.
  [[nodiscard]] ValueRange Range() const;

 private:
  [[nodiscard]] double Slope(double u) const;
  std::array<double, 6> c_;  // of u^k
};

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

/// Goes on from `x`, the state at sample `first`, by `count` samples under a sine and calls
/// take(i, state, [sin w t, cos w t]) for i = 0 .. count - 1, the samples behind `first`. (n, n +
/// 2) `step` of 4 <= n <= 7 states.
///
/// Exact at any rate: a product a sample; the drive's phase is that of the sample's number, so it
/// does not drift. Of 1000 samples of the thesis's adapter scene every state is within 2e-13 of its
/// peak. Cost: some 15 ns a sample of seven states; no allocation.
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

/// The motion over time under a sine drive, exact: there is no time step to choose.
///
/// The drive is appended to the state as its own generator, z = [x, sin w t, cos w t], so that
/// z' = G z and z(t + h) = exp(G h) z(t) without any assumption on the input between samples
/// (C. F. Van Loan, IEEE Trans. Autom. Control 23, 395-404 (1978)). The sine entries are evaluated
/// at each instant rather than stepped, so the drive's phase does not drift.
class TimeResponse {
 public:
  /// Cost: 84 exponentials of (9, 9), 0.3 ms (10 ms where the model has a rest). kSteady takes the
  /// phasor at t = 0 as the initial state.
  TimeResponse(const LinearModel& model, const SineDrive& drive, Start start);
  /// From any state at t = 0: `initial` has model.states() entries.
  TimeResponse(const LinearModel& model, const SineDrive& drive, Eigen::VectorXd initial);

  /// The state at any time 0 <= t_s < 2^20 s (12 days).
  ///
  /// t is taken apart into powers of two, whose exponentials are kept, so the answer costs the same
  /// for any t (some 25 products with a (9, 9) matrix, a few microseconds) and does not depend on
  /// earlier questions. No allocation besides the result; threads may share it.
  [[nodiscard]] Eigen::VectorXd StateAt(double t_s) const;

  /// WindowRmsOf (sim/linear/window_rms.h) of one state. 0 <= begin_s < end_s.
  [[nodiscard]] double WindowRms(Eigen::Index state, double begin_s, double end_s) const;

 private:
  [[nodiscard]] Eigen::MatrixXd Step(double h_s) const;  // DrivenStep

  Eigen::Index states_;
  LinearModel model_;
  SineDrive drive_;
  Eigen::MatrixXd generator_;            // (n + 2, n + 2)
  LongMatrix long_generator_;            // where the model has a rest; else empty
  Eigen::VectorXd initial_;              // (n)
  bool is_steady_ = false;               // from the steady motion's state
  std::vector<Eigen::MatrixXd> powers_;  // DrivenStep over 2^k s, (n, n + 2), smallest k first
};

}  // namespace haptometer::sim
