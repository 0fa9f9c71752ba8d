#include "sim/sensor_model.h"

#include <fmt/core.h>

#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "base/error.h"
#include "sim/effective_scene.h"
#include "sim/linear_model.h"
#include "sim/played_motion.h"
#include "sim/steady_state.h"
#include "sim/time_response.h"
#include "sim/waveforms.h"

namespace haptometer::sim {

trial::Displacement MotionOf(const Scene& stated, SensorTarget target) {
  EffectSet on;
  for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
    on[k] = stated.effects.wishes[k] != Wish::kOff;
  }
  const EffectiveScene effective = WithEffects(stated, on);
  const bool is_sine = effective.scene.drive.kind == DriveKind::kSine;
  const bool limited = effective.piecewise.stops || effective.piecewise.contact_loss;
  const bool is_plain = effective.scene.drive.offset_v == 0 && !effective.scene.initial.Any();
  if (!is_sine || !is_plain || limited || !effective.IsLinear() ||
      !effective.scene.finger.tones.empty()) {
    Beginning beginning = BeginningOf(effective);
    return PlayedMotion(effective, std::move(beginning.start), target,
                        beginning.temperature_rise_k);
  }
  const Scene& scene = effective.scene;
  const LinearModel model = AssembleModel(scene);
  const Eigen::Index state = StateOf(model, target);
  // steady: Im(X exp(j w t)) as one sine
  if (StartOf(scene) == Start::kSteady) {
    const std::complex<double> phasor =
        SolveSteadyState(model, scene.drive, scene.skin).phasors(state);
    return [amplitude_m = std::abs(phasor), phase_rad = std::arg(phasor),
            frequency_hz = scene.drive.frequency_hz](double t_s) {
      // whole cycles leave before the sine sees the rest, so that it does not grow coarse with time
      const long double cycles =
          static_cast<long double>(frequency_hz) * static_cast<long double>(t_s);
      const auto part = static_cast<double>(cycles - std::nearbyint(cycles));
      return amplitude_m * std::sin(2 * std::numbers::pi * part + phase_rad);
    };
  }
  // shared, because a std::function is copied freely
  auto response = std::make_shared<const TimeResponse>(model, scene.drive, Start::kRest);
  return [response = std::move(response), state](double t_s) {
    return t_s <= 0 ? 0.0 : response->StateAt(t_s)(state);
  };
}

trial::Displacement SensedMotion(const Scene& scene) {
  HAPTOMETER_CHECK(scene.sensor.has_value(), "the scene has no sensor");
  trial::Displacement motion = MotionOf(scene, scene.sensor->target);
  const double latency_s = scene.sensor->latency_s;
  if (latency_s == 0) return motion;
  return [motion = std::move(motion), latency_s](double t_s) { return motion(t_s - latency_s); };
}

namespace {

trial::Metadata Describe(const Scene& scene) {
  const Sensor& sensor = *scene.sensor;
  trial::Metadata metadata;
  const Effects& effects = scene.effects;
  const bool smooth =
      effects[Effect::kStiffening] != Wish::kOff || effects[Effect::kCoilHeating] != Wish::kOff;
  metadata.source = fmt::format("simulated: {}, {}, start from {}",
                                effects.Asked() ? "scene with effects" : "linear scene",
                                smooth ? "SUNDIALS CVODES" : "exact solution",
                                StartOf(scene) == Start::kRest ? "rest" : "steady state");
  metadata.sensor = "sensor model";
  metadata.head = sensor.head.name;
  metadata.sampling_s = sensor.head.sampling_s;
  metadata.averages = sensor.head.averages;
  metadata.hold = "sample";
  metadata.nominal_rate_hz = sensor.rate_hz;
  metadata.laser_spot = Name(sensor.target);
  if (scene.drive.kind == DriveKind::kSine || scene.drive.kind == DriveKind::kBurst) {
    metadata.drive_frequency_hz = scene.drive.frequency_hz;
  }
  metadata.drive_amplitude_v = LargestVoltageV(scene.drive);
  return metadata;
}

}  // namespace

std::int64_t SamplesPerReading(const Sensor& sensor) {
  return std::llround(1 / (sensor.rate_hz * sensor.head.sampling_s));
}

trial::Record SimulateRecord(const Scene& scene, double duration_s) {
  HAPTOMETER_CHECK(scene.sensor.has_value(), "the scene has no sensor");
  const Sensor& sensor = *scene.sensor;
  const auto rows = static_cast<std::size_t>(std::floor(duration_s * sensor.rate_hz * (1 + 1e-12)));
  HAPTOMETER_CHECK(rows >= 1, "{} s at {} Hz", duration_s, sensor.rate_hz);
  const std::int64_t stride = SamplesPerReading(sensor);

  trial::Channel channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.range_min = sensor.head.range_min_m;
  channel.range_max = sensor.head.range_max_m;
  channel.resolution = sensor.head.resolution_m;
  const trial::Displacement motion = SensedMotion(scene);
  for (std::size_t row = 0; row < rows; ++row) {
    const trial::HeadReading reading =
        trial::ReadingAt(sensor.head, motion, static_cast<std::int64_t>(row) * stride, sensor.seed);
    const bool measured = trial::IsMeasurement(reading.status);
    channel.values.push_back(measured ? reading.value_m : std::numeric_limits<double>::quiet_NaN());
    channel.statuses.push_back(reading.status);
  }

  trial::Record record;
  record.rows = rows;
  record.channels.push_back(std::move(channel));
  record.stretches.push_back(
      {.first_row = 0, .rows = rows, .start_s = 0, .rate_hz = sensor.rate_hz});
  record.metadata = Describe(scene);
  return record;
}

}  // namespace haptometer::sim
