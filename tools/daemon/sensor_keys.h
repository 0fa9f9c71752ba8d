#pragma once

#include <string_view>
#include <vector>

#include "base/toml.h"
#include "tools/acquire/options/sensor_options.h"

namespace haptometer::tools {

/// Reads the keys of a file that say the same of a sensor as acquire's options: `--refresh 7ms` is
/// `refresh_s = "7ms"`. What is wrong shows in the table's Finish(); what the sensor does not have,
/// in CheckSensor().
[[nodiscard]] SensorOptions ReadSensorKeys(TomlTable& table);

/// The names of all these keys.
[[nodiscard]] std::vector<std::string_view> SensorKeyNames();

}  // namespace haptometer::tools
