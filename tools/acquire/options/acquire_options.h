#pragma once

#include <optional>
#include <string>

#include "base/error.h"
#include "base/quantity.h"
#include "dsp/filter/butterworth.h"
#include "tools/acquire/options/recording_options.h"
#include "tools/acquire/options/sensor_options.h"
#include "tools/cli/options.h"
#include "tools/daemon/daemon_options.h"

namespace haptometer::tools {

/// The whole command line of acquire.
struct AcquireOptions {
  SensorOptions sensor;
  RecordingOptions recording;
  bool live = false;
  bool check = false;
  std::string band = "20-500Hz";
  std::optional<Quantity> smallest_rms_m;
  bool list_ports = false;
  bool list_sensors = false;
  std::optional<Quantity> resolution_m;
  DaemonOptions daemon;
};

/// Declares all its options.
void DeclareAcquire(cli::Options& options, AcquireOptions& wanted);

/// The band of --live and --check. Errors (Cause::kUsage): none, or none at any rate.
[[nodiscard]] Result<dsp::BandPass> BandOf(const AcquireOptions& wanted);

/// What is wrong with the command line, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckAcquire(const AcquireOptions& wanted);

}  // namespace haptometer::tools
