#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/quantity.h"
#include "base/result.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// Which sensor, and how it is spoken to: what the command line or a daemon's file says of it.
struct SensorOptions {
  std::string port;
  std::string sensor = "keyence-il";
  std::string format;
  std::optional<std::int64_t> baud;
  std::optional<Quantity> refresh_s;
  std::string command;                   ///< keyence-*: "m0", "m1", "m2", "ms"; "": the usual
  std::optional<std::int64_t> decimals;  ///< keyence-en1, keyence-lkg
  bool device_zero = false;              ///< keyence-il, keyence-en1: changes the device
  std::optional<Quantity> rate_hz;       ///< of polls
  std::vector<std::string> settings;     ///< keyence-il, keyence-en1: KEY=VALUE; change the device
};

/// `wanted` without what would change the device once more: for a reconnection.
[[nodiscard]] SensorOptions WithoutChanges(SensorOptions wanted);

/// Declares the options that name a sensor.
void DeclareSensor(cli::Options& options, SensorOptions& wanted);

/// What is wrong with them, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckSensor(const SensorOptions& wanted);

}  // namespace haptometer::tools
