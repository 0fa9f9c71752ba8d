#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim/linear/driven_step.h"
#include "sim/linear/linear_model.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// x' = A x + B amplitude_v sin(2 pi frequency_hz t), from a state at t = 0 on.
struct LinearMotion {
  LongMatrix a;  ///< (n, n)
  LongVector b;  ///< (n)
  double amplitude_v = 0;
  double frequency_hz = 0;  ///< > 0
  /// (n): the state at t = 0; absent: the steady motion, as if the drive had been on forever.
  std::optional<LongVector> initial;
};

/// The motion of `scene`, whose drive is a sine, without stops, lost contact or smooth effects. An
/// offset of the voltage moves where mover and current rest, and nothing else: the coil's forces
/// cancel. States count from there, so positions of case and skin are the scene's own.
[[nodiscard]] LinearMotion LinearMotionOf(const Scene& scene);

/// An RMS value over a window of time.
struct WindowRms {
  double rms = 0;
  double error_estimate = 0;  ///< bound of its relative error
};

/// sqrt(1/(end - begin) x integral of state^2 dt over [begin_s, end_s]), exact, not sampled.
///
/// The integral is z' S z with S(h) = integral of exp(G' s) c c' exp(G s) over [0, h], built from
/// a short interval by S(2h) = S(h) + exp(G' h) S(h) exp(G h): only sums of positive semidefinite
/// terms, hence no cancellation.
///
/// z is the free motion and the drive, which do not act on each other, and c'z the free motion's
/// state and the phasor: states that an adapter keeps quiet, a billionth of the others, keep their
/// digits. Where the phasor is far larger than the motion (a resonance that builds up) z is the
/// motion under the drive instead: of both ways the one that is known better.
///
/// All is computed in long double and, for the error, in double: what they are apart is the
/// rounding of the double, and long double has 2048 times less.
/// 0 <= begin_s < end_s. Cost: some 0.5 ms.
[[nodiscard]] WindowRms WindowRmsOf(const LinearMotion& motion, Eigen::Index state,
                                    long double begin_s, long double end_s);

}  // namespace haptometer::sim
