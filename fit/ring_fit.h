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
  double step_s = 0;            ///< between blocks
  std::vector<double> times_s;  ///< of the blocks' middles, on the record's own axis
  std::vector<double> values_v;
};

/// Samples `first` to `end` of a record as blocks of `block` samples.
[[nodiscard]] RingSamples BlocksOf(const ImpulseRecord& record, std::size_t first, std::size_t end,
                                   std::size_t block);

/// What may lie under a ring-down besides its offset.
struct RingBackground {
  bool drifts = false;  ///< a straight line
  double hum_hz = 0;    ///< a sine of this frequency; 0: none
};

/// One ring-down as a pole pair of its own: no mass, no load.
///
///     v = even E(t) + odd O(t) + offset + drift (t - middle) + cosine cos(2 pi hum t) + sine
///     sin(...)
///
/// E and O are sim/ring_down.h's fundamental solutions, t counts from the first sample.
struct RingFit {
  PolePair poles;
  double even_v = 0;
  double odd_v_per_s = 0;
  double offset_v = 0;
  double drift_v = 0;  ///< from the first sample to the last
  double hum_v = 0;    ///< amplitude
  bool converged = false;
  Jacobian jacobian;  ///< at the solution: ln decay, ln stiffness, then the linear parts; in volts

  /// sqrt of the ringing's energy as an amplitude: its envelope `since_s` after the first sample.
  [[nodiscard]] double Envelope(double since_s) const;
};

/// Fits from `start`; see least_squares.h. At least 16 samples.
///
/// Cost: about 2 us a sample. It is the one-record counterpart of RingDownProblem, for looking at a
/// record before anything is known of its circuit.
[[nodiscard]] RingFit FitRing(const RingSamples& samples, const PolePair& start,
                              const RingBackground& background);

}  // namespace haptometer::fit
