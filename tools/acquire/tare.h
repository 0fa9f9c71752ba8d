#pragma once

#include <atomic>
#include <string>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/result.h"

namespace haptometer::tools {

/// The mean of the first displacement channel over the second before the recording, in m; values
/// that are no measurements do not count. The counts of a recording are not touched by it.
///
/// `sensor` is started and has not begun; it is left where Sensor::Begin may be called again, with
/// nothing outstanding. Returns early when `stop` is set. Takes a second, at most three. `name`
/// stands in errors (Cause::kCannotAnswer: no such channel, no measurement came; Cause::kFailed:
/// the connection was lost).
[[nodiscard]] Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock,
                                         const std::atomic<bool>& stop, const std::string& name);

}  // namespace haptometer::tools
