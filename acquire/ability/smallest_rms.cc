#include "acquire/ability/smallest_rms.h"

#include <cmath>

#include "base/error.h"

namespace haptometer::acquire {
namespace {

void CheckNoise(const NoiseInBand& noise) {
  HAPTOMETER_CHECK(noise.rms_m > 0 && noise.bandwidth_hz > 0, "{} m in {} Hz", noise.rms_m,
                   noise.bandwidth_hz);
  HAPTOMETER_CHECK(noise.record_s > 0 && noise.noise_record_s > 0, "{} s, {} s", noise.record_s,
                   noise.noise_record_s);
}

// variances of two mean squares of noise, in units of that over the record
double NoiseParts(const NoiseInBand& noise) { return 1 + noise.record_s / noise.noise_record_s; }

}  // namespace

double RelativeUncertainty(const NoiseInBand& noise, double rms_m) {
  CheckNoise(noise);
  HAPTOMETER_CHECK(rms_m > 0, "rms_m = {}", rms_m);
  const double q = rms_m * rms_m / (noise.rms_m * noise.rms_m);
  const double scatter = (NoiseParts(noise) + 2 * q) / (4 * noise.bandwidth_hz * noise.record_s);
  return std::sqrt(scatter) / q;
}

double SmallestRms(const NoiseInBand& noise, double relative) {
  CheckNoise(noise);
  HAPTOMETER_CHECK(relative > 0, "relative = {}", relative);
  const double s = 4 * noise.bandwidth_hz * noise.record_s * relative * relative;
  const double q = (1 + std::sqrt(1 + NoiseParts(noise) * s)) / s;
  return noise.rms_m * std::sqrt(q);
}

}  // namespace haptometer::acquire
