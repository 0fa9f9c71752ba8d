#pragma once

#include <span>
#include <vector>

#include "fit/impulse_record.h"
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

}  // namespace haptometer::fit
