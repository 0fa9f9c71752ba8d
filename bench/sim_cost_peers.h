#pragma once

// Other people's methods, and what laboratories write for themselves, put to the questions of
// sim_cost.cc. All of them solve RateOf() (sim_cost_bodies.h).

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bench/sim_cost_bodies.h"

namespace haptometer::sim {

/// What a method makes of a question.
struct Answer {
  Eigen::MatrixXd samples;  ///< (compared states, 1 + outputs), the first at t = 0
  std::vector<double> events_s{};
  std::int64_t steps = 0;        ///< of time
  std::int64_t evaluations = 0;  ///< of the rate
  std::string failure{};         ///< empty: it answered
};

/// Room for the samples, at rest.
[[nodiscard]] inline Answer EmptyAnswer(const Question& question, std::size_t outputs) {
  return {.samples = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(question.compared()),
                                           static_cast<Eigen::Index>(outputs) + 1)};
}

/// What an adaptive method is asked for.
struct Tolerance {
  double relative = 0;
  Eigen::VectorXd largest;  ///< of each state; a tenth of `relative` of it is let go in any case
};

/// SUNDIALS CVODES as its documentation advises: dense Newton with the Jacobian written down, an
/// absolute tolerance for each state, outputs by its interpolant; its root finding and a new
/// beginning at each event.
enum class Multistep : std::uint8_t { kBdf, kAdams };
[[nodiscard]] Answer ByCvode(const Question& question, std::size_t outputs, Multistep method,
                             const Tolerance& tolerance);

/// SUNDIALS ARKODE, order 5, explicit or diagonally implicit (then as CVODE). No events.
enum class Stages : std::uint8_t { kExplicit, kImplicit };
[[nodiscard]] Answer ByArkode(const Question& question, std::size_t outputs, Stages stages,
                              const Tolerance& tolerance);

/// Boost.odeint's controlled Dormand-Prince 5(4), states in units of their largest values; steps
/// end at outputs. No events.
[[nodiscard]] Answer ByDopri5(const Question& question, std::size_t outputs,
                              const Tolerance& tolerance);

/// `inner` equal steps between two outputs. An event is what a step ends beyond: then the impact,
/// or the other mode, at that step's end.
enum class FixedStep : std::uint8_t {
  kRungeKutta4,
  kSemiImplicitEuler,  ///< speeds and current first, positions by the new speeds
};
[[nodiscard]] Answer ByFixedSteps(const Question& question, std::size_t outputs, FixedStep method,
                                  int inner);

}  // namespace haptometer::sim
