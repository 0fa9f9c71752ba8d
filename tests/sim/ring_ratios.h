#pragma once

#include <cmath>

#include "sim/ring_down.h"

namespace haptometer::sim {

// A signal of the ringing `time_s` after the blow. Before it there is none; what is given then is
// the ringing continued backwards, without the current's build-up.
template <typename T>
T RatioAt(const RingDown<T>& ringing, const RingingShape<T>& shape, const T& time_s) {
  using std::exp;
  const auto pair = DampedFundamentals(ringing.decay_per_s(), ringing.stiffness_per_s2(), time_s);
  const T value = shape.even * pair.even + shape.odd * pair.odd;
  if (!(ringing.electrical_rate_per_s() > 0.0) || time_s < 0.0) return value;
  return value + shape.electrical * exp(-ringing.electrical_rate_per_s() * time_s);
}

template <typename T>
T VoltageRatio(const RingDown<T>& ringing, const T& time_s) {
  return RatioAt(ringing, ringing.voltage(), time_s);
}
template <typename T>
T DisplacementRatio(const RingDown<T>& ringing, const T& time_s) {
  return RatioAt(ringing, ringing.displacement(), time_s);
}
template <typename T>
T ReleaseRatio(const RingDown<T>& ringing, const T& time_s) {
  return RatioAt(ringing, ringing.release(), time_s);
}

}  // namespace haptometer::sim
