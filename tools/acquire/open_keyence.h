#pragma once

#include <memory>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/result.h"
#include "tools/acquire/sensor_options.h"

namespace haptometer::tools {

/// Whether `sensor` is one of keyence-en1, keyence-il, keyence-lkg.
[[nodiscard]] bool IsKeyence(const std::string& sensor);

/// What is wrong with --command, --decimals, --device-zero and --set for the sensor, before
/// anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckKeyence(const SensorOptions& wanted);

/// As OpenSensor(), for a sensor that IsKeyence().
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenKeyence(const SensorOptions& wanted,
                                                                   Clock& clock);

}  // namespace haptometer::tools
