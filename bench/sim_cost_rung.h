#pragma once

// One line of docs/sim_cost.csv.

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>

#include "bench/sim_cost_peers.h"
#include "bench/sim_cost_truth.h"

namespace haptometer::sim {

/// A way to answer a question up to an output.
struct Rung {
  std::string scene;
  std::string method;
  std::string setting;
  std::function<Answer(std::size_t outputs)> run;
  int runs = 20;  ///< to time, at most
  /// An error of a state, over its largest value, that is no answer any more.
  double lost_above = 0.5;
};

/// The best time of `runs` in microseconds; after a quarter of a second three are enough.
[[nodiscard]] double BestMicroseconds(int runs, const std::function<void()>& run);

/// Each state's largest deviation at any output over its largest value.
[[nodiscard]] Eigen::VectorXd ErrorsOf(const Eigen::MatrixXd& samples, const Truth& truth);

/// Relative error of the skin's RMS over the second half of the run, from the samples.
[[nodiscard]] double RmsErrorOf(const Eigen::MatrixXd& samples, const Truth& truth);

/// Runs it once for its error, then for its time: whole, and to its first output. Prints the line.
void Measure(const Rung& rung, const Truth& truth);

}  // namespace haptometer::sim
