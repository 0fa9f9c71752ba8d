#include "fit/ringing_moments.h"

#include <cmath>

#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

constexpr double kOffGrid = 1e-6;       // of a step: more than rounding
constexpr double kMostExponents = 700;  // e^-700 is no part of any voltage
constexpr double kSeries = 1;           // |(d^2 - q) t^2| below which O's slope cancels

RingingMoment Computed(double decay_per_s, double stiffness_per_s2, double since_s) {
  const auto pair = sim::DampedFundamentals(decay_per_s, stiffness_per_s2, since_s);
  return {.since_s = since_s, .even = pair.even, .odd = pair.odd};
}

// (cosh x - sinh(x)/x) / (2 x^2) by x^2 = z: sum of z^(k-1) k/(2k+1)!, the tenth term below 1e-18
double OddSeries(double z) {
  double sum = 0;
  for (int k = 9; k >= 2; --k) {
    // term k over term k - 1
    const double ratio = k / ((k - 1.0) * 2 * k * (2 * k + 1));
    sum = (1 + sum) * z * ratio;
  }
  return (1 + sum) / 6;
}

}  // namespace

RingingMoments::RingingMoments(double decay_per_s, double stiffness_per_s2,
                               double electrical_rate_per_s, double step_s)
    : decay_per_s_(decay_per_s),
      discriminant_per_s2_(decay_per_s * decay_per_s - stiffness_per_s2),
      stiffness_per_s2_(stiffness_per_s2),
      electrical_rate_per_s_(electrical_rate_per_s),
      step_s_(step_s) {
  if (!(step_s > 0)) return;
  for (std::size_t k = 0; k < kSteps; ++k) {
    table_[k] = Computed(decay_per_s, stiffness_per_s2, static_cast<double>(k) * step_s);
  }
}

RingingMoment RingingMoments::At(double since_s) {
  const double steps = (since_s - first_.since_s) / step_s_;
  RingingMoment moment;
  if (steps >= 0 && steps < static_cast<double>(kSteps) - 0.5 &&
      std::abs(steps - std::floor(steps + 0.5)) < kOffGrid) {
    const RingingMoment& further = table_[static_cast<std::size_t>(steps + 0.5)];
    moment.since_s = since_s;
    moment.even = first_.even * further.even + discriminant_per_s2_ * first_.odd * further.odd;
    moment.odd = first_.odd * further.even + first_.even * further.odd;
  } else {
    moment = first_ = Computed(decay_per_s_, stiffness_per_s2_, since_s);
  }
  const double exponents = electrical_rate_per_s_ * since_s;
  if (electrical_rate_per_s_ > 0 && since_s >= 0 && exponents < kMostExponents) {
    moment.electrical = std::exp(-exponents);
  }
  return moment;
}

RingingSlopes RingingMoments::SlopesAt(const RingingMoment& moment) const {
  const auto [t, even, odd, electrical] = moment;
  const double z = discriminant_per_s2_ * t * t;
  // of O by d^2 - q alone
  const double by_discriminant = std::abs(z) < kSeries
                                     ? std::exp(-decay_per_s_ * t) * t * t * t * OddSeries(z)
                                     : (t * even - odd) / (2 * discriminant_per_s2_);
  return {.even_by_decay = t * (decay_per_s_ * odd - even),
          .even_by_stiffness = -0.5 * t * odd,
          .even_by_time = discriminant_per_s2_ * odd - decay_per_s_ * even,
          .odd_by_decay = 2 * decay_per_s_ * by_discriminant - t * odd,
          .odd_by_stiffness = -by_discriminant,
          .odd_by_time = even - decay_per_s_ * odd};
}

}  // namespace haptometer::fit
