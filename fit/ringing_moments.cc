#include "fit/ringing_moments.h"

#include <cmath>

#include "sim/ring_down.h"

namespace haptometer::fit {
namespace {

constexpr double kSeries = 1;  // |(d^2 - q) t^2| below which O's slope cancels

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
      steps_per_s_(step_s > 0 ? 1 / step_s : 0) {
  if (!(step_s > 0)) return;
  for (std::size_t k = 0; k < kSteps; ++k) {
    table_[k] = Computed(decay_per_s, stiffness_per_s2, static_cast<double>(k) * step_s);
  }
}

RingingMoment RingingMoments::Begin(double since_s) {
  first_ = Computed(decay_per_s_, stiffness_per_s2_, since_s);
  return first_;
}

double RingingMoments::OddByDiscriminant(const RingingMoment& moment) const {
  const double t = moment.since_s;
  const double z = discriminant_per_s2_ * t * t;
  return std::abs(z) < kSeries ? std::exp(-decay_per_s_ * t) * t * t * t * OddSeries(z)
                               : (t * moment.even - moment.odd) / (2 * discriminant_per_s2_);
}

RingingSlopes RingingMoments::SlopesAt(const RingingMoment& moment) const {
  const auto [t, even, odd, electrical] = moment;
  const double by_discriminant = OddByDiscriminant(moment);
  return {.even_by_decay = t * (decay_per_s_ * odd - even),
          .even_by_stiffness = -0.5 * t * odd,
          .even_by_time = discriminant_per_s2_ * odd - decay_per_s_ * even,
          .odd_by_decay = 2 * decay_per_s_ * by_discriminant - t * odd,
          .odd_by_stiffness = -by_discriminant,
          .odd_by_time = even - decay_per_s_ * odd};
}

}  // namespace haptometer::fit
