#include "fit/dry_friction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptometer::fit {
namespace {

// position and speed
struct State {
  double u = 0;
  double v = 0;
};

// u'' + 2 d u' + q u = 0
class LinearMotion {
 public:
  explicit LinearMotion(const PolePair& poles)
      : decay_per_s_(poles.decay_per_s),
        stiffness_per_s2_(poles.stiffness_per_s2),
        angular_per_s_(std::sqrt(std::max(stiffness_per_s2_ - decay_per_s_ * decay_per_s_,
                                          1e-12 * stiffness_per_s2_))) {}

  [[nodiscard]] State After(const State& from, double since_s) const {
    const double fall = std::exp(-decay_per_s_ * since_s);
    const double even = fall * std::cos(angular_per_s_ * since_s);
    const double odd = fall * std::sin(angular_per_s_ * since_s) / angular_per_s_;
    return {from.u * (even + decay_per_s_ * odd) + from.v * odd,
            from.v * (even - decay_per_s_ * odd) - stiffness_per_s2_ * from.u * odd};
  }

  // the first turn behind `from`
  [[nodiscard]] double Turn(const State& from) const {
    const double sine = (decay_per_s_ * from.v + stiffness_per_s2_ * from.u) / angular_per_s_;
    double turn_s = std::atan2(from.v, sine) / angular_per_s_;
    const double half_s = std::numbers::pi / angular_per_s_;
    while (turn_s <= 1e-9 * half_s) turn_s += half_s;
    return turn_s;
  }

  [[nodiscard]] double half_period_s() const { return std::numbers::pi / angular_per_s_; }

 private:
  double decay_per_s_;
  double stiffness_per_s2_;
  double angular_per_s_;
};

double Seen(const State& state, RecordedSignal signal) {
  return signal == RecordedSignal::kVoltage ? state.v : state.u;
}

// of even E + odd O: of a voltage the motion is the integral that dies away
State BeginOf(const FrictionRing& ring) {
  const double d = ring.poles.decay_per_s;
  if (ring.signal != RecordedSignal::kVoltage) {
    return {ring.even_v, ring.odd_v_per_s - d * ring.even_v};
  }
  return {-(ring.odd_v_per_s + d * ring.even_v) / ring.poles.stiffness_per_s2, ring.even_v};
}

double DirectionOf(const State& state) {
  if (state.v != 0) return state.v > 0 ? 1 : -1;
  return state.u > 0 ? -1 : 1;
}

// the zero of `value` that is nearest to `near_s` within a half period before 0, by bisection
template <typename Value>
double ZeroBefore(const Value& value, double near_s, double half_period_s) {
  constexpr int kSteps = 64;
  const double step_s = half_period_s / kSteps;
  double best_s = 0;
  bool found = false;
  for (int k = 0; k < kSteps; ++k) {
    double late_s = -k * step_s;
    double early_s = late_s - step_s;
    if ((value(early_s) > 0) == (value(late_s) > 0)) continue;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle_s = 0.5 * (early_s + late_s);
      ((value(middle_s) > 0) == (value(late_s) > 0) ? late_s : early_s) = middle_s;
    }
    if (found && std::abs(late_s - near_s) > std::abs(best_s - near_s)) continue;
    best_s = late_s;
    found = true;
  }
  return best_s;
}

}  // namespace

std::vector<double> MotionWithFriction(const FrictionRing& ring, std::span<const double> times_s) {
  const LinearMotion motion(ring.poles);
  std::vector<double> seen(times_s.size());
  double begin_s = 0;
  State begin = BeginOf(ring);
  double shift = ring.friction * DirectionOf(begin);  // of u about its middle
  double end_s = motion.Turn({begin.u + shift, begin.v});
  bool is_over = false;
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    // half swings that end before this time
    while (!is_over && times_s[n] >= end_s) {
      const State turn = motion.After({begin.u + shift, begin.v}, end_s - begin_s);
      begin = {turn.u - shift, 0};
      begin_s = end_s;
      shift = ring.friction * DirectionOf(begin);
      is_over = std::abs(begin.u) <= ring.friction;
      end_s += motion.half_period_s();
    }
    if (is_over) {
      seen[n] = Seen(begin, ring.signal);
      continue;
    }
    State state = motion.After({begin.u + shift, begin.v}, times_s[n] - begin_s);
    state.u -= shift;
    seen[n] = Seen(state, ring.signal);
  }
  return seen;
}

std::vector<double> LinearLessFriction(const FrictionRing& ring, double begin_s, bool release,
                                       std::span<const double> times_s) {
  const LinearMotion motion(ring.poles);
  const State now = BeginOf(ring);
  const double shift = ring.friction * DirectionOf(now);
  const auto at = [&](double time_s) {
    State state = motion.After({now.u + shift, now.v}, time_s);
    state.u -= shift;
    return state;
  };
  const auto which = [&](double time_s) { return release ? at(time_s).v : at(time_s).u; };
  const double zero_s = ZeroBefore(which, begin_s, motion.half_period_s());
  State begin = at(zero_s);
  (release ? begin.v : begin.u) = 0;
  std::vector<double> difference = MotionWithFriction(ring, times_s);
  for (std::size_t n = 0; n < times_s.size(); ++n) {
    difference[n] = Seen(motion.After(begin, times_s[n] - zero_s), ring.signal) - difference[n];
  }
  return difference;
}

}  // namespace haptometer::fit
