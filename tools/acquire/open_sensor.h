#pragma once

#include <memory>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/acquire/options/sensor_options.h"

namespace haptometer::tools {

/// Opens the sensor's port and joins it to its protocol; says nothing to the device yet
/// (Sensor::Start does). `wanted` has passed CheckSensor(); `clock` must outlive the sensor.
///
/// May be called again after the sensor was lost: nothing is kept between calls.
/// Errors: Cause::kUsage for a setting that the sensor does not have, Cause::kCannotAnswer for a
/// port that is none, is not there or is in use.
[[nodiscard]] Result<std::unique_ptr<acquire::Sensor>> OpenSensor(const SensorOptions& wanted,
                                                                  Clock& clock);

}  // namespace haptometer::tools
