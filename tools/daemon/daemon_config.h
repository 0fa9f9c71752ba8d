#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/recorder/row_sink.h"
#include "base/error.h"
#include "tools/acquire/options/sensor_options.h"
#include "tools/daemon/trial_pattern.h"

namespace haptometer::tools {

/// One [[sensor]] of the daemon's file.
struct DaemonSensor {
  std::string name;  ///< of letters, digits, '_', '.' and '-'; no other sensor has it
  SensorOptions options;
  std::map<std::string, std::string> labels;  ///< the file's, and the sensor's own over them
};

/// What `acquire --daemon` is to do; docs/daemon.md lists the keys.
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

}  // namespace haptometer::tools
