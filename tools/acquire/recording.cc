#include "tools/acquire/recording.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "base/mapped.h"
#include "tools/cli/output_file.h"
#include "tools/cli/shared_options.h"
#include "trial/record.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr cli::Bounds kTimes{.least = 0, .most = kLongestTimeS, .is_above = true};

// a time above 0 in ns, one at least
MonotonicNs NsOf(double time_s) { return std::max<MonotonicNs>(NsFromSeconds(time_s), 1); }

// --duration and --samples become limits; --until stays a wall time until the recording begins
Result<void> PlanEnd(const RecordingOptions& wanted, std::time_t now, RecordingPlan& plan) {
  if (wanted.duration_s) plan.limits.duration_ns = NsOf(*wanted.duration_s);
  if (wanted.samples) plan.limits.readings = static_cast<std::uint64_t>(*wanted.samples);
  if (wanted.until.empty()) return {};
  HAPTOMETER_LET(plan.until, ParseUntil(wanted.until, now));
  return {};
}

// the trigger as text: its channel and unit are resolved once the sensor's header is known
Result<void> PlanTrigger(const RecordingOptions& wanted, RecordingPlan& plan) {
  const bool is_none = wanted.trigger.empty();
  constexpr std::string_view kIsPart = "is part of a trigger";
  constexpr std::string_view kAdd = "add e.g. --trigger 'rising 0.1mm'";
  HAPTOMETER_TRY(cli::CheckRules({
      // options that have a meaning with a trigger only
      {is_none && wanted.pre_samples, "--pre-samples", kIsPart, kAdd},
      {is_none && wanted.hold_off_s, "--hold-off", kIsPart, kAdd},
      {is_none && wanted.shots, "--shots", kIsPart, kAdd},
      // without an end of its own the first shot would last until Ctrl-C
      {wanted.shots.value_or(1) > 1 && !wanted.duration_s && !wanted.samples, "--shots",
       "needs an end for each shot", "add --duration or --samples"},
  }));
  if (is_none) return {};
  HAPTOMETER_LET(plan.trigger, ParseTrigger(wanted.trigger));
  acquire::TriggerSetup& setup = plan.trigger->setup;
  setup.pre_samples = static_cast<std::size_t>(wanted.pre_samples.value_or(0));
  setup.shots = static_cast<std::uint64_t>(wanted.shots.value_or(1));
  if (wanted.hold_off_s) setup.hold_off_ns = NsOf(*wanted.hold_off_s);
  return {};
}

// whether, and for how long, a disconnected device is waited for
Result<void> PlanReconnection(const RecordingOptions& wanted, const SensorOptions& sensor,
                              RecordingPlan& plan) {
  if (wanted.reconnect.empty()) return {};
  // a replay, a scene or a pipe has an end and no device that can return
  const SensorKind* kind = FindSensorKind(sensor.sensor);
  if (kind != nullptr && kind->ends_by_itself) {
    return Usage("--reconnect",
                 fmt::format("a {} cannot come back", sensor.is_scene() ? "scene" : kind->name),
                 "leave it out");
  }
  plan.reconnects = true;
  if (wanted.reconnect == "forever") return {};
  HAPTOMETER_LET(const auto quantity,
                 ParseQuantity(wanted.reconnect, Dimension::kTime, "--reconnect"));
  if (!(quantity.exact() && quantity.value > 0 && quantity.value <= kLongestTimeS)) {
    return Usage("--reconnect", "must be an exact time, above 0 and at most 30 years",
                 "write e.g. 10s, or forever");
  }
  plan.longest_away_ns = NsOf(quantity.value);
  return {};
}

using acquire::TriggerKind;

// the kinds of a trigger, by their names in --trigger
constexpr std::array kKinds = {TriggerKind::kAbove, TriggerKind::kBelow, TriggerKind::kRising,
                               TriggerKind::kFalling};
constexpr std::string_view kOption = "--trigger";
constexpr std::string_view kExample = "write e.g. 'rising 0.1mm' or 'voltage rising 1V'";

std::optional<TriggerKind> KindOf(const std::string& word) {
  const auto found =
      std::ranges::find_if(kKinds, [&](TriggerKind kind) { return Name(kind) == word; });
  return found == kKinds.end() ? std::nullopt : std::optional(*found);
}

// the dimension whose SI unit is `unit`; kNone for a unit without quantities (counts, "")
Dimension DimensionOf(const std::string& unit) {
  for (const Dimension dimension : {Dimension::kLength, Dimension::kVoltage, Dimension::kCurrent}) {
    if (SiUnit(dimension) == unit) return dimension;
  }
  return Dimension::kNone;
}

// whether the threshold is a quantity of any channel's dimension, before the channel is known
Result<void> CheckQuantity(const std::string& text) {
  // length last: its error is the one returned, as a displacement is the usual channel
  Result<Quantity> last;
  for (const Dimension dimension :
       {Dimension::kVoltage, Dimension::kCurrent, Dimension::kNone, Dimension::kLength}) {
    last = ParseQuantity(text, dimension, kOption);
    if (last) return {};
  }
  return std::unexpected(last.error());
}

// the whole of `text` by one strptime format, fields that it does not set as in `start`
std::optional<std::tm> Read(const std::string& text, const char* picture, const std::tm& start) {
  std::tm time = start;
  const char* end = strptime(text.c_str(), picture, &time);
  if (end == nullptr || *end != '\0') return std::nullopt;
  return time;
}

// the instant; empty for a time that does not exist (30 February, an hour skipped by summer time)
std::optional<std::time_t> Instant(std::tm wall) {
  const std::tm asked = wall;
  // -1: mktime determines whether summer time applies
  wall.tm_isdst = -1;
  const std::time_t instant = std::mktime(&wall);
  // mktime normalises a time that does not exist into another one: a changed field reveals it
  const bool exists = wall.tm_mday == asked.tm_mday && wall.tm_hour == asked.tm_hour &&
                      wall.tm_min == asked.tm_min && wall.tm_sec == asked.tm_sec;
  if (instant == -1 || !exists) return std::nullopt;
  return instant;
}

// the same wall time of the next day; by way of noon, which no change to summer time skips
std::tm DayAfter(const std::tm& wall) {
  std::tm day = wall;
  ++day.tm_mday;
  day.tm_hour = 12;
  day.tm_isdst = -1;
  (void)std::mktime(&day);
  day.tm_hour = wall.tm_hour;
  day.tm_min = wall.tm_min;
  day.tm_sec = wall.tm_sec;
  return day;
}

std::unexpected<Error> NoSuchTime(const std::string& text) {
  return Usage("--until", fmt::format("'{}' is a time that the calendar here does not have", text),
               "write e.g. 17:30 or 2026-03-01T17:30");
}

constexpr std::size_t kLongestStem = 200;  // file systems take 255 bytes

// letters, digits, '.' and '-' are kept, other bytes become '_': no '/' can enter a file's name
std::string Plain(std::string text) {
  std::ranges::replace_if(
      text,
      [](char c) {
        const bool is_plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                              (c >= 'A' && c <= 'Z') || c == '.' || c == '-';
        return !is_plain;
      },
      '_');
  return text;
}

// a check keeps nothing, and ends by --duration alone
Result<void> CheckAlone(const AcquireOptions& wanted) {
  const RecordingOptions& recording = wanted.recording;
  const char* other = !recording.output.empty()      ? "-o"
                      : wanted.live                  ? "--live"
                      : recording.samples            ? "--samples"
                      : !recording.until.empty()     ? "--until"
                      : !recording.trigger.empty()   ? "--trigger"
                      : !recording.reconnect.empty() ? "--reconnect"
                      : recording.tare               ? "--tare"
                                                     : nullptr;
  if (other == nullptr) return {};
  return Usage("--check", fmt::format("keeps nothing and has no use for {}", other),
               "check first, then record");
}

}  // namespace

void DeclareRecording(cli::Options& options, RecordingOptions& wanted) {
  options.Output("-o,--output", &wanted.output, "FILE|DIR/",
                 "The trial to write; a directory names it by start, sensor and labels");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime, kTimes,
                 "Stop after this time, with a trigger after this time of each shot");
  options.Count("--samples", &wanted.samples, 1, std::int64_t{1} << 53,
                "Stop after this many readings, with a trigger after this many of each shot");
  options.Text("--until", &wanted.until, "HH:MM[:SS]",
               "Stop at this local time; also YYYY-MM-DDTHH:MM[:SS]");
  options.Text("--trigger", &wanted.trigger, "[CHANNEL] KIND VALUE",
               "Record from here on: 'rising 0.1mm', 'voltage above 1V'; KIND is above, below, "
               "rising or falling");
  options.Count("--pre-samples", &wanted.pre_samples, 0, 1'000'000,
                "Number of readings stored from before each trigger", cli::Shown::kHelpAll);
  options.Number("--hold-off", &wanted.hold_off_s, Dimension::kTime, kTimes,
                 "Least time from one trigger to the next", cli::Shown::kHelpAll);
  options
      .Count("--shots", &wanted.shots, 1, std::int64_t{1} << 53, "Number of triggers to record",
             cli::Shown::kHelpAll)
      .Default("1");
  options.Text("--reconnect", &wanted.reconnect, "TIME|forever",
               "Wait up to this time for a disconnected device, and continue");
  options.Flag(
      "--tare", &wanted.tare,
      "Store the mean of the second before the recording as its zero; readings are not changed");
  options.Repeated("--label", &wanted.labels, "KEY=VALUE",
                   "Label to store with the trial; may be repeated");
  options.Flag("--overwrite,--force", &wanted.overwrite, "Replace an existing trial");
}

Result<RecordingPlan> PlanRecording(const RecordingOptions& wanted, const SensorOptions& sensor,
                                    std::time_t now) {
  RecordingPlan plan;
  HAPTOMETER_LET(plan.labels, cli::ReadKeyValues(wanted.labels, "--label", "subject=3"));
  HAPTOMETER_TRY(PlanEnd(wanted, now, plan));
  HAPTOMETER_TRY(PlanTrigger(wanted, plan));
  HAPTOMETER_TRY(PlanReconnection(wanted, sensor, plan));
  // no second exists before the first row of a replay, which has the tare of its recording
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
    // each trial in a directory gets a new name, so nothing there is replaced
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
    // wall time to go, added to the monotonic clock: later steps of the wall clock have no effect
    const std::chrono::duration<double> left_s =
        std::chrono::system_clock::from_time_t(*plan.until) - std::chrono::system_clock::now();
    limits.until_ns = clock.Now() + NsFromSeconds(left_s.count());
  }
  if (!plan.trigger) return limits;
  HAPTOMETER_LET(limits.trigger, ResolveTrigger(*plan.trigger, header));
  return limits;
}

Result<TriggerWish> ParseTrigger(const std::string& text) {
  // the first word that is a kind divides channel (words before) and threshold (words behind)
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  const auto kind =
      std::ranges::find_if(words, [](const std::string& word) { return KindOf(word).has_value(); });
  if (kind == words.end() || kind + 1 == words.end()) {
    return Usage(std::string(kOption),
                 fmt::format("'{}' is not [CHANNEL] above|below|rising|falling VALUE", text),
                 std::string(kExample));
  }
  TriggerWish wish{.channel = fmt::format("{}", fmt::join(words.begin(), kind, " ")),
                   .threshold = fmt::format("{}", fmt::join(kind + 1, words.end(), " ")),
                   .setup = {.kind = *KindOf(*kind)}};
  HAPTOMETER_TRY(CheckQuantity(wish.threshold));
  return wish;
}

Result<acquire::TriggerSetup> ResolveTrigger(const TriggerWish& wish,
                                             const trial::TrialHeader& header) {
  // channel by name, or by default the first displacement (else the first channel)
  const auto displacement = trial::DisplacementChannel(header);
  std::size_t number = displacement.value_or(0);
  if (!wish.channel.empty()) {
    const auto found =
        std::ranges::find(header.channels, wish.channel, &trial::ChannelFormat::name);
    if (found == header.channels.end()) {
      const auto names = Mapped(header.channels, &trial::ChannelFormat::name);
      return Usage(std::string(kOption), fmt::format("there is no channel '{}'", wish.channel),
                   fmt::format("the sensor has {}", fmt::join(names, ", ")));
    }
    number = static_cast<std::size_t>(found - header.channels.begin());
  }

  // threshold in the channel's SI unit
  const trial::ChannelFormat& channel = header.channels[number];
  HAPTOMETER_LET(const auto threshold,
                 ParseQuantity(wish.threshold, DimensionOf(channel.unit), kOption));
  acquire::TriggerSetup setup = wish.setup;
  setup.channel = number;
  setup.threshold = threshold.value;
  // a displacement's threshold counts from the tare, which the recorded values still contain
  if (displacement == number) setup.threshold += header.metadata.tare_m;
  return setup;
}

Result<std::time_t> ParseUntil(const std::string& text, std::time_t now) {
  // a time of day: today, or tomorrow where it has passed
  std::tm today{};
  localtime_r(&now, &today);
  // "17:30" means 17:30:00, not the present second
  today.tm_sec = 0;
  for (const char* picture : {"%H:%M", "%H:%M:%S"}) {
    const auto wall = Read(text, picture, today);
    if (!wall) continue;
    auto instant = Instant(*wall);
    // passed, or skipped today by a change to summer time: the same time tomorrow
    if (!instant || *instant <= now) instant = Instant(DayAfter(*wall));
    if (!instant) return NoSuchTime(text);
    return *instant;
  }
  // date and time: it must lie ahead, by at most 30 years
  for (const char* picture : {"%Y-%m-%dT%H:%M", "%Y-%m-%dT%H:%M:%S"}) {
    const auto wall = Read(text, picture, std::tm{});
    if (!wall) continue;
    const auto instant = Instant(*wall);
    if (!instant) return NoSuchTime(text);
    if (*instant <= now) {
      return Usage("--until", fmt::format("'{}' has passed", text), "give a time that is to come");
    }
    if (std::difftime(*instant, now) > kLongestTimeS) {
      return Usage("--until", fmt::format("'{}' is beyond 30 years", text),
                   "leave it out to record until Ctrl-C");
    }
    return *instant;
  }
  return Usage("--until", fmt::format("'{}' is not a time of day", text),
               "write HH:MM, HH:MM:SS or YYYY-MM-DDTHH:MM, in local time");
}

bool IsDirectoryName(const std::string& output) {
  std::error_code ignored;
  return output.ends_with('/') || fs::is_directory(output, ignored);
}

std::string NewTrialName(const std::string& directory, const std::string& utc_start,
                         const std::string& sensor,
                         const std::map<std::string, std::string>& labels) {
  std::string stem = CompactUtc(utc_start) + "_" + Plain(sensor);
  for (const auto& [key, value] : labels) stem += "_" + Plain(key) + "-" + Plain(value);
  stem.resize(std::min(stem.size(), kLongestStem));
  return FirstFreePath((fs::path(directory) / (stem + ".bin")).string(), '_');
}

std::string CompactUtc(std::string_view utc) {
  std::string text(utc.substr(0, utc.find('.')));
  // "2026-03-01T12:00:00.123Z" without fraction and separators: "20260301T120000"
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  return text + "Z";
}

std::string FirstFreePath(const std::string& path, char separator) {
  namespace fs = std::filesystem;
  const fs::path wanted(path);
  fs::path free = wanted;
  std::error_code ignored;
  // symlink_status: a dangling link occupies its name too
  for (int number = 2; fs::exists(fs::symlink_status(free, ignored)); ++number) {
    free = wanted.parent_path() / fmt::format("{}{}{}{}", wanted.stem().string(), separator, number,
                                              wanted.extension().string());
  }
  return free.string();
}

void DeclareAcquire(cli::Options& options, AcquireOptions& wanted) {
  DeclareSensor(options, wanted.sensor);
  DeclareRecording(options, wanted.recording);
  options.Flag("--live", &wanted.live,
               "Show level, band RMS and a plot; without -o nothing is kept");
  options.Flag("--check", &wanted.check,
               "Check for 10 s (--duration) whether the sensor is ready, and list what to correct");
  options.Number("--smallest-rms", &wanted.smallest_rms_m, Dimension::kLength, cli::Above(0),
                 "RMS that --check requires to be reportable to 10 %", cli::Shown::kHelpAll);
  options.Flag("--list-ports", &wanted.list_ports, "List the serial ports, and record nothing");
  options.Flag("--list-sensors", &wanted.list_sensors,
               "List which sensors meet --band and --resolution, and record nothing");
  options.Text("--band", &wanted.band, "LOWER-UPPERHz",
               "Band that --live, --check, --list-sensors and --advise examine");
  options
      .Number("--resolution", &wanted.resolution_m, Dimension::kLength, cli::Above(0),
              "Largest permitted step, for --list-sensors")
      .Default("1 um");
  DeclareAdvise(options, wanted.advise);
  DeclareDaemon(options, wanted.daemon);
  options.Flag("--all", &wanted.outputs.all, "Print all numbers and the provenance too");
  options.Output("--report", &wanted.outputs.report, "FILE.html",
                 "Write a page with what is printed, all numbers and the provenance",
                 cli::Shown::kHelpAll);
}

Result<dsp::BandPass> BandOf(const AcquireOptions& wanted) {
  HAPTOMETER_LET(const auto corners, cli::ParseBand(wanted.band));
  dsp::BandPass band;
  band.lower_hz = corners.lower_hz;
  band.upper_hz = corners.upper_hz;
  // at a rate of 4 f_upper each valid band has a design: the band is checked here, not the rate
  HAPTOMETER_TRY(dsp::DesignBandPass(band, 4 * band.upper_hz));
  return band;
}

Result<void> CheckAcquire(const AcquireOptions& wanted) {
  HAPTOMETER_TRY(CheckNotAdvised(wanted.advise));
  HAPTOMETER_TRY(CheckSensor(wanted.sensor));
  const bool has_output = !wanted.recording.output.empty();
  HAPTOMETER_TRY(cli::CheckRules({
      // a requirement on --check alone
      {wanted.smallest_rms_m && !wanted.check, "--smallest-rms", "is what a check asks for",
       "add --check"},
      // without -o a live view may run; without both there is nothing to do
      {!wanted.check && !has_output && !wanted.live, "-o", "is missing",
       "name the trial to write, e.g. -o trial.bin, or look with --live or --check"},
  }));
  if (wanted.check) return CheckAlone(wanted);
  return has_output ? CheckOutput(wanted.recording) : Result<void>{};
}

}  // namespace haptometer::tools
