#include "dsp/analysis/sensor_gain.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "trial/sensor_head.h"

namespace haptometer::dsp {
namespace {

// frequencies at which the gain is evaluated over a band
constexpr int kGridSteps = 1000;

// rows that one reading fills
int RepeatsOf(double rate_hz, double fresh_rate_hz) {
  const double ratio = rate_hz / fresh_rate_hz;
  if (!(ratio > 1 + kNoticeable)) return 1;
  const double whole = std::round(ratio);
  return static_cast<int>(std::abs(ratio - whole) <= kNoticeable * whole ? whole
                                                                         : std::ceil(ratio));
}

}  // namespace

SensorAveraging AveragingOf(const trial::Metadata& metadata, double rate_hz, double fresh_rate_hz) {
  SensorAveraging sensor;
  sensor.rate_hz = rate_hz;
  // a sensor without averaging is known; repeated readings hold a value for several rows
  sensor.repeats = RepeatsOf(rate_hz, fresh_rate_hz);
  if (!metadata.averages || *metadata.averages < 1) return sensor;
  sensor.averages = *metadata.averages;
  if (sensor.averages == 1) {
    sensor.knowledge = sensor.repeats == 1 ? SensorKnowledge::kNone : SensorKnowledge::kKnown;
  } else if (metadata.sampling_s && *metadata.sampling_s > 0) {
    sensor.knowledge = SensorKnowledge::kKnown;
    sensor.sampling_s = *metadata.sampling_s;
  }
  return sensor;
}

std::optional<double> GainAt(const SensorAveraging& sensor, double frequency_hz) {
  // averaging over the sensor's samples, holding over the rows of a repeated reading
  if (sensor.knowledge == SensorKnowledge::kUnknown) return std::nullopt;
  const double averaging =
      sensor.averages > 1 ? trial::AveragingGain(frequency_hz, sensor.sampling_s, sensor.averages)
                          : 1;
  const double holding =
      sensor.repeats > 1 ? trial::AveragingGain(frequency_hz, 1 / sensor.rate_hz, sensor.repeats)
                         : 1;
  return averaging * holding;
}

// the gain is not monotone beyond its first zero: a grid instead of the two ends
std::optional<GainBounds> GainsOver(const SensorAveraging& sensor, double lower_hz,
                                    double upper_hz) {
  const std::optional<double> first = GainAt(sensor, lower_hz);
  if (!first) return std::nullopt;
  GainBounds bounds{*first, *first};
  for (int k = 1; k <= kGridSteps; ++k) {
    const double frequency_hz = lower_hz + (upper_hz - lower_hz) * k / kGridSteps;
    const double gain = *GainAt(sensor, frequency_hz);
    bounds.least = std::min(bounds.least, gain);
    bounds.greatest = std::max(bounds.greatest, gain);
  }
  return bounds;
}

int MostAverages(double frequency_hz, double sampling_s) {
  HAPTOMETER_CHECK(frequency_hz > 0 && sampling_s > 0, "{} Hz, {} s", frequency_hz, sampling_s);
  // the first zero of the gain is where the averages last one period
  const double most = std::max(1.0, std::ceil(1 / (frequency_hz * sampling_s)));
  int averages = static_cast<int>(std::min(most, 1e6));
  while (averages > 1 &&
         trial::AveragingGain(frequency_hz, sampling_s, averages) < kLeastSensorGain) {
    --averages;
  }
  return averages;
}

}  // namespace haptometer::dsp
