#include "acquire/ability/capability.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "acquire/ability/smallest_rms.h"
#include "acquire/protocol/wire.h"
#include "base/error.h"
#include "trial/sensor_head.h"

namespace haptometer::acquire {
namespace {

// -3 dB: what is less is mostly gone, and correcting for it raises the noise by as much
constexpr double kLeastGain = std::numbers::sqrt2 / 2;
// a rate that is enough by the arithmetic is not refused for its rounding
constexpr double kRounding = 1e-9;

double GainAt(const SensorAbility& sensor, double frequency_hz) {
  if (sensor.averages == 1 || frequency_hz == 0) return 1;
  return trial::AveragingGain(frequency_hz, sensor.sampling_s, sensor.averages);
}

// white noise over 0 to half the rate: what of it lies in the band, and how wide that part is
void AddNoise(const CapabilityQuestion& question, Capability* capability) {
  const SensorAbility& sensor = capability->sensor;
  const double half_rate_hz = 0.5 * sensor.rate_hz;
  const double bandwidth_hz = std::min(question.upper_hz, half_rate_hz) - question.lower_hz;
  if (!sensor.noise_rms_m || bandwidth_hz <= 0) return;
  const double rms_m = *sensor.noise_rms_m * std::sqrt(bandwidth_hz / half_rate_hz);
  capability->noise_in_band_m = rms_m;
  if (!(rms_m > 0)) return;
  const NoiseInBand noise{.rms_m = rms_m,
                          .bandwidth_hz = bandwidth_hz,
                          .record_s = question.record_s,
                          .noise_record_s = question.record_s};
  capability->smallest_rms_10_percent_m = SmallestRms(noise, 0.1);
  capability->smallest_rms_1_percent_m = SmallestRms(noise, 0.01);
}

// "10240", "48.39"
std::string RateText(double rate_hz) {
  return rate_hz < 1000 ? fmt::format("{:.4g}", rate_hz) : fmt::format("{:.0f}", rate_hz);
}

// why it cannot answer; empty where it can
std::string Obstacle(const Capability& capability, const CapabilityQuestion& question) {
  const SensorAbility& sensor = capability.sensor;
  if (capability.highest_hz < question.upper_hz * (1 - kRounding)) {
    return fmt::format("{} new readings/s ({}) show motion up to {:.3g} Hz; {:g} Hz needs {:g}",
                       RateText(sensor.rate_hz), sensor.limit, capability.highest_hz,
                       question.upper_hz, kReadingsPerPeriod * question.upper_hz);
  }
  if (capability.gain_upper < kLeastGain) {
    return fmt::format("its {} averages at {:g} ms leave {:.3f} of {:g} Hz: set fewer",
                       sensor.averages, 1e3 * sensor.sampling_s, capability.gain_upper,
                       question.upper_hz);
  }
  if (sensor.resolution_m && *sensor.resolution_m > question.resolution_m * (1 + kRounding)) {
    return fmt::format("its steps are {:g} um, {:g} um are wanted", 1e6 * *sensor.resolution_m,
                       1e6 * question.resolution_m);
  }
  return {};
}

std::string Praise(const Capability& capability, const CapabilityQuestion& question) {
  std::string reason = fmt::format("{} new readings/s ({}) show motion up to {:.4g} Hz",
                                   RateText(capability.sensor.rate_hz), capability.sensor.limit,
                                   capability.highest_hz);
  if (capability.smallest_rms_10_percent_m) {
    reason += fmt::format(
        "; noise of {:.2g} um in the band lets {:.2g} um RMS be told to 10 % in "
        "{:g} s",
        1e6 * *capability.noise_in_band_m, 1e6 * *capability.smallest_rms_10_percent_m,
        question.record_s);
  }
  return reason;
}

}  // namespace

Capability Judge(const SensorAbility& sensor, const CapabilityQuestion& question) {
  HAPTOMETER_CHECK(question.lower_hz >= 0 && question.lower_hz < question.upper_hz, "{} to {} Hz",
                   question.lower_hz, question.upper_hz);
  HAPTOMETER_CHECK(sensor.rate_hz > 0, "{}: rate_hz = {}", sensor.name, sensor.rate_hz);
  Capability capability{.sensor = sensor};
  capability.highest_hz = HighestObservableHz(sensor.rate_hz);
  capability.gain_lower = GainAt(sensor, question.lower_hz);
  capability.gain_upper = GainAt(sensor, question.upper_hz);
  AddNoise(question, &capability);
  capability.reason = Obstacle(capability, question);
  capability.can_answer = capability.reason.empty();
  if (capability.can_answer) capability.reason = Praise(capability, question);
  return capability;
}

std::vector<Capability> Judge(const std::vector<SensorAbility>& sensors,
                              const CapabilityQuestion& question) {
  std::vector<Capability> capabilities;
  capabilities.reserve(sensors.size());
  for (const SensorAbility& sensor : sensors) capabilities.push_back(Judge(sensor, question));
  std::ranges::sort(capabilities, [](const Capability& a, const Capability& b) {
    return std::tuple(!a.can_answer, -a.highest_hz, a.sensor.name) <
           std::tuple(!b.can_answer, -b.highest_hz, b.sensor.name);
  });
  return capabilities;
}

}  // namespace haptometer::acquire
