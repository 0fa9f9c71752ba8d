#include "tools/acquire/options/recording_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "tools/acquire/options/wall_time.h"
#include "tools/acquire/sensor_kind.h"
#include "tools/acquire/trial_name.h"
#include "tools/cli/key_values.h"
#include "tools/cli/output_file.h"
#include "tools/longest_time.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

// a time of up to 30 years
Result<MonotonicNs> ReadTime(const std::string& option, const Quantity& time_s,
                             const std::string& remedy) {
  if (NsFromSeconds(std::min(time_s.value, kLongestTimeS)) < 1) {
    return Usage(option, "must be above 0", "write e.g. 10s");
  }
  if (time_s.value > kLongestTimeS) return Usage(option, "is beyond 30 years", remedy);
  return NsFromSeconds(time_s.value);
}

Result<void> PlanEnd(const RecordingOptions& wanted, std::time_t now, RecordingPlan& plan) {
  if (wanted.duration_s) {
    const auto time =
        ReadTime("--duration", *wanted.duration_s, "leave it out to record until Ctrl-C");
    if (!time) return std::unexpected(time.error());
    plan.limits.duration_ns = *time;
  }
  if (wanted.samples) plan.limits.readings = static_cast<std::uint64_t>(*wanted.samples);
  if (wanted.until.empty()) return {};
  const auto until = ParseUntil(wanted.until, now);
  if (!until) return std::unexpected(until.error());
  plan.until = *until;
  return {};
}

Result<void> PlanTrigger(const RecordingOptions& wanted, RecordingPlan& plan) {
  if (wanted.trigger.empty()) {
    const char* alone = wanted.pre_samples  ? "--pre-samples"
                        : wanted.hold_off_s ? "--hold-off"
                        : wanted.shots      ? "--shots"
                                            : nullptr;
    if (alone == nullptr) return {};
    return Usage(alone, "is part of a trigger", "add e.g. --trigger 'rising 0.1mm'");
  }
  auto wish = ParseTrigger(wanted.trigger);
  if (!wish) return std::unexpected(wish.error());
  plan.trigger = std::move(*wish);
  plan.pre_samples = static_cast<std::size_t>(wanted.pre_samples.value_or(0));
  plan.shots = static_cast<std::uint64_t>(wanted.shots.value_or(1));
  if (wanted.hold_off_s) {
    const auto time = ReadTime("--hold-off", *wanted.hold_off_s, "write e.g. 1s");
    if (!time) return std::unexpected(time.error());
    plan.hold_off_ns = *time;
  }
  if (plan.shots > 1 && !wanted.duration_s && !wanted.samples) {
    return Usage("--shots", "needs an end for each shot", "add --duration or --samples");
  }
  return {};
}

Result<void> PlanReconnection(const RecordingOptions& wanted, const SensorOptions& sensor,
                              RecordingPlan& plan) {
  if (wanted.reconnect.empty()) return {};
  const SensorKind* kind = FindSensorKind(sensor.sensor);
  if (kind != nullptr && kind->ends_by_itself) {
    return Usage("--reconnect",
                 fmt::format("a {} cannot come back", sensor.is_scene() ? "scene" : kind->name),
                 "leave it out");
  }
  plan.reconnects = true;
  if (wanted.reconnect == "forever") return {};
  const auto quantity = ParseQuantity(wanted.reconnect, Dimension::kTime, "--reconnect");
  if (!quantity) return std::unexpected(quantity.error());
  const auto time = ReadTime("--reconnect", *quantity, "say forever");
  if (!time) return std::unexpected(time.error());
  plan.longest_away_ns = *time;
  return {};
}

}  // namespace

void DeclareRecording(cli::Options& options, RecordingOptions& wanted) {
  options.Output("-o,--output", &wanted.output, "FILE|DIR/",
                 "The trial to write; a directory names it by start, sensor and labels");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime,
                 "Stop after this time (with a trigger: each shot's)");
  options.Count("--samples", &wanted.samples, 1, std::int64_t{1} << 53,
                "Stop after this many readings (with a trigger: each shot's)");
  options.Text("--until", &wanted.until, "HH:MM[:SS]",
               "Stop at this local time; also YYYY-MM-DDTHH:MM[:SS]");
  options.Text("--trigger", &wanted.trigger, "[CHANNEL] KIND VALUE",
               "Record from here on: 'rising 0.1mm', 'voltage above 1V'; KIND is above, below, "
               "rising or falling");
  options.Count("--pre-samples", &wanted.pre_samples, 0, 1'000'000,
                "Readings kept from before each trigger", cli::Shown::kHelpAll);
  options.Number("--hold-off", &wanted.hold_off_s, Dimension::kTime,
                 "Least time from one trigger to the next", cli::Shown::kHelpAll);
  options.Count("--shots", &wanted.shots, 1, std::int64_t{1} << 53,
                "How many triggers are answered (1)", cli::Shown::kHelpAll);
  options.Text("--reconnect", &wanted.reconnect, "TIME|forever",
               "Wait so long for a device that went away, and go on");
  options.Flag("--tare", &wanted.tare,
               "Keep the mean of the second before the recording as its zero; readings stay as "
               "sent");
  options.Repeated("--label", &wanted.labels, "KEY=VALUE", "Kept with the trial; may be repeated");
  options.Flag("--overwrite,--force", &wanted.overwrite, "Replace an existing trial");
}

Result<RecordingPlan> PlanRecording(const RecordingOptions& wanted, const SensorOptions& sensor,
                                    std::time_t now) {
  RecordingPlan plan;
  auto labels = cli::ReadKeyValues(wanted.labels, "--label");
  if (!labels) return std::unexpected(labels.error());
  plan.labels = std::move(*labels);
  if (auto planned = PlanEnd(wanted, now, plan); !planned) return std::unexpected(planned.error());
  if (auto planned = PlanTrigger(wanted, plan); !planned) return std::unexpected(planned.error());
  if (auto planned = PlanReconnection(wanted, sensor, plan); !planned) {
    return std::unexpected(planned.error());
  }
  if (wanted.tare && IsSensor(sensor.sensor, SensorType::kReplay)) {
    return Usage("--tare", "a replay has the zero of its recording", "leave it out");
  }
  return plan;
}

Result<void> CheckOutput(const RecordingOptions& wanted) {
  const std::string& output = wanted.output;
  std::error_code error;
  if (IsDirectoryName(output)) {
    if (!fs::is_directory(output, error)) {
      return Usage(output, "is a directory that does not exist", "make it, or name another");
    }
    if (wanted.overwrite) {
      return Usage("--overwrite", "replaces nothing in a directory: each trial gets a new name",
                   "leave it out, or name a file");
    }
    return {};
  }
  return cli::CheckOutput(output, cli::kTrialOutput, wanted.overwrite);
}

Result<acquire::RecordingLimits> LimitsOf(const RecordingPlan& plan,
                                          const trial::TrialHeader& header, Clock& clock) {
  acquire::RecordingLimits limits = plan.limits;
  if (plan.until) {
    const std::chrono::duration<double> left_s =
        std::chrono::system_clock::from_time_t(*plan.until) - std::chrono::system_clock::now();
    limits.until_ns = clock.Now() + NsFromSeconds(left_s.count());
  }
  if (!plan.trigger) return limits;
  auto trigger = ResolveTrigger(*plan.trigger, header);
  if (!trigger) return std::unexpected(trigger.error());
  trigger->pre_samples = plan.pre_samples;
  trigger->hold_off_ns = plan.hold_off_ns;
  trigger->shots = plan.shots;
  limits.trigger = *trigger;
  return limits;
}

}  // namespace haptometer::tools
