#include "fit/ringing_parts.h"

#include <cmath>

namespace haptometer::fit {

std::array<double, 3> RecordingParts::At(double time_s) const {
  if (hum_rad_per_s == 0) return {time_s - middle_s, 1, 0};
  return {time_s - middle_s, std::cos(hum_rad_per_s * time_s), std::sin(hum_rad_per_s * time_s)};
}

RingingParts::RingingParts(const RingDownSamples& record, const RingingRates& rates)
    : recording_(record),
      impact_s_(rates.impact_s),
      per_time_scale_(1 / record.time_scale),
      moments_(rates.decay_per_s, rates.stiffness_per_s2, rates.electrical_rate_per_s,
               record.step_s / record.time_scale) {}

PartNumbers RingingParts::At(double time_s) {
  const RingingMoment moment = moments_.At((time_s - impact_s_) * per_time_scale_);
  const auto [t, even, odd, electrical] = moment;
  const auto [drift, cosine, sine] = recording_.At(time_s);
  return {even,
          odd,
          t * even,
          t * odd,
          moments_.OddByDiscriminant(moment),
          electrical,
          t * electrical,
          1,
          drift,
          cosine,
          sine};
}

double RingingParts::SumAt(double time_s, const PartNumbers& coefficients) {
  const RingingMoment moment = moments_.At((time_s - impact_s_) * per_time_scale_);
  const auto [drift, cosine, sine] = recording_.At(time_s);
  const auto share = [&coefficients](Part part, double value) {
    return coefficients[Index(part)] * value;
  };
  return share(Part::kConstant, 1) + share(Part::kEven, moment.even) +
         share(Part::kOdd, moment.odd) + share(Part::kElectrical, moment.electrical) +
         share(Part::kDrift, drift) + share(Part::kHumCosine, cosine) + share(Part::kHumSine, sine);
}

}  // namespace haptometer::fit
