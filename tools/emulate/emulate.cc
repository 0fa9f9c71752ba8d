#include "tools/emulate/emulate.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "acquire/emulator/device.h"
#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/fault.h"
#include "acquire/emulator/lkg_unit.h"
#include "acquire/emulator/modbus_unit.h"
#include "acquire/emulator/server.h"
#include "acquire/emulator/stream_head.h"
#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/stream_line.h"
#include "acquire/sensor/modbus_profile.h"
#include "base/mapped.h"
#include "base/text.h"
#include "sim/sensor_model.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"
#include "tools/cli/terminal.h"
#include "tools/emulate/analog_output.h"
#include "tools/simulate/simulated_trial.h"
#include "tools/verbs.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

namespace emulator = acquire::emulator;

constexpr std::string_view kVerb = "emulate";
constexpr std::string_view kUnit = "dl-rs1a";
constexpr std::string_view kEn1 = "en1";
constexpr std::string_view kLkg = "lkg";
constexpr std::string_view kStream = "stream";
constexpr std::string_view kModbus = "modbus";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Play a scene or a trial as an emulated sensor, over a terminal or TCP.",
    .examples = {"haptometer emulate --scene fixtures/lra_adapter.toml --link ./sensor",
                 "haptometer emulate --scene fixtures/lra_adapter.toml --protocol stream"
                 " --baud 921600",
                 "haptometer emulate --trial trial.bin --baud 38400 --tcp 127.0.0.1:0"
                 " --fault silent:50"}};

// times that are converted to ns: the clock's resolution to a year
constexpr cli::Bounds kTimes = cli::Within(1e-9, 3.2e7);

// The command line.
struct Wanted {
  std::string scene;
  std::string trial;
  std::string protocol{kUnit};
  std::optional<std::int64_t> baud;
  std::string profile;
  std::string link;
  std::string tcp;
  std::string fault;
  std::string format;
  std::optional<std::int64_t> seed;
  std::optional<double> duration_s;
  std::optional<double> sampling_s;
  std::optional<std::int64_t> averages;
  std::optional<double> refresh_s;
  std::optional<std::int64_t> amplifiers;
  bool is_writable = false;
  std::string analog;
  double analog_gain = 1;
  double analog_offset_v = 0;
  double analog_noise_v = 1e-3;
  cli::ImportWords import;

  [[nodiscard]] bool stream() const { return protocol == kStream; }
  [[nodiscard]] bool modbus() const { return protocol == kModbus; }
};

void Declare(cli::Options& options, Wanted& wanted) {
  options.Text("--scene", &wanted.scene, "SCENE.toml",
               "Scene to play: its steady state, unless it starts at rest");
  options.Text("--trial", &wanted.trial, "FILE.bin|csv|h5|lvm",
               "Trial to play, linearly interpolated between its rows; its last value is held "
               "after its end");
  options.Choice("--protocol", &wanted.protocol,
                 {std::string(kUnit), std::string(kEn1), std::string(kLkg), std::string(kStream),
                  std::string(kModbus)},
                 "Keyence's DL-RS1A, DL-EN1 or LK-G3001, polled for each reading; stream: lines "
                 "sent without request; modbus: registers");
  options
      .Text("--profile", &wanted.profile, "NAME|FILE",
            "Profile of the Modbus sensor: a built-in one or a TOML file; RTU, with --tcp TCP")
      .Known(Mapped<std::string>(acquire::BuiltInProfiles(), &acquire::SensorProfile::name));
  options.Count("--baud", &wanted.baud, 300, 20'000'000, "Bits per second of the wire")
      .Default("9600, 921600 for stream, none for en1");
  options
      .Text("--format", &wanted.format, "PICTURE,UNIT,END",
            "Form of a stream's lines; numbered lines: 000,+00.0000,mm,CR")
      .Default("+00.0000,mm,CR");
  options.Text("--link", &wanted.link, "PATH", "Symbolic link to create for the terminal");
  options.Text("--tcp", &wanted.tcp, "HOST:PORT",
               "TCP instead of a terminal; port 0: any free one");
  std::string faults = "One reply in EVERY fails:";
  for (const emulator::Fault& fault : emulator::Faults()) {
    faults +=
        fmt::format("{} {} ({})", faults.ends_with(':') ? "" : ",", fault.name, fault.summary);
  }
  options.Text("--fault", &wanted.fault, "NAME[:EVERY]", faults).Default("none; EVERY 1");
  options.Count("--seed", &wanted.seed, 0, INT64_MAX, "Seed of the noise").Default("1");
  options.Number("--duration", &wanted.duration_s, Dimension::kTime, kTimes, "End after this time");
  options
      .Number("--sampling", &wanted.sampling_s, Dimension::kTime, kTimes,
              "Sampling period of the head", cli::Shown::kHelpAll)
      .Default("1 ms, 100 us for stream");
  options
      .Count("--averages", &wanted.averages, 1, 4096, "Raw samples averaged in a reading",
             cli::Shown::kHelpAll)
      .Default("16, 1 for stream");
  options
      .Number("--refresh", &wanted.refresh_s, Dimension::kTime, kTimes,
              "Interval at which a DL-RS1A or DL-EN1 refreshes its values", cli::Shown::kHelpAll)
      .Default("7 ms for dl-rs1a and 7.8 ms for en1, with one amplifier");
  options
      .Count("--amplifiers", &wanted.amplifiers, 1, 15,
             "Number of amplifiers; number n, counted from 0, shows the motion divided by n + 1",
             cli::Shown::kHelpAll)
      .Default("1");
  options.Flag("--writable", &wanted.is_writable,
               "Set the unit's R/W switch to W: SW and AW are executed", cli::Shown::kHelpAll);
  options.Text("--analog", &wanted.analog, "PATH",
               "Named pipe, made where it is not there, into which a DAQ at the analog output "
               "writes 1000 lines of volts a second");
  options.Number("--analog-gain", &wanted.analog_gain, Dimension::kNone, cli::Within(0.5, 1.5),
                 "Factor on the analog value that the amplifier reports (data 042)");
  options.Number("--analog-offset", &wanted.analog_offset_v, Dimension::kVoltage,
                 cli::Within(-1, 1), "Added to it");
  options.Number("--analog-noise", &wanted.analog_noise_v, Dimension::kVoltage, cli::Within(0, 1),
                 "Standard deviation of a sample of --analog");
  // --format is declared above, as the form of the lines that are sent
  cli::DeclareImport(&options, &wanted.import, cli::Scaled::kDisplacement, true);
}

// Options that exclude or require each other.
Result<void> CheckTogether(const cli::Options& options, const Wanted& wanted) {
  const bool has_buffer = !wanted.stream() && wanted.protocol != kLkg;
  const std::string without = fmt::format("leave it out with --protocol {}", wanted.protocol);
  return cli::CheckRules({
      {options.json(), "--json", "emulate has no document to print", "read its line 'ready PATH'"},
      {wanted.scene.empty() == wanted.trial.empty(), "", "what to play is not clear",
       "give one of --scene FILE and --trial FILE"},
      {!wanted.link.empty() && !wanted.tcp.empty(), "--link",
       "is for a terminal, and --tcp makes none", "leave one of them out"},
      // a stream and an LK-G have no buffer that is refreshed at intervals
      {wanted.refresh_s && !has_buffer, "--refresh", "is the buffer of a DL-RS1A", without},
      {wanted.amplifiers && wanted.stream(), "--amplifiers", "is for polled sensors", without},
      {wanted.modbus() == wanted.profile.empty(), "--profile",
       "belongs to --protocol modbus, and that needs it",
       "give both, e.g. --protocol modbus --profile baumer-om20"},
      // a profile states wire and sampling of its sensor
      {wanted.modbus() && (wanted.baud || wanted.sampling_s || wanted.averages || wanted.refresh_s),
       "--profile", "states baud rate and sampling itself",
       "leave --baud, --sampling, --averages and --refresh out"},
      {!wanted.analog.empty() && (wanted.stream() || wanted.modbus() || wanted.protocol == kLkg),
       "--analog", "is the output of an IL amplifier", without},
      {!wanted.stream() && !wanted.format.empty(), "--format",
       "is for lines that are sent without request", "add --protocol stream"},
  });
}

// The head in front of a played scene: its motion and, where the scene's sensor is of this
// protocol's kind, its settings. Of another kind only the spot (skin, case or mover) is used.
Result<void> PlayScene(const std::string& path, emulator::MovingHead& head) {
  HAPTOMETER_LET(const auto scene, ReadPlayedScene(path));
  if (scene.sensor && scene.sensor->head.name == head.head.name) {
    head = {.head = scene.sensor->head,
            .displacement = sim::SensedMotion(scene),
            .seed = scene.sensor->seed};
    return {};
  }
  const auto target = scene.sensor ? scene.sensor->target : sim::SensorTarget::kSkin;
  head.displacement = sim::MotionOf(scene, target);
  return {};
}

// The displacement of a trial; the remark states its duration and the rows without measurement.
Result<std::string> PlayTrial(const std::string& path, const cli::ImportWords& words,
                              emulator::MovingHead& head) {
  HAPTOMETER_LET(const auto import, cli::ImportOf(words, {&path, 1}));
  HAPTOMETER_LET(const auto recording, trial::ReadRecording(path, import));
  HAPTOMETER_LET(auto motion, MotionOf(recording.record, path));
  head.displacement = std::move(motion.displacement);
  std::string remark =
      fmt::format("plays {:.6g} s of {}, then holds its last value", motion.duration_s, path);
  if (motion.left_out > 0) {
    remark += fmt::format("; {} rows without a measurement are interpolated", motion.left_out);
  }
  if (!recording.report.losses.empty()) {
    remark += "; parts of the file cannot be read (haptometer trial info), and are interpolated";
  }
  return remark;
}

// A device, and the remark that is printed once it is ready.
struct Played {
  std::unique_ptr<emulator::Device> device;
  std::string remark;
};

std::string Describe(const trial::SensorHead& head) {
  return fmt::format("{}, sampled every {:g} ms, {} average{}", head.name, 1e3 * head.sampling_s,
                     head.averages, head.averages == 1 ? "" : "s");
}

// one head for each amplifier, with x / (n + 1) and a seed of its own, to distinguish the channels
std::vector<emulator::MovingHead> AllHeads(const Wanted& wanted, const emulator::MovingHead& head) {
  std::vector<emulator::MovingHead> heads{head};
  for (std::int64_t number = 1; number < wanted.amplifiers.value_or(1); ++number) {
    emulator::MovingHead further = head;
    further.seed += static_cast<std::uint64_t>(number);
    further.displacement = [whole = head.displacement, number](double t_s) {
      return whole(t_s) / static_cast<double>(number + 1);
    };
    heads.push_back(std::move(further));
  }
  return heads;
}

// DL-EN1 (TCP): the refresh interval depends on the number of amplifiers unless it is given
Result<Played> MakeEn1(const Wanted& wanted, const emulator::MovingHead& head,
                       const emulator::FaultPlan& faults) {
  emulator::DlEn1Setup setup;
  setup.heads = AllHeads(wanted, head);
  setup.faults = faults;
  setup.is_writable = wanted.is_writable;
  setup.refresh_ns = acquire::dl_en1::RefreshNs(setup.heads.size());
  if (wanted.refresh_s) setup.refresh_ns = NsFromSeconds(*wanted.refresh_s);
  HAPTOMETER_TRY(Validate(setup));
  std::string remark = fmt::format("{}; new readings every {:g} ms", Describe(head.head),
                                   1e3 * SecondsFromNs(setup.refresh_ns));
  return Played{std::make_unique<emulator::DlEn1Unit>(std::move(setup)), std::move(remark)};
}

// LK-G3001 on a serial line: no buffer with a refresh interval
Result<Played> MakeLkg(const Wanted& wanted, const emulator::MovingHead& head,
                       const emulator::FaultPlan& faults) {
  emulator::LkgSetup setup;
  setup.heads = AllHeads(wanted, head);
  setup.faults = faults;
  if (wanted.baud) setup.baud = static_cast<int>(*wanted.baud);
  HAPTOMETER_TRY(Validate(setup));
  std::string remark = fmt::format("{}; at {} baud", Describe(head.head), setup.baud);
  return Played{std::make_unique<emulator::LkgUnit>(std::move(setup)), std::move(remark)};
}

// DL-RS1A on a serial line: main amplifier, expansions, and the interval of its buffer
Result<Played> MakeUnit(const Wanted& wanted, const emulator::MovingHead& head,
                        const emulator::FaultPlan& faults) {
  emulator::DlRs1aSetup setup;
  const std::vector<emulator::MovingHead> heads = AllHeads(wanted, head);
  setup.head = heads.front();
  setup.expansions.assign(heads.begin() + 1, heads.end());
  setup.faults = faults;
  setup.is_writable = wanted.is_writable;
  setup.refresh_ns = acquire::dl_rs1a::RefreshNs(heads.size());
  if (wanted.baud) setup.baud = static_cast<int>(*wanted.baud);
  if (wanted.refresh_s) setup.refresh_ns = NsFromSeconds(*wanted.refresh_s);
  HAPTOMETER_TRY(Validate(setup));
  // two limits of the rate: the exchange on the wire, and the refresh of the unit's values
  const double period_s = SecondsFromNs(acquire::dl_rs1a::PollPeriodNs(setup.baud, heads.size()));
  std::string remark = fmt::format(
      "{}; at {} baud at most {:.1f} readings/s, new ones every {:g} ms", Describe(setup.head.head),
      setup.baud, 1 / period_s, 1e3 * SecondsFromNs(setup.refresh_ns));
  return Played{std::make_unique<emulator::DlRs1aUnit>(setup), std::move(remark)};
}

// free-running lines, one for each sampling period of the head
Result<Played> MakeStream(const Wanted& wanted, emulator::MovingHead head,
                          const emulator::FaultPlan& faults) {
  emulator::StreamSetup setup;
  if (!wanted.format.empty()) {
    HAPTOMETER_LET(setup.format, acquire::ParseStreamFormat(wanted.format));
  }
  setup.head = std::move(head);
  setup.faults = faults;
  if (wanted.baud) setup.baud = static_cast<int>(*wanted.baud);
  HAPTOMETER_TRY(Validate(setup));
  std::string remark =
      fmt::format("{}; {:g} lines/s of {} characters at {} baud", Describe(setup.head.head),
                  1 / setup.head.head.sampling_s, LineBytes(setup.format), setup.baud);
  return Played{std::make_unique<emulator::StreamHead>(std::move(setup)), std::move(remark)};
}

// the profile's settings replace those of the head
Result<Played> MakeModbus(const Wanted& wanted, emulator::MovingHead head,
                          const emulator::FaultPlan& faults) {
  const bool over_tcp = !wanted.tcp.empty();
  HAPTOMETER_LET(auto found, acquire::FindProfile(wanted.profile));
  emulator::ModbusUnitSetup setup;
  setup.profile = std::move(found);
  // frame with CRC on a serial line, with header and length over TCP
  setup.framing = over_tcp ? acquire::ModbusFraming::kTcp : acquire::ModbusFraming::kRtu;
  setup.head = std::move(head);
  setup.head.head = emulator::HeadOf(setup.profile);
  setup.faults = faults;
  std::string remark = fmt::format(
      "{} as Modbus slave {}, {:g} mm from what moves, sampled every {:g} ms", setup.profile.name,
      setup.profile.wire.slave, 1e3 * setup.standoff_m, 1e3 * setup.head.head.sampling_s);
  if (!over_tcp) {
    remark += fmt::format("; at {} baud at most {:.1f} readings/s", setup.profile.wire.baud,
                          1 / SecondsFromNs(acquire::RtuPeriodNs(setup.profile)));
  }
  const std::string profile = setup.profile.name;
  auto unit = std::make_unique<emulator::ModbusUnit>(std::move(setup));
  if (faults.fault != nullptr && !unit->Shows(*faults.fault)) {
    return Usage("--fault",
                 fmt::format("{} has no number that means '{}'", profile, faults.fault->name),
                 "give another fault or profile");
  }
  return Played{std::move(unit), std::move(remark)};
}

// device of the protocol with faults, and in front of its head a scene or a trial
Result<Played> MakeDevice(const Wanted& wanted) {
  emulator::FaultPlan faults;
  if (!wanted.fault.empty()) {
    HAPTOMETER_LET(faults, emulator::ParseFaultPlan(wanted.fault));
    // CRC, slave, transaction and word order exist in Modbus replies only
    if (faults.fault->is_modbus && !wanted.modbus()) {
      return Usage("--fault", fmt::format("'{}' is for --protocol modbus", faults.fault->name),
                   "give another, or that protocol");
    }
  }
  // default head: 10 kHz stream, else an IL-030
  emulator::MovingHead head;
  head.head = wanted.stream() ? trial::Stream10kHz() : trial::Il030();
  std::string source_remark;
  if (wanted.trial.empty()) {
    HAPTOMETER_TRY(PlayScene(wanted.scene, head));
  } else {
    HAPTOMETER_LET(auto played, PlayTrial(wanted.trial, wanted.import, head));
    source_remark = played + "; ";
  }

  // options override the scene
  if (wanted.sampling_s) head.head.sampling_s = *wanted.sampling_s;
  if (wanted.averages) head.head.averages = static_cast<int>(*wanted.averages);
  if (wanted.seed) head.seed = static_cast<std::uint64_t>(*wanted.seed);
  head.analog = {.gain_error = wanted.analog_gain, .offset_error_v = wanted.analog_offset_v};
  const emulator::MovingHead tapped = head;
  auto made = wanted.modbus()           ? MakeModbus(wanted, std::move(head), faults)
              : wanted.stream()         ? MakeStream(wanted, std::move(head), faults)
              : wanted.protocol == kEn1 ? MakeEn1(wanted, head, faults)
              : wanted.protocol == kLkg ? MakeLkg(wanted, head, faults)
                                        : MakeUnit(wanted, head, faults);
  if (!made) return made;
  made->remark = source_remark + made->remark;
  if (!wanted.analog.empty()) {
    HAPTOMETER_LET(made->device, WithAnalogOutput(std::move(made->device), tapped,
                                                  {.path = wanted.analog,
                                                   .noise_rms_v = wanted.analog_noise_v,
                                                   .seed = tapped.seed + 1000}));
  }
  return made;
}

// from here on a device exists: open its endpoint, then serve until the end or Ctrl-C
Result<void> Emulate(const Wanted& wanted) {
  HAPTOMETER_LET(const auto played, MakeDevice(wanted));
  const auto endpoint =
      wanted.tcp.empty() ? emulator::OpenPty(wanted.link) : emulator::ListenTcp(wanted.tcp);
  if (!endpoint) return std::unexpected(endpoint.error());

  std::optional<MonotonicNs> duration_ns;
  if (wanted.duration_s) duration_ns = NsFromSeconds(*wanted.duration_s);
  // one remark, while `ready` is printed again whenever the terminal's name has changed
  bool remarked = false;
  HAPTOMETER_LET(const auto report,
                 emulator::Serve(*played.device, **endpoint, cli::Interrupted(), duration_ns,
                                 [&](const std::string& name) {
                                   cli::Print(fmt::format("ready {}\n", Printable(name)));
                                   std::fflush(stdout);
                                   if (!std::exchange(remarked, true))
                                     cli::Remark(kVerb, played.remark);
                                 }));
  // a free-running sensor does not wait for its reader
  if (report.dropped_lines > 0) {
    cli::Remark(kVerb,
                fmt::format("{} lines were lost because the reader did not read them in time",
                            report.dropped_lines));
  }
  return {};
}

// measured rows in order of time: a continuous motion by linear interpolation
struct Path {
  std::vector<double> times_s;
  std::vector<double> values_m;
};

// position in m at t_s, linear between rows, constant before the first and behind the last
double PositionAt(const Path& path, double t_s) {
  // first row behind t_s: the interval is i - 1 to i
  const auto after = std::ranges::upper_bound(path.times_s, t_s);
  if (after == path.times_s.begin()) return path.values_m.front();
  if (after == path.times_s.end()) return path.values_m.back();
  const auto i = static_cast<std::size_t>(after - path.times_s.begin());
  const double span_s = path.times_s[i] - path.times_s[i - 1];
  return std::lerp(path.values_m[i - 1], path.values_m[i], (t_s - path.times_s[i - 1]) / span_s);
}

}  // namespace

int RunEmulate(int argc, const char* const* argv) {
  Wanted wanted;
  cli::Options options(kText);
  Declare(options, wanted);
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (auto together = CheckTogether(options, wanted); !together) {
    return cli::ReportError(kVerb, together.error());
  }
  cli::CatchInterrupts();
  if (auto done = Emulate(wanted); !done) return cli::ReportError(kVerb, done.error());
  return cli::InterruptedStatus(0);
}

Result<RecordedMotion> MotionOf(const trial::Record& record, const std::string& where) {
  const trial::Channel* channel = record.Find(trial::ChannelRole::kDisplacement);
  if (channel == nullptr) {
    return CannotAnswer(where, "has no displacement channel to play",
                        "give a trial of a distance sensor");
  }
  auto path = std::make_shared<Path>();
  for (std::size_t row = 0; row < record.rows; ++row) {
    // a row without measurement is interpolated like any point between its neighbours
    if (!trial::IsMeasurement(channel->statuses[row])) continue;
    path->times_s.push_back(trial::TimeOf(record, row));
    path->values_m.push_back(channel->values[row]);
  }
  if (path->times_s.empty()) {
    return CannotAnswer(where, "holds no measured value to play", "give another trial");
  }

  // time counts from the first measurement
  const double start_s = path->times_s.front();
  for (double& time_s : path->times_s) time_s -= start_s;
  return RecordedMotion{
      // shared: the motion is copied for each amplifier, its path is not
      .displacement = [path](double t_s) { return PositionAt(*path, t_s); },
      .duration_s = path->times_s.back(),
      .left_out = record.rows - path->times_s.size(),
  };
}

}  // namespace haptometer::tools
