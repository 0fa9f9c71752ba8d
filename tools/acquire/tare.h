#pragma once

#include <atomic>
#include <string>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::tools {

/// The mean of the first displacement channel over the second before the recording, in m; values
/// that are no measurements do not count. The counts of a recording are not touched by it.
///
/// `sensor` is started and has not begun; it is left where Sensor::Begin may be called again, with
/// nothing outstanding. Of a uniform source the second is its own (rate_hz rows, whenever they
/// come, waited for up to 3 s each), of others the clock's, and 3 s where measurements are missing.
/// Returns early when `stop` is set. `name` stands in errors (Cause::kCannotAnswer: no such
/// channel, no measurement came, the source ended or fell silent; Cause::kFailed: the connection
/// was lost, whether or not it would be waited for in a recording).
[[nodiscard]] Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock,
                                         const std::atomic<bool>& stop, const std::string& name);

}  // namespace haptometer::tools
