#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/recorder/row_sink.h"
#include "base/error.h"
#include "base/toml.h"
#include "tools/acquire/sensor_options.h"

namespace haptometer::tools {

/// How the daemon names its trials: a pattern with {name} (the sensor's), {utc} (when the file was
/// begun, 20260301T120000Z) and {part} (0001, 0002, ... of one uninterrupted recording).
struct TrialPattern {
  std::string directory;
  std::string file = "{name}-{utc}-{part}.bin";
};

/// Errors (Cause::kUsage), naming `where`: empty, a directory in it, another brace, no {name} for
/// several `sensors`.
[[nodiscard]] Result<void> CheckPattern(std::string_view file, std::size_t sensors,
                                        std::string_view where);

/// The path of the next trial. `utc` is UtcNow()'s. Where a file of this name is there already (the
/// wall clock was set back), "-2", "-3", ... makes it another.
[[nodiscard]] std::string NextTrialPath(const TrialPattern& pattern, std::string_view name,
                                        std::string_view utc, std::uint64_t part);

/// One [[sensor]] of the daemon's file.
struct DaemonSensor {
  std::string name;  ///< of letters, digits, '_', '.' and '-'; no other sensor has it
  SensorOptions options;
  std::map<std::string, std::string> labels;  ///< the file's, and the sensor's own over them
};

/// What `acquire --daemon` is to do; docs/reference/daemon.md lists the keys.
struct DaemonConfig {
  TrialPattern trials;
  std::string socket;  ///< where it answers `acquire --status`; empty: DefaultStatusSockets()
  acquire::RotationLimits rotation;          ///< an hour, unless the file says otherwise
  double flush_s = 1;                        ///< how much a loss of power may cost
  std::uint64_t reserve_bytes = 64'000'000;  ///< of the disk that are left free
  std::vector<DaemonSensor> sensors;         ///< at least one
};

/// Reads a daemon's file. Errors: those of TomlTable::ParseFile, and Cause::kUsage for a key that
/// is unknown, missing or impossible.
[[nodiscard]] Result<DaemonConfig> ReadDaemonConfig(const std::string& path);

/// Reads a daemon's file from memory; `where` stands for its path.
[[nodiscard]] Result<DaemonConfig> ParseDaemonConfig(std::string_view text,
                                                     const std::string& where);

/// Reads the keys of a file that say the same of a sensor as acquire's options: `--refresh 7ms` is
/// `refresh_s = "7ms"`. What is wrong shows in the table's Finish(); what the sensor does not have,
/// in CheckSensor().
[[nodiscard]] SensorOptions ReadSensorKeys(TomlTable& table);

/// The names of all these keys.
[[nodiscard]] std::vector<std::string_view> SensorKeyNames();

}  // namespace haptometer::tools
