#pragma once

#include <ctime>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "base/error.h"
#include "base/quantity.h"
#include "tools/acquire/options/sensor_options.h"
#include "tools/acquire/options/trigger_option.h"
#include "tools/cli/options.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What is wanted of a recording, beside its sensor: as the command line says it.
struct RecordingOptions {
  std::string output{};  ///< a file, or a directory that names it (trial_name.h); may be empty
  bool overwrite = false;
  std::vector<std::string> labels{};
  std::optional<std::int64_t> samples{};
  std::optional<Quantity> duration_s{};
  std::string until{};
  std::string trigger{};
  std::optional<std::int64_t> pre_samples{};
  std::optional<Quantity> hold_off_s{};
  std::optional<std::int64_t> shots{};
  std::string reconnect{};
  bool tare = false;
};

/// Declares the options of a recording.
void DeclareRecording(cli::Options& options, RecordingOptions& wanted);

/// The same, read and found to make sense.
struct RecordingPlan {
  std::map<std::string, std::string> labels;
  acquire::RecordingLimits limits;  ///< without trigger and until_ns
  std::optional<std::time_t> until;
  std::optional<TriggerWish> trigger;
  std::size_t pre_samples = 0;
  MonotonicNs hold_off_ns = 0;
  std::uint64_t shots = 1;
  bool reconnects = false;
  std::optional<MonotonicNs> longest_away_ns;  ///< empty: for ever
};

/// Reads the options, before anything is touched; `now` is the wall clock. Errors (Cause::kUsage):
/// whatever cannot be meant, or not together or with this sensor.
[[nodiscard]] Result<RecordingPlan> PlanRecording(const RecordingOptions& wanted,
                                                  const SensorOptions& sensor, std::time_t now);

/// Whether a trial can be written to wanted.output. Errors: as cli::CheckOutput; Cause::kUsage for
/// a directory that does not exist, or in which something is to be replaced.
[[nodiscard]] Result<void> CheckOutput(const RecordingOptions& wanted);

/// The recorder's limits, once the sensor is known: the trigger on its channels, and the wall's
/// time to come as an instant of `clock`. Errors: those of ResolveTrigger.
[[nodiscard]] Result<acquire::RecordingLimits> LimitsOf(const RecordingPlan& plan,
                                                        const trial::TrialHeader& header,
                                                        Clock& clock);

}  // namespace haptometer::tools
