#pragma once

#include <optional>
#include <string>

#include "base/quantity.h"
#include "base/result.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// Which sensor, and how it is spoken to: what the command line or a daemon's file says of it.
struct SensorOptions {
  std::string port;
  std::string sensor = "keyence-il";
  std::string format;
  std::string profile;
  std::optional<std::int64_t> slave;
  std::optional<Quantity> poll_rate_hz;
  std::optional<std::int64_t> baud;
  std::optional<Quantity> refresh_s;
};

/// Declares the options that name a sensor.
void DeclareSensor(cli::Options& options, SensorOptions& wanted);

/// What is wrong with them, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckSensor(const SensorOptions& wanted);

}  // namespace haptometer::tools
