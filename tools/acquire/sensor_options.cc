#include "tools/acquire/sensor_options.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/sensor/keyence/il_settings.h"
#include "acquire/sensor/modbus_profile.h"
#include "base/mapped.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::tools {
namespace {

// alphabetical but for the scene, which SensorNames() completes to scene:FILE
constexpr std::array<SensorKind, 8> kKinds{{
    {.type = SensorType::kKeyenceEn1,
     .name = "keyence-en1",
     .is_il = true,
     .is_keyence = true,
     .is_asked = true},
    {.type = SensorType::kKeyenceIl,
     .name = "keyence-il",
     .is_il = true,
     .is_keyence = true,
     .is_asked = true},
    {.type = SensorType::kKeyenceLkg, .name = "keyence-lkg", .is_keyence = true, .is_asked = true},
    {.type = SensorType::kModbus, .name = "modbus", .is_asked = true},
    {.type = SensorType::kPipe, .name = "pipe", .ends_by_itself = true},
    {.type = SensorType::kReplay, .name = "replay", .is_played = true, .ends_by_itself = true},
    {.type = SensorType::kStream, .name = "stream"},
    {.type = SensorType::kScene, .name = kScenePrefix, .is_played = true, .ends_by_itself = true},
}};

constexpr double kLongestPeriodS = 3600;
constexpr std::string_view kNoPeriod = "must be above 0, and an hour at most";

bool IsPeriod(double period_s) { return period_s > 0 && period_s <= kLongestPeriodS; }

// all names for a message: "keyence-en1, ..., stream, scene:FILE"
std::string SensorNames() {
  std::string names;
  for (const SensorKind& kind : kKinds) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", kind.name);
  }
  return names + "FILE";
}

// baud of a Keyence unit without --baud
constexpr std::int64_t kKeyenceBaud = 9600;

// options that only some sensors have, given to another one
Result<void> CheckBelonging(const SensorOptions& wanted, const SensorKind& kind) {
  const bool is_pipe = kind.type == SensorType::kPipe;
  const bool is_modbus = kind.type == SensorType::kModbus;
  const bool is_lkg = kind.type == SensorType::kKeyenceLkg;
  const std::string& command = wanted.command;
  const std::int64_t baud = wanted.baud.value_or(kKeyenceBaud);
  const bool is_known_baud = std::ranges::count(acquire::dl_rs1a::kBauds, baud) > 0;
  const std::string_view of_il = "is for the amplifiers of the IL series";
  return cli::CheckRules({
      {!wanted.format.empty() && kind.type != SensorType::kStream && !is_pipe, "--format",
       "is for lines that are sent without request and for samples",
       "add --sensor stream or --sensor pipe"},
      {!wanted.channels.empty() && !is_pipe, "--channels", "is for samples", "add --sensor pipe"},
      {!wanted.calibration.empty() && !is_pipe, "--calibration", "is for samples",
       "add --sensor pipe"},
      {(wanted.averages || wanted.sampling_s) && !is_pipe && kind.type != SensorType::kStream,
       wanted.averages ? "--averaging" : "--sampling", "is for a stream and for samples",
       "leave it out: other sensors report it, or state it in their file"},
      {wanted.averages.value_or(1) > 1 && !wanted.sampling_s, "--sampling",
       "is missing: the period of the samples that are averaged", "give it, e.g. --sampling 1ms"},
      {wanted.sampling_s && !IsPeriod(*wanted.sampling_s), "--sampling", kNoPeriod,
       "write e.g. 0.33ms"},
      // a rate is either that of samples without times, or a limit of polling
      {wanted.rate_hz && !is_pipe && !kind.is_asked, "--rate",
       "is for samples, and for polled sensors: the others have their own", "leave it out"},
      {!wanted.speed.empty() && !kind.is_played, "--speed", "is for what is played",
       "add --sensor replay or --sensor scene:FILE"},
      {!wanted.settings.empty() && !kind.is_il, "--set", of_il, "leave it out"},
      {wanted.device_zero && !kind.is_il, "--device-zero", of_il, "leave it out"},
      {wanted.decimals && kind.type != SensorType::kKeyenceEn1 && !is_lkg, "--decimals",
       "is for keyence-en1 and keyence-lkg: others send the point", "leave it out"},
      {!command.empty() && !kind.is_keyence, "--command",
       "is for keyence-en1, keyence-il and keyence-lkg", "leave it out"},
      // m0 is a command of both series, ms one of the IL, m1 and m2 of the LK-G
      {command == "ms" && is_lkg, "--command", "ms is a command of the IL series",
       "use m1, m2 or m0 (both outputs)"},
      {(command == "m1" || command == "m2") && !is_lkg, "--command",
       command + " is a command of the LK-G series", "use m0, or ms to record the outputs too"},
      // a DL-RS1A has five rates only
      {kind.type == SensorType::kKeyenceIl && !is_known_baud, "--baud",
       fmt::format("a DL-RS1A has no {} baud", baud), "use 2400, 4800, 9600, 19200 or 38400"},
      // --profile and --sensor modbus require each other
      {is_modbus == wanted.profile.empty(), "--profile",
       "belongs to --sensor modbus, and that needs it",
       "give both, e.g. --sensor modbus --profile baumer-om20"},
      {wanted.slave && !is_modbus, "--slave", "is for --sensor modbus", "leave it out"},
  });
}

// what is missing, or lies outside of its range
Result<void> CheckPresence(const SensorOptions& wanted, const SensorKind& kind) {
  const bool is_pipe = kind.type == SensorType::kPipe;
  return cli::CheckRules({
      // below 1 mHz a row would take over 16 minutes
      {wanted.rate_hz && !(*wanted.rate_hz >= 1e-3), "--rate", "must be at least 1 mHz",
       "write e.g. 10kHz"},
      // raw samples describe nothing of themselves: channels, rate and form are required
      {is_pipe && wanted.channels.empty(), "--channels", "is missing",
       "name what is piped in, e.g. --channels displacement:m,voltage:V"},
      {is_pipe && !wanted.rate_hz, "--rate", "is missing",
       "give the rows per second, e.g. --rate 10kHz"},
      {is_pipe && wanted.format.empty(), "--format", "is missing",
       "give the form of the samples: f64, f32, i16 or text"},
      // a pipe may be standard input, so its --port is not required
      {wanted.port.empty() && !is_pipe && !wanted.is_scene(), "--port", "is missing",
       "name the sensor's port, e.g. --port /dev/ttyUSB0"},
      {wanted.refresh_s && !IsPeriod(*wanted.refresh_s), "--refresh", kNoPeriod, "write e.g. 7ms"},
  });
}

}  // namespace

void DeclareSensor(cli::Options& options, SensorOptions& wanted) {
  options
      .Text("--port", &wanted.port, "PORT",
            "Serial port, virtual terminal or HOST:PORT; for replay a trial.bin; for pipe a named "
            "pipe")
      .Default("standard input for pipe");
  options
      .Text("--sensor", &wanted.sensor, "NAME|scene:SCENE.toml",
            "keyence-il: a polled DL-RS1A; keyence-en1: a DL-EN1 (TCP); keyence-lkg: an LK-G3001; "
            "modbus: registers, with --profile; stream: lines sent without request; pipe: another "
            "program's samples; replay: a trial; scene:FILE: a simulated scene")
      .Known(Mapped<std::string>(kKinds, &SensorKind::name));
  options.Count("--baud", &wanted.baud, 50, 4'000'000, "Bits per second")
      .Default("9600, 921600 for stream, the profile's for modbus");
  options
      .Choice(
          "--command", &wanted.command, {"m0", "m1", "m2", "ms"},
          "Read command sent to a Keyence: m0 or ms (with the outputs); keyence-lkg: m1, m2 or m0",
          cli::Shown::kHelpAll)
      .Default("m0, m1 for keyence-lkg");
  options.Count("--decimals", &wanted.decimals, 0, 5,
                "Decimal places of a value in mm, where a DL-EN1 or LK-G does not report them",
                cli::Shown::kHelpAll);
  options.Flag("--device-zero", &wanted.device_zero,
               "Set the zero of the IL amplifiers to the present position of their target",
               cli::Shown::kHelpAll);
  options.Text("--format", &wanted.format, "PICTURE,UNIT,END",
               "Form of a stream's lines (+00.0000,mm,CR; numbered lines: 000,+00.0000,mm,CR); END "
               "is CR, LF or CRLF. For pipe: f64, f32, i16 or text");
  options.Text("--channels", &wanted.channels, "NAME:UNIT,...",
               "Channels of a pipe, e.g. displacement:um,voltage:V,trigger");
  options.Number("--rate", &wanted.rate_hz, Dimension::kFrequency, {},
                 "Rows per second of a pipe; of a polled sensor the largest polling rate");
  options.Text(
      "--calibration", &wanted.calibration, "FILE",
      "Calibration of the volts or counts of a pipe's channels (docs/reference/formats.md)");
  options
      .Count("--averaging", &wanted.averages, 1, 1'000'000,
             "Samples that the sensor of a stream or pipe averages in a reading; 1: none",
             cli::Shown::kHelpAll)
      .Default("as in --calibration, else unknown");
  options.Number("--sampling", &wanted.sampling_s, Dimension::kTime, {},
                 "Period of the samples that --averaging is of", cli::Shown::kHelpAll);
  options
      .Text("--speed", &wanted.speed, "recorded|max|FACTOR", "Speed of a replay or a scene",
            cli::Shown::kHelpAll)
      .Default("max for a replay, recorded for a scene");
  options
      .Text("--profile", &wanted.profile, "NAME|FILE",
            "Profile of the Modbus sensor: a built-in one (baumer-om20, ...) or a TOML file")
      .Known(Mapped<std::string>(acquire::BuiltInProfiles(), &acquire::SensorProfile::name));
  options.Count("--slave", &wanted.slave, 0, 255, "Modbus address").Default("the profile's");
  options
      .Number("--refresh", &wanted.refresh_s, Dimension::kTime, {},
              "Interval at which a Keyence refreshes its values", cli::Shown::kHelpAll)
      .Default("7 ms, of a DL-RS1A with one amplifier");
  options
      .Repeated("--set", &wanted.settings, "KEY=VALUE",
                "Change the IL amplifiers: sampling=0.33ms, averaging=1, hold=sample, "
                "high-pass=off; may be repeated",
                cli::Shown::kHelpAll)
      .Known({"sampling", "averaging", "hold", "high-pass"});
}

Result<void> CheckSensor(const SensorOptions& wanted) {
  const SensorKind* kind = FindSensorKind(wanted.sensor);
  if (kind == nullptr) {
    return Usage("--sensor", fmt::format("'{}' is not known", wanted.sensor),
                 "use one of " + SensorNames());
  }
  if (wanted.is_scene() && !wanted.port.empty()) {
    return Usage("--port", "a scene has none", "leave it out");
  }
  // options of one kind first: their messages name the sensor that they belong to
  HAPTOMETER_TRY(CheckBelonging(wanted, *kind));
  for (const std::string& setting : wanted.settings) {
    HAPTOMETER_TRY(acquire::il_setting::Parse(setting));
  }
  HAPTOMETER_TRY(ReadSpeed(wanted.speed));
  return CheckPresence(wanted, *kind);
}

// zero and settings are in the device already: a reconnection must not set them again
SensorOptions WithoutChanges(SensorOptions wanted) {
  wanted.device_zero = false;
  wanted.settings.clear();
  return wanted;
}

// recorded seconds per second; infinite for `max`
Result<double> ReadSpeed(const std::string& speed) {
  if (speed == "max") return std::numeric_limits<double>::infinity();
  if (speed == "recorded" || speed.empty()) return 1.0;
  const auto factor = trial::ReadNumber(speed);
  if (!factor || !std::isfinite(*factor) || !(*factor > 0)) {
    return Usage("--speed", fmt::format("'{}' is not a speed", speed),
                 "write recorded, max, or a factor such as 10");
  }
  return *factor;
}

std::string PortName(const SensorOptions& wanted) {
  if (wanted.is_scene()) return wanted.sensor.substr(kScenePrefix.size());
  return wanted.port.empty() ? "standard input" : wanted.port;
}

const SensorKind* FindSensorKind(std::string_view sensor) {
  // scene:FILE is found by its prefix alone
  if (sensor.starts_with(kScenePrefix)) sensor = kScenePrefix;
  const auto* const found = std::ranges::find(kKinds, sensor, &SensorKind::name);
  return found == kKinds.end() ? nullptr : found;
}

bool IsSensor(std::string_view sensor, SensorType type) {
  const SensorKind* kind = FindSensorKind(sensor);
  return kind != nullptr && kind->type == type;
}

}  // namespace haptometer::tools
