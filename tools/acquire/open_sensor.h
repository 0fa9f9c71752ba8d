#pragma once

#include <memory>
#include <string>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/acquire/sensor_options.h"

namespace haptometer::tools {

/// Opens the sensor's port and joins it to its protocol; says nothing to the device yet
/// (Sensor::Start does). `wanted` has passed CheckSensor(); `clock` must outlive the sensor.
///
/// May be called again after the sensor was lost: nothing is kept between calls.
/// Errors: Cause::kUsage for a setting that the sensor does not have, Cause::kCannotAnswer for a
/// port that is none, is not there or is in use.
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenSensor(const SensorOptions& wanted,
                                                                  Clock& clock);

/// What is wrong with --command, --decimals, --device-zero and --set for the sensor, which is one
/// of `kind`, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckKeyence(const SensorOptions& wanted, const SensorKind& kind);

/// As OpenSensor(), for a sensor whose kind is_keyence.
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenKeyence(const SensorOptions& wanted,
                                                                   Clock& clock);

/// The sensor of a scene, without a wire between: the rows that `simulate -o` writes, as fast as
/// they are asked for, up to the scene's duration, or without an end. Its trial says "simulated".
/// Each Begin() plays it from its start.
///
/// A scene without [sensor] gets an ideal one on the skin, with a remark.
/// Errors: those of ReadPlayedScene (tools/simulate/simulated_trial.h).
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenScene(const std::string& path);

}  // namespace haptometer::tools
