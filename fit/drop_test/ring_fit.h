#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/ring_down_problem.h"
#include "fit/least_squares.h"
#include "fit/poles.h"

namespace haptometer::fit {

/// A ring-down with dry friction, as a recorder sees it:
///
///     u'' + 2 d u' + q (u + f sign(u')) = 0,    d, q the poles',
///
/// of which a voltage shows u' and a displacement u. Between two turns (u' = 0) it is the linear
/// motion about -f sign(u'); it ends at the first turn with |u| <= f.
struct FrictionRing {
  PolePair poles;  ///< an oscillation: d^2 < q
  /// What the linear ring-down even E(t) + odd O(t) of the same state at t = 0 is made of.
  double even_v = 0;
  double odd_v_per_s = 0;
  /// f: the friction's force over the spring's stiffness, in what u is counted in: V s of a
  /// voltage. Below 0 it drives; the motion then goes on.
  double friction = 0;
  RecordedSignal signal = RecordedSignal::kVoltage;
};

/// The motion at times that rise from 0. Exact but for rounding, half swing by half swing. Cost:
/// two sines and an exponential a time.
[[nodiscard]] std::vector<double> MotionWithFriction(const FrictionRing& ring,
                                                     std::span<const double> times_s);

/// What a linear motion has more than this one at `times_s`, the two being alike when the motion
/// began: both at rest where a `release` begins them, else both at u = 0 with one speed, at the
/// instant before the first half swing's end that is nearest to `begin_s` (below 0). To be added to
/// a record of the one, it is a record of the other.
[[nodiscard]] std::vector<double> LinearLessFriction(const FrictionRing& ring, double begin_s,
                                                     bool release, std::span<const double> times_s);

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
  bool drifts = false;           ///< a straight line
  std::vector<double> hum_hz{};  ///< sines of these frequencies, at most kMostHumLines
  bool has_friction = false;     ///< dry friction (FrictionRing)
};

/// cosine cos(2 pi hum t) + sine sin(2 pi hum t), t on the record's own axis.
struct HumLine {
  double frequency_hz = 0;
  double cosine_v = 0;
  double sine_v = 0;

  [[nodiscard]] double At(double time_s) const;
};

/// One ring-down as a pole pair of its own: no mass, no load.
///
///     v = even E(t) + odd O(t) + offset + drift (t - middle)
///         + sum of cosine cos(2 pi hum t) + sine sin(2 pi hum t)
///
/// E and O are sim/ring_down.h's fundamental solutions, t counts from the first sample. With dry
/// friction the ringing is FrictionRing's, which begins as the linear one does.
struct RingFit {
  PolePair poles;
  double even_v = 0;
  double odd_v_per_s = 0;
  double offset_v = 0;
  double drift_v = 0;  ///< from the first sample to the last
  std::vector<HumLine> hum;
  double friction = 0;  ///< its force over the spring's stiffness, as FrictionRing has it
  bool converged = false;
  /// At the solution: ln decay, ln stiffness, then the linear parts, then the friction; in volts.
  Jacobian jacobian;

  /// sqrt of the ringing's energy as an amplitude: its envelope `since_s` after the first sample.
  [[nodiscard]] double Envelope(double since_s) const;
  /// Of all lines together: the root of their squares' sum; 0: none.
  [[nodiscard]] double HumAmplitude() const;
  /// Sum of the residuals' squares.
  [[nodiscard]] double Squares() const;
  /// Standard uncertainty of one of the parameters, for residuals of this variance.
  [[nodiscard]] double Deviation(std::size_t column, double variance) const;
};

/// Fits from `start`; see least_squares.h. At least 16 samples.
///
/// Cost: linear in the samples: 0.3 us a sample where the oscillation is long enough to be
/// condensed (condensed_record.h), else 2 us; with friction 10 us. It is the one-record counterpart
/// of RingDownProblem, for looking at a record before anything is known of its circuit.
[[nodiscard]] RingFit FitRing(const RingSamples& samples, const PolePair& start,
                              const RingBackground& background);

}  // namespace haptometer::fit
