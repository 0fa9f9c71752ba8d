#pragma once

#include <ctime>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/recorder/trigger.h"
#include "acquire/sensor/sensor.h"
#include "base/band.h"
#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "tools/acquire/advise_document.h"
#include "tools/acquire/sensor_options.h"
#include "tools/cli/options.h"
#include "tools/daemon/daemon.h"
#include "tools/document/present.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// What `--trigger` says, before it is known which channels the sensor has.
struct TriggerWish {
  std::string channel;    ///< by name; empty: the first displacement, or else the first channel
  std::string threshold;  ///< as written: "0.1mm"
  acquire::TriggerSetup setup;  ///< without channel and threshold
};

/// Reads "[CHANNEL ]KIND VALUE": "rising 0.1mm", "voltage rising 1V"; KIND is above, below, rising
/// or falling, and a channel's name may hold spaces. Errors (Cause::kUsage, naming --trigger): no
/// kind, no value, a value that is a quantity of no channel.
[[nodiscard]] Result<TriggerWish> ParseTrigger(const std::string& text);

/// The trigger on the channels of `header`. The threshold of the first displacement channel counts
/// from header.metadata.tare_m.
/// Errors (Cause::kUsage): no such channel (with those there are), a unit that the channel does not
/// have.
[[nodiscard]] Result<acquire::TriggerSetup> ResolveTrigger(const TriggerWish& wish,
                                                           const trial::TrialHeader& header);

/// What is wanted of a recording, beside its sensor: as the command line says it.
struct RecordingOptions {
  std::string output{};  ///< a file, or a directory that names it (NewTrialName); may be empty
  bool overwrite = false;
  std::vector<std::string> labels{};
  std::optional<std::int64_t> samples{};
  std::optional<double> duration_s{};
  std::string until{};
  std::string trigger{};
  std::optional<std::int64_t> pre_samples{};
  std::optional<double> hold_off_s{};
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

/// The instant that `text` names in local time: "17:30", "17:30:15" (the next one after `now`), or
/// "2026-03-01T17:30[:15]" (after `now`). Wall clock: only the distance from `now` is meant to be
/// used, once, on a monotonic clock.
///
/// Across a change to or from summer time it is the wall's clock that counts; of an hour that comes
/// twice, the system's choice. Errors (Cause::kUsage, naming --until): another form, a time that
/// the calendar does not have, one that has passed or is beyond 30 years.
[[nodiscard]] Result<std::time_t> ParseUntil(const std::string& text, std::time_t now);

/// Whether `output` names a directory, in which trials get names of their own: it ends in '/', or
/// is one.
[[nodiscard]] bool IsDirectoryName(const std::string& output);

/// A file in `directory` that does not exist yet: UTC start, sensor and labels, such as
/// `20260301T120000Z_stream_condition-adapter_subject-3.bin`; behind a name that is taken stands
/// _2, _3 and so on. Of labels, characters other than letters, digits, '.' and '-' become '_', and
/// a name is cut at 200 characters.
///
/// `utc_start` is as UtcNow() gives it.
[[nodiscard]] std::string NewTrialName(const std::string& directory, const std::string& utc_start,
                                       const std::string& sensor,
                                       const std::map<std::string, std::string>& labels);

/// An instant as UtcNow() gives it, for a file's name: 2026-03-01T12:00:00.123Z as
/// 20260301T120000Z.
[[nodiscard]] std::string CompactUtc(std::string_view utc);

/// `path`, or where something of this name is there already, the first of `STEM<separator>2.EXT`,
/// `STEM<separator>3.EXT`, ... that is not.
[[nodiscard]] std::string FirstFreePath(const std::string& path, char separator);

/// The whole command line of acquire.
struct AcquireOptions {
  SensorOptions sensor;
  RecordingOptions recording;
  bool live = false;
  bool check = false;
  std::string band{kDefaultBand};
  std::optional<double> smallest_rms_m;
  bool list_ports = false;
  bool list_sensors = false;
  std::optional<double> resolution_m;
  AdviseWords advise;
  DaemonOptions daemon;
  document::Outputs outputs;
};

/// Declares all its options.
void DeclareAcquire(cli::Options& options, AcquireOptions& wanted);

/// The band of --live and --check. Errors (Cause::kUsage): none, or none at any rate.
[[nodiscard]] Result<dsp::BandPass> BandOf(const AcquireOptions& wanted);

/// What is wrong with the command line, before anything is touched. Errors (Cause::kUsage).
[[nodiscard]] Result<void> CheckAcquire(const AcquireOptions& wanted);

/// What a recording begins with: what the sensor (started) says, on which host and when it was made
/// and by which command, and its labels. A replay keeps the host and time of its trial.
[[nodiscard]] trial::TrialHeader RecordingHeader(const acquire::Sensor& sensor, bool is_replay,
                                                 const std::map<std::string, std::string>& labels,
                                                 std::string command_line);

/// What a sensor finds: "amplifier 01: the amplifier holds (peak): ...".
[[nodiscard]] std::string InWords(const acquire::Finding& found);

/// The value of `sample` in the channel's unit: raw * scale + offset.
[[nodiscard]] inline double ValueOf(const trial::ChannelFormat& channel,
                                    const trial::Sample& sample) {
  return sample.raw.Number(channel.encoding) * channel.scale + channel.offset;
}

/// The longest time in s that may be asked for, some 30 years: it still fits in nanoseconds.
inline constexpr double kLongestTimeS = 1e9;

}  // namespace haptometer::tools
