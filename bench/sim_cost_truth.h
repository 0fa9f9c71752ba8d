#pragma once

// What the ladders of sim_cost.cc are measured against: a question's motion in 113 bits.

#include <Eigen/Core>
#include <vector>

#include "bench/sim_cost_bodies.h"

namespace haptometer::sim {

/// What is known of a motion.
struct Truth {
  Eigen::MatrixXd samples;  ///< (compared states, 1 + outputs), the first at t = 0
  Eigen::VectorXd largest;  ///< of each state
  std::vector<double> events_s;
};

/// By Taylor series of order 36 over 8 us or less in 113-bit arithmetic, the drive's sine and
/// cosine stepped with the states. Steps end at events, which are the first place where a
/// guard's own series is below zero, halved to 1e-30 of a step. Nothing is in common with sim/.
/// The truncated terms are below 1e-33 of a state. Cost: some 2 s for 1000 outputs.
[[nodiscard]] Truth TruthOf(const Question& question);

/// How far the truth is from the references of tests/sim/reference at their ends, 0.0123 s and
/// 1/32 s: the worst state over its largest value.
struct ReferenceDifferences {
  double fifty_digits = 0;  ///< linear, stops, breaking contact
  double scipy = 0;         ///< stiffening spring and heating coil; those hold 3e-11
};

[[nodiscard]] ReferenceDifferences DifferencesToReferences();

}  // namespace haptometer::sim
