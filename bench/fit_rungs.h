#pragma once

// Ways from two ring-downs to Kv, Bv and Km that fit/ does not offer, or offers in parts, because
// the ladder of fit_cost.cc says what they would cost.

#include <optional>
#include <vector>

#include "fit/drop_test/drop_test_model.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/ring_down_problem.h"

namespace haptometer::fit {

/// 0: not found.
struct Constants {
  double stiffness_n_per_m = 0;
  double damping_n_s_per_m = 0;
  double force_constant_n_per_a = 0;
};

/// An open record and one with a load, of the same actuator.
using RecordPair = std::vector<ImpulseRecord>;

/// The two-load formula: Kv = M q, Bv = 2 M d, Km^2 = 2 M (d' - d) (R + RL).
[[nodiscard]] Constants ConstantsOf(const PolePair& open, const PolePair& loaded,
                                    const ActuatorKnowns& knowns, double load_ohm);

/// Poles from the largest line of the padded spectrum, by a parabola through its neighbours, and
/// from that line's width at half of its power.
[[nodiscard]] std::optional<PolePair> PolesBySpectrum(const ImpulseRecord& record);

/// Poles by the matrix pencil (poles.h).
[[nodiscard]] std::optional<PolePair> PolesByPencil(const ImpulseRecord& record);

/// Both records as one problem with its start values.
struct JointProblem {
  RingDownProblem problem;
  RingDownPoint start;
  std::vector<bool> is_free;
};

/// Start values from pencil and one-record fits (drop_test_model.h); nothing where a record is
/// refused.
[[nodiscard]] std::optional<JointProblem> MakeJointProblem(const RecordPair& records,
                                                           const ActuatorKnowns& knowns);

/// Guesses in place of the start's poles: this frequency, Q = 30, Km = 0.5 N/A.
void StartFrom(double frequency_hz, JointProblem* joint);

/// The frequency of the spectrum's highest line, zero-padded to twice the length.
[[nodiscard]] double SpectrumLine(const ImpulseRecord& record);

[[nodiscard]] Constants ConstantsAt(const RingDownPoint& point);

/// Gauss-Newton steps, each halved until the cost falls; until a step changes the residuals by less
/// than 1e-10 of them. False: no step lowers the cost, or 200 steps were not enough.
[[nodiscard]] bool MinimiseByGaussNewton(const JointProblem& joint, RingDownPoint* point);

/// Ceres with automatic derivatives of the whole model, all tolerances `tolerance`.
[[nodiscard]] bool MinimiseByAutomaticDerivatives(const JointProblem& joint,
                                                  const ActuatorKnowns& knowns, double tolerance,
                                                  RingDownPoint* point);

/// Means of `block` samples, or every `block`-th sample.
[[nodiscard]] ImpulseRecord Averaged(const ImpulseRecord& record, std::size_t block);
[[nodiscard]] ImpulseRecord Decimated(const ImpulseRecord& record, std::size_t block);

}  // namespace haptometer::fit
