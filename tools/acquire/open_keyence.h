#pragma once

#include <memory>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/acquire/options/sensor_options.h"
#include "tools/acquire/sensor_kind.h"

namespace haptometer::tools {

/// What is wrong with --command, --decimals, --device-zero and --set for the sensor, which is one
/// of `kind`, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckKeyence(const SensorOptions& wanted, const SensorKind& kind);

/// As OpenSensor(), for a sensor whose kind is_keyence.
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenKeyence(const SensorOptions& wanted,
                                                                   Clock& clock);

}  // namespace haptometer::tools
