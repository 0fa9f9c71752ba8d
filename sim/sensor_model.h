#pragma once

#include <cstdint>

#include "sim/scene/scene.h"
#include "trial/record.h"
#include "trial/sensor_head.h"

namespace haptometer::sim {

/// The displacement of `target` over time: a closed sine for Start::kSteady, the exact response
/// from rest otherwise (zero before t = 0); with stops or contact that breaks, named or "auto", and
/// under a drive that is no sine, a motion that is played and interpolated. About 0.1 us or 4 us a
/// call; threads may share it.
[[nodiscard]] trial::Displacement MotionOf(const Scene& scene, SensorTarget target);

/// The same as the scene's sensor sees it: its target, delayed by its latency. The scene must have
/// a sensor.
[[nodiscard]] trial::Displacement SensedMotion(const Scene& scene);

/// Raw samples between one reading and the next: 1 / (rate_hz * head.sampling_s).
[[nodiscard]] std::int64_t SamplesPerReading(const Sensor& sensor);

/// What the scene's sensor would hand out over `duration_s`: one displacement channel, one stretch,
/// row i at i / rate_hz. Metadata says "simulated" and names sensor, spot and drive. The scene must
/// have a sensor; duration_s * rate_hz >= 1.
[[nodiscard]] trial::Record SimulateRecord(const Scene& scene, double duration_s);

}  // namespace haptometer::sim
