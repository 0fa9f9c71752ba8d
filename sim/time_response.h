#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "sim/linear_model.h"
#include "sim/scene.h"

namespace haptometer::sim {

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

  /// States at start_s + i / rate_hz for i = 0 .. count - 1, one column each: (n, count).
  /// See uniform_motion.h, which does without the powers where the motion begins at t = 0.
  [[nodiscard]] Eigen::MatrixXd Sample(double start_s, double rate_hz, std::size_t count) const;

  /// sqrt(1/(end - begin) x integral of state^2 dt over [begin_s, end_s]), exact, not sampled.
  ///
  /// The integral is z' S z with S(h) = integral of exp(G' s) c c' exp(G s) over [0, h], built from
  /// a short interval by S(2h) = S(h) + exp(G' h) S(h) exp(G h): only sums of positive semidefinite
  /// terms, hence no cancellation. 0 <= begin_s < end_s.
  [[nodiscard]] double WindowRms(Eigen::Index state, double begin_s, double end_s) const;

 private:
  [[nodiscard]] Eigen::MatrixXd Exponential(double h_s) const;  // of generator_

  Eigen::Index states_;
  LinearModel model_;
  SineDrive drive_;
  Eigen::MatrixXd generator_;            // (n + 2, n + 2)
  Eigen::VectorXd initial_;              // (n)
  std::vector<Eigen::MatrixXd> powers_;  // DrivenStep over 2^k s, (n, n + 2), smallest k first
};

}  // namespace haptometer::sim
