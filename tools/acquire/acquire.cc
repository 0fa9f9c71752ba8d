// acquire: a sensor's readings become a trial.
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/transport/port_list.h"
#include "base/clock.h"
#include "tools/acquire/list_ports.h"
#include "tools/acquire/list_sensors.h"
#include "tools/acquire/open_sensor.h"
#include "tools/acquire/recording_output.h"
#include "tools/acquire/sensor_options.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/verbs.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;
using acquire::Sensor;

constexpr std::string_view kVerb = "acquire";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Record a distance sensor's readings into a trial.",
    .examples = {"acquire --port /dev/ttyUSB0 -o trial.bin",
                 "acquire --port /dev/ttyUSB0 --baud 38400 --duration 10s --label subject=3 "
                 "--label condition=adapter -o trial.bin",
                 "acquire --port /dev/ttyUSB1 --sensor stream --baud 921600 "
                 "--format +00.0000,mm,CR --samples 30000 -o trial.bin"}};

struct AcquireOptions {
  SensorOptions sensor;
  std::string output;
  std::vector<std::string> labels;
  std::optional<std::int64_t> samples;
  std::optional<Quantity> duration_s;
  bool overwrite = false;
  bool list_ports = false;
  bool list_sensors = false;
  std::string band = "20-500Hz";
  std::optional<Quantity> resolution_m;
};

void Declare(cli::Options& options, AcquireOptions& wanted) {
  DeclareSensor(options, wanted.sensor);
  options.Text("-o,--output", &wanted.output, "FILE", "The trial to write");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime, "Stop after this time");
  options.Count("--samples", &wanted.samples, 1, std::int64_t{1} << 53,
                "Stop after this many readings");
  options.Repeated("--label", &wanted.labels, "KEY=VALUE", "Kept with the trial; may be repeated");
  options.Flag("--overwrite", &wanted.overwrite, "Replace an existing trial");
  options.Flag("--list-ports", &wanted.list_ports, "List the serial ports, and record nothing");
  options.Flag("--list-sensors", &wanted.list_sensors,
               "Say which sensors can answer --band and --resolution, and record nothing");
  options.Text("--band", &wanted.band, "LOWER-UPPERHz", "What --list-sensors is asked; 20-500Hz");
  options.Number("--resolution", &wanted.resolution_m, Dimension::kLength,
                 "Largest step that is fine enough; 1um");
}

// what is wrong with the command line, before anything is touched
Result<void> Check(const AcquireOptions& wanted) {
  if (auto checked = CheckSensor(wanted.sensor); !checked) return checked;
  if (wanted.output.empty()) {
    return Usage("-o", "is missing", "name the trial to write, e.g. -o trial.bin");
  }
  if (wanted.duration_s && !(wanted.duration_s->value > 0)) {
    return Usage("--duration", "must be above 0", "write e.g. 10s");
  }
  std::error_code error;
  if (wanted.sensor.sensor == "replay" &&
      fs::equivalent(wanted.sensor.port, wanted.output, error)) {
    return Usage(wanted.output, "is the trial that is played", "give another file to -o");
  }
  if (!wanted.overwrite && fs::exists(fs::symlink_status(wanted.output, error))) {
    return Usage(wanted.output, "already exists", "name another file, or say --overwrite");
  }
  const fs::path directory = fs::path(wanted.output).parent_path();
  if (!directory.empty() && !fs::is_directory(directory, error)) {
    return Usage(wanted.output, "lies in a directory that does not exist",
                 "make it, or name another");
  }
  return {};
}

Result<std::map<std::string, std::string>> ReadLabels(const std::vector<std::string>& words) {
  std::map<std::string, std::string> labels;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0) {
      return Usage("--label", fmt::format("'{}' is not KEY=VALUE", word), "write e.g. subject=3");
    }
    labels[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return labels;
}

// what the sensor says, and who recorded it when
trial::TrialHeader MakeHeader(const Sensor& sensor, const AcquireOptions& wanted,
                              const std::map<std::string, std::string>& labels,
                              std::string command_line) {
  trial::TrialHeader header = sensor.header();
  trial::Metadata& metadata = header.metadata;
  if (wanted.sensor.sensor != "replay") {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    metadata.host = host.data();
    metadata.utc_start = UtcNow();
  }
  metadata.command_line = std::move(command_line);
  for (const auto& [key, value] : labels) metadata.labels[key] = value;
  return header;
}

// one line that is written over and over, for people only
std::function<void(const acquire::RecordingSummary&)> Progress() {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [](const acquire::RecordingSummary& summary) {
    fmt::print(stderr, "\r{}\x1b[K", ProgressLine(summary));
  };
}

int Report(const cli::Options& options, const std::string& file, const trial::Metadata& metadata,
           const acquire::RecordingSummary& summary, const std::string& port) {
  if (options.json()) {
    fmt::print("{}", SummaryJson(file, metadata, summary));
  } else {
    fmt::print("{}\n", SummaryLine(file, summary));
  }
  if (summary.connection_lost) {
    return cli::ReportError(kVerb, {Cause::kFailed, port, "the connection was lost",
                                    fmt::format("{} holds everything up to then; check cable and "
                                                "power, and record again",
                                                file)});
  }
  const int status = cli::InterruptedStatus(0);
  if (status == 0 && summary.bad() == summary.readings) {
    return cli::ReportError(
        kVerb, {Cause::kCannotAnswer, port,
                summary.readings == 0 ? "no reading came" : "no reading was a measurement",
                "check that the laser is on and meets its target within the range"});
  }
  return status;
}

Result<acquire::RecordingLimits> Limits(const AcquireOptions& wanted) {
  constexpr double kLongest_s = 1e9;  // 30 years still fit in nanoseconds
  acquire::RecordingLimits limits;
  if (wanted.duration_s) {
    if (wanted.duration_s->value > kLongest_s) {
      return Usage("--duration", "is beyond 30 years", "leave it out to record until Ctrl-C");
    }
    limits.duration_ns = NsFromSeconds(wanted.duration_s->value);
  }
  if (wanted.samples) limits.readings = static_cast<std::uint64_t>(*wanted.samples);
  return limits;
}

// everything between the command line and the report
int Run(const cli::Options& options, const AcquireOptions& wanted, std::string command_line) {
  const auto labels = ReadLabels(wanted.labels);
  if (!labels) return cli::ReportError(kVerb, labels.error());
  const auto limits = Limits(wanted);
  if (!limits) return cli::ReportError(kVerb, limits.error());
  cli::CatchInterrupts();

  // the sensor answers, and what it can observe is said before anything is recorded
  SystemClock clock;
  const auto sensor = OpenSensor(wanted.sensor, clock);
  if (!sensor) return cli::ReportError(kVerb, sensor.error());
  if (auto started = (*sensor)->Start(cli::Interrupted()); !started) {
    return cli::InterruptedStatus(cli::ReportError(kVerb, started.error()));
  }
  const trial::TrialHeader header = MakeHeader(**sensor, wanted, *labels, std::move(command_line));
  cli::Remark(kVerb, "source: " + header.metadata.source);
  for (const std::string& remark : (*sensor)->Remarks()) cli::Remark(kVerb, remark);

  // the recording
  auto writer = trial::TrialWriter::Create(
      wanted.output, header, {.flush_interval_s = 1, .overwrite = wanted.overwrite}, clock);
  if (!writer) return cli::ReportError(kVerb, writer.error());
  const auto progress = Progress();
  acquire::SingleTrial sink(*writer);
  const auto summary =
      acquire::Record(**sensor, sink, clock, cli::Interrupted(), *limits, {.progress = progress});
  if (progress) fmt::print(stderr, "\r\x1b[K");
  if (!summary) return cli::ReportError(kVerb, summary.error());
  return Report(options, wanted.output, header.metadata, *summary, PortName(wanted.sensor));
}

int ListPorts(const cli::Options& options) {
  const auto ports = acquire::ListPorts();
  if (!ports) return cli::ReportError(kVerb, ports.error());
  fmt::print("{}", options.json() ? PortListJson(*ports) : PortListText(*ports));
  return 0;
}

int ListSensors(const cli::Options& options, const AcquireOptions& wanted) {
  const auto question = ReadCapabilityQuestion(wanted.band, wanted.resolution_m);
  if (!question) return cli::ReportError(kVerb, question.error());
  fmt::print("{}", options.json() ? SensorListJson(*question) : SensorListText(*question));
  return 0;
}

}  // namespace

int RunAcquire(int argc, const char* const* argv) {
  cli::Options options(kText);
  AcquireOptions wanted;
  Declare(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (wanted.list_ports) return ListPorts(options);
  if (wanted.list_sensors) return ListSensors(options, wanted);
  if (auto checked = Check(wanted); !checked) return cli::ReportError(kVerb, checked.error());
  const std::vector<std::string> words(argv, argv + argc);
  return Run(options, wanted, fmt::format("{}", fmt::join(words, " ")));
}

}  // namespace haptometer::tools
