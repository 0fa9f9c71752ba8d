#pragma once

#include <cstddef>
#include <vector>

#include "fit/impulse_record.h"
#include "fit/least_squares.h"
#include "fit/poles.h"

namespace haptometer::fit {

/// Samples of one record that are looked at together: means of blocks of equal length, those with a
/// hole left out. A mean scales an oscillation and moves it, but leaves its poles as they are.
struct RingSamples {
  double step_s = 0;                                 ///< between blocks
  RecordedSignal signal = RecordedSignal::kVoltage;  ///< a voltage goes as the motion's speed
  std::vector<double> times_s;  ///< of the blocks' middles, on the record's own axis
  std::vector<double> values_v;
};

/// Samples `first` to `end` of a record as blocks of `block` samples.
[[nodiscard]] RingSamples BlocksOf(const ImpulseRecord& record, std::size_t first, std::size_t end,
                                   std::size_t block);

/// What a ring-down may hold besides one decaying oscillation and its offset.
struct RingBackground {
  bool drifts = false;        ///< a straight line
  double hum_hz = 0;          ///< a sine of this frequency; 0: none
  bool has_friction = false;  ///< dry friction (dry_friction.h)
};

/// One ring-down as a pole pair of its own: no mass, no load.
///
///     v = even E(t) + odd O(t) + offset + drift (t - middle) + cosine cos(2 pi hum t) + sine
///     sin(...)
///
/// E and O are sim/ring_down.h's fundamental solutions, t counts from the first sample. With dry
/// friction the ringing is dry_friction.h's, which begins as the linear one does.
struct RingFit {
  PolePair poles;
  double even_v = 0;
  double odd_v_per_s = 0;
  double offset_v = 0;
  double drift_v = 0;  ///< from the first sample to the last
  double hum_cosine_v = 0;
  double hum_sine_v = 0;
  double friction = 0;  ///< its force over the spring's stiffness, as FrictionRing has it
  bool converged = false;
  /// At the solution: ln decay, ln stiffness, then the linear parts, then the friction; in volts.
  Jacobian jacobian;

  /// sqrt of the ringing's energy as an amplitude: its envelope `since_s` after the first sample.
  [[nodiscard]] double Envelope(double since_s) const;
  [[nodiscard]] double HumAmplitude() const;
};

/// Fits from `start`; see least_squares.h. At least 16 samples.
///
/// Cost: linear in the samples: 0.3 us a sample where the oscillation is long enough to be
/// condensed (condensed_record.h), else 2 us; with friction 10 us. It is the one-record counterpart
/// of RingDownProblem, for looking at a record before anything is known of its circuit.
[[nodiscard]] RingFit FitRing(const RingSamples& samples, const PolePair& start,
                              const RingBackground& background);

}  // namespace haptometer::fit
