#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/recorder/row_sink.h"
#include "acquire/sensor/reconnecting_sensor.h"
#include "acquire/transport/port_list.h"
#include "base/clock.h"
#include "base/text.h"
#include "tools/acquire/check.h"
#include "tools/acquire/live_view.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/recording_document.h"
#include "tools/acquire/sensor_options.h"
#include "tools/cli/options.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/daemon/daemon.h"
#include "tools/document/present.h"
#include "tools/study/alike_names.h"
#include "tools/verbs.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {

/// Discards rows: --live without -o shows figures and keeps none.
class KeepNothing final : public acquire::RowSink {
 public:
  [[nodiscard]] Result<void> Append(const trial::Row& /*row*/) override { return {}; }
  [[nodiscard]] Result<void> AddEvent(trial::Event /*event*/) override { return {}; }
  [[nodiscard]] Result<void> FlushIfDue() override { return {}; }
  [[nodiscard]] Result<void> Finish() override { return {}; }
};

// acquire: a sensor's readings become a trial.
namespace {

using acquire::Sensor;

constexpr std::string_view kVerb = "acquire";
constexpr int kOutputClosed = 128 + SIGPIPE;  // as a shell reports SIGPIPE: output closed

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Record a distance sensor's readings into a trial.",
    .examples = {"acquire --port /dev/ttyUSB0 -o trial.bin",
                 "acquire --port /dev/ttyUSB0 --baud 38400 --duration 10s --label subject=3 "
                 "--label condition=adapter -o trial.bin",
                 "acquire --port /dev/ttyUSB1 --sensor stream --baud 921600 "
                 "--format +00.0000,mm,CR --samples 30000 -o trial.bin"}};

// a sensor that is opened again after it is lost, where --reconnect asks for it
Result<std::unique_ptr<Sensor>> Open(const SensorOptions& wanted, const RecordingPlan& plan,
                                     Clock& clock) {
  if (!plan.reconnects) return OpenSensor(wanted, clock);
  return std::make_unique<acquire::ReconnectingSensor>(
      [next = wanted, &clock]() mutable {
        auto opened = OpenSensor(next, clock);
        // settings of the device and its zero are written once, not at each reconnection
        next = WithoutChanges(next);
        return opened;
      },
      plan.longest_away_ns, clock);
}

// remarks on the findings that are not in `said`; a recording may add some
void SayNew(const acquire::Findings& findings, std::vector<std::string>& said) {
  for (const acquire::Finding& found : findings.list()) {
    std::string words = InWords(found);
    if (std::ranges::find(said, words) != said.end()) continue;
    cli::Remark(kVerb, words);
    said.push_back(std::move(words));
  }
}

// the tare in m, where --tare is given
Result<std::optional<double>> Tare(Sensor& sensor, const AcquireOptions& wanted, Clock& clock) {
  if (!wanted.recording.tare) return std::nullopt;
  HAPTOMETER_LET(const auto tare_m,
                 MeasureTare(sensor, clock, cli::Interrupted(), PortName(wanted.sensor)));
  cli::Remark(kVerb, fmt::format("zero: {:.6g} mm, the mean of the second before the recording",
                                 tare_m * 1e3));
  return tare_m;
}

// a file as named, or a new name in the directory (start, sensor and labels)
std::string FileName(const std::string& output, const trial::Metadata& metadata) {
  if (output.empty() || !IsDirectoryName(output)) return output;
  return NewTrialName(output, UtcNow(), metadata.sensor, metadata.labels);
}

// style of the live figures: a terminal's line is overwritten, a program receives separate lines
LiveStyle StyleOf(bool is_json, bool live) {
  const bool err_is_terminal = isatty(STDERR_FILENO) != 0;
  if (!live) return err_is_terminal ? LiveStyle::kProgressLine : LiveStyle::kNone;
  if (err_is_terminal && isatty(STDOUT_FILENO) != 0) return LiveStyle::kPlot;
  return is_json ? LiveStyle::kErrorLines : LiveStyle::kOutputLines;
}

// one remark for each disconnection and one for each return
std::function<void(const acquire::RecordingSummary&)> TellAbsences() {
  return [was_away = false](const acquire::RecordingSummary& summary) mutable {
    if (summary.is_away == was_away) return;
    was_away = summary.is_away;
    cli::Remark(kVerb,
                was_away ? "the device is disconnected; waiting for it" : "the device is back");
  };
}

// a recording that is to be made, once its sensor has started
struct PlannedRecording {
  Sensor& sensor;
  Clock& clock;
  acquire::RecordingLimits limits;
  trial::TrialHeader header;
  dsp::BandPass band;
  LiveStyle style;
};

// the recording, with a live view of it where its style asks for one
Result<acquire::RecordingSummary> RecordShown(const PlannedRecording& made, acquire::RowSink& sink,
                                              const std::function<void()>& output_closed = {}) {
  const auto record = [&](const acquire::RecordingHooks& watch) {
    return acquire::Record(made.sensor, sink, made.clock, cli::Interrupted(), made.limits, watch);
  };
  // without a live view disconnections are remarked on separate lines
  if (made.style == LiveStyle::kNone) return record({.progress = TellAbsences(), .say = InWords});
  LiveMeter meter(made.header, made.band);
  LiveView view(meter, made.band, made.style, output_closed);
  return record(
      {.reading = [&](const acquire::Reading& reading) { meter.Add(reading); },
       .progress = [&](const acquire::RecordingSummary& summary) { view.Progress(summary); },
       .say = InWords});
}

// the reason why a recording is not the requested one; the program's exit status
int ReportFault(const std::string& file, const acquire::RecordingSummary& summary,
                const std::string& port, bool reconnects) {
  const std::string kept = file.empty() ? "" : file + " holds everything up to then; ";
  if (summary.connection_lost) {
    return cli::ReportError(
        kVerb,
        {Cause::kFailed, port,
         reconnects ? "the device did not come back in time, or with other settings"
                    : "the connection was lost",
         kept + (reconnects ? "check cable and power, or give --reconnect longer"
                            : "check cable and power, or let --reconnect TIME wait for it")});
  }
  // an interruption (Ctrl-C) is no error: only a recording without any measurement is
  const int status = cli::InterruptedStatus(0);
  if (status == 0 && summary.fell_silent) {
    return cli::ReportError(kVerb,
                            {Cause::kFailed, port, "gave no reading to the end that was asked for",
                             kept + "examine the device or program, its power and its cable"});
  }
  if (status == 0 && summary.source_ended) {
    return cli::ReportError(
        kVerb, {Cause::kFailed, port, "ended before the end that was asked for",
                kept + "examine the messages of the program or the recording that it is of"});
  }
  if (status != 0 || summary.measured > 0) return status;
  // readings came before the trigger (seen) and none after it
  if (summary.readings == 0 && summary.seen > 0) {
    return cli::ReportError(kVerb,
                            {Cause::kCannotAnswer, port,
                             fmt::format("the trigger did not fire in {} readings", summary.seen),
                             "examine the values with --live, and set --trigger within them"});
  }
  return cli::ReportError(
      kVerb, {Cause::kCannotAnswer, port,
              summary.readings == 0 ? "no reading came" : "no reading was a measurement",
              "check that the laser is on and meets its target within the range"});
}

int Report(const AcquireOptions& wanted, const std::string& file, const PlannedRecording& made,
           acquire::RecordingSummary summary, const acquire::Findings& found, bool reconnects,
           int argc, const char* const* argv) {
  const auto time_base = ReviewTimeBase(file, made.header.timing, summary);
  // gaps between shots are intended: only a recording without trigger counts them
  if (time_base && summary.triggers == 0) summary.gaps = time_base->gaps;
  const int status =
      document::Present(RecordingDocument(file, made.header.metadata, summary, time_base, found),
                        wanted.outputs, argc, argv);
  return cli::WorseStatus(status, ReportFault(file, summary, PortName(wanted.sensor), reconnects));
}

// into a trial; without a file name only through the live view
Result<acquire::RecordingSummary> RecordTo(const std::string& file, bool overwrite,
                                           const PlannedRecording& made) {
  if (file.empty()) {
    KeepNothing nothing;
    // the reader of stdout has closed it: end as by SIGPIPE, since no data are stored
    return RecordShown(made, nothing, [] { cli::InterruptAsBy(SIGPIPE); });
  }
  // checked a second time: the sensor may have opened further input files since the command line
  HAPTOMETER_TRY(cli::CheckOutput(file, cli::kTrialOutput, overwrite));
  // a device such as /dev/null exists and is written without --overwrite
  const bool replaces = overwrite || std::filesystem::is_other(file);
  HAPTOMETER_LET(auto writer, trial::TrialWriter::Create(
                                  file, made.header, {.flush_interval_s = 1, .overwrite = replaces},
                                  made.clock));
  acquire::SingleTrial sink(writer);
  auto summary = RecordShown(made, sink);
  // the file was renamed during the recording: its data are complete under the new path
  if (const std::string& moved_to = writer.totals().moved_to; summary && !moved_to.empty()) {
    return Failed(file, "was moved while it was recorded", "it is complete, at " + moved_to);
  }
  return summary;
}

// from the start of the sensor to the report; the exit status
Result<int> Run(const AcquireOptions& wanted, const RecordingPlan& plan, const dsp::BandPass& band,
                int argc, const char* const* argv) {
  // start the sensor, and state what it can observe before anything is recorded
  SystemClock clock;
  HAPTOMETER_LET(const auto sensor, Open(wanted.sensor, plan, clock));
  HAPTOMETER_TRY(sensor->Start(cli::Interrupted()));
  cli::Remark(kVerb, "source: " + sensor->header().metadata.source);
  std::vector<std::string> said;
  SayNew(sensor->Found(), said);
  if (wanted.check) return RunSensorCheck(wanted, band, argc, argv, *sensor, clock);

  // tare, header and limits, in this order: the trigger's threshold counts from the tare
  HAPTOMETER_LET(const auto tare_m, Tare(*sensor, wanted, clock));
  PlannedRecording made{
      .sensor = *sensor,
      .clock = clock,
      .limits = {},
      .header = RecordingHeader(*sensor, IsSensor(wanted.sensor.sensor, SensorType::kReplay),
                                plan.labels, cli::CommandLine({argv, argv + argc})),
      .band = band,
      .style = StyleOf(wanted.outputs.json, wanted.live)};
  if (tare_m) made.header.metadata.tare_m = *tare_m;
  HAPTOMETER_LET(made.limits, LimitsOf(plan, made.header, clock));

  // the recording
  const std::string file = FileName(wanted.recording.output, made.header.metadata);
  HAPTOMETER_LET(const auto summary, RecordTo(file, wanted.recording.overwrite, made));
  // a closed output ends the program without a report, for which there is no reader
  if (cli::InterruptedStatus(0) == kOutputClosed) return kOutputClosed;
  acquire::Findings found = sensor->Found();
  found.AddAll(summary.found);
  SayNew(found, said);
  return Report(wanted, file, made, summary, found, plan.reconnects, argc, argv);
}

// the ports, the routes or the sensors
Result<document::Document> List(const AcquireOptions& wanted) {
  if (wanted.list_ports) {
    HAPTOMETER_LET(const auto ports, acquire::ListPorts());
    return PortsDocument(ports);
  }
  if (wanted.advise.advise) {
    HAPTOMETER_LET(const auto asked, ReadRouteQuestion(wanted.advise, wanted.band));
    return RoutesDocument(asked);
  }
  HAPTOMETER_LET(const auto question, ReadCapabilityQuestion(wanted.band, wanted.resolution_m));
  return SensorsDocument(question);
}

// what the options ask for; the exit status
Result<int> Answer(const AcquireOptions& wanted, int argc, const char* const* argv) {
  HAPTOMETER_TRY(document::CheckOutputs(wanted.outputs));
  // lists need no sensor, so they come before the checks of the sensor's options
  if (wanted.list_ports || wanted.list_sensors || wanted.advise.advise) {
    HAPTOMETER_LET(auto document, List(wanted));
    return document::Present(std::move(document), wanted.outputs, argc, argv);
  }
  HAPTOMETER_LET(const auto of_daemon, RunDaemonOptions(wanted.daemon, wanted.outputs, argc, argv));
  if (of_daemon) return *of_daemon;
  HAPTOMETER_TRY(CheckAcquire(wanted));
  HAPTOMETER_LET(const auto plan,
                 PlanRecording(wanted.recording, wanted.sensor, std::time(nullptr)));
  RemarkOnLabels(kVerb, plan.labels);
  HAPTOMETER_LET(const auto band, BandOf(wanted));
  // from here on Ctrl-C ends the recording, not the program: the trial is closed properly
  cli::CatchInterrupts();
  return Run(wanted, plan, band, argc, argv);
}

}  // namespace

int RunAcquire(int argc, const char* const* argv) {
  cli::Options options(kText);
  AcquireOptions wanted;
  DeclareAcquire(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  wanted.outputs.json = options.json();
  const auto status = Answer(wanted, argc, argv);
  return status ? *status : cli::InterruptedStatus(cli::ReportError(kVerb, status.error()));
}

std::string InWords(const acquire::Finding& found) {
  const std::string words = document::WordsOf(found);
  return found.subject.empty() ? words : found.subject + ": " + words;
}

trial::TrialHeader RecordingHeader(const acquire::Sensor& sensor, bool is_replay,
                                   const std::map<std::string, std::string>& labels,
                                   std::string command_line) {
  trial::TrialHeader header = sensor.header();
  trial::Metadata& metadata = header.metadata;
  // a replay keeps host and start of its trial
  if (!is_replay) {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    metadata.host = Printable(host.data());
    metadata.utc_start = UtcNow();
  }
  metadata.command_line = std::move(command_line);
  for (const auto& [key, value] : labels) metadata.labels[key] = value;
  return header;
}

}  // namespace haptometer::tools
