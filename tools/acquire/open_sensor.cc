#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "acquire/protocol/keyence/dl_en1.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/stream_line.h"
#include "acquire/sensor/keyence/il_settings.h"
#include "acquire/sensor/keyence/keyence_il.h"
#include "acquire/sensor/keyence/keyence_lkg.h"
#include "acquire/sensor/modbus_profile.h"
#include "acquire/sensor/modbus_sensor.h"
#include "acquire/sensor/pipe_sensor.h"
#include "acquire/sensor/replay.h"
#include "acquire/sensor/stream_sensor.h"
#include "acquire/transport/modbus_port.h"
#include "acquire/transport/open_port.h"
#include "base/text.h"
#include "sim/sensor_model.h"
#include "tools/acquire/sensor_options.h"
#include "tools/simulate/simulated_trial.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

using acquire::Sensor;

// baud of `stream` without --baud
constexpr int kDefaultStreamBaud = 921600;

trial::Averaging AveragingOf(const SensorOptions& wanted) {
  trial::Averaging averaging;
  if (wanted.averages) averaging.averages = static_cast<int>(*wanted.averages);
  averaging.sampling_s = wanted.sampling_s;
  return averaging;
}

Result<std::unique_ptr<Sensor>> OpenStream(const SensorOptions& wanted, Clock& clock) {
  acquire::StreamSetup setup;
  setup.baud = static_cast<int>(wanted.baud.value_or(kDefaultStreamBaud));
  setup.averaging = AveragingOf(wanted);
  if (!wanted.format.empty()) {
    HAPTOMETER_LET(setup.format, acquire::ParseStreamFormat(wanted.format));
  }
  HAPTOMETER_LET(auto port, acquire::OpenPort(wanted.port, setup.baud));
  return std::make_unique<acquire::StreamSensor>(std::move(port), setup, clock);
}

// --baud and --slave override the profile; the combination is checked again as a profile
Result<std::unique_ptr<Sensor>> OpenModbus(const SensorOptions& wanted, Clock& clock) {
  HAPTOMETER_LET(auto profile, acquire::FindProfile(wanted.profile));
  if (wanted.baud) profile.wire.baud = static_cast<int>(*wanted.baud);
  if (wanted.slave) profile.wire.slave = static_cast<int>(*wanted.slave);
  if (const std::string wrong = acquire::WhatIsWrong(profile); !wrong.empty()) {
    return Usage("--profile " + wanted.profile, wrong, "give another --baud or --slave");
  }
  HAPTOMETER_LET(auto port, acquire::OpenModbusPort(wanted.port, profile.wire));
  acquire::ModbusSetup setup{.profile = std::move(profile)};
  setup.rate_hz = wanted.rate_hz;
  return std::make_unique<acquire::ModbusSensor>(std::move(port), std::move(setup), clock);
}

// samples in one of four forms at the rate of --rate, from standard input, a pipe or a file
Result<std::unique_ptr<Sensor>> OpenPipe(const SensorOptions& wanted, Clock& clock) {
  const auto format = acquire::SampleFormatFromName(wanted.format);
  if (!format) {
    return Usage("--format", fmt::format("'{}' is not a form of samples", wanted.format),
                 "use f64, f32, i16 or text");
  }
  // channels and calibration are read before the pipe is opened
  HAPTOMETER_LET(auto channels,
                 acquire::ReadPipeChannels(wanted.channels, *format, wanted.calibration));
  // the options override the calibration
  if (wanted.averages) channels.averaging = AveragingOf(wanted);
  HAPTOMETER_LET(auto pipe, acquire::OpenInputPipe(wanted.port));
  acquire::PipeSetup setup{
      .format = *format, .rate_hz = *wanted.rate_hz, .channels = std::move(channels)};
  return std::make_unique<acquire::PipeSensor>(std::move(pipe), std::move(setup), clock);
}

// baud of Keyence units without --baud
constexpr int kDefaultBaud = 9600;

int BaudOf(const SensorOptions& wanted) {
  return static_cast<int>(wanted.baud.value_or(kDefaultBaud));
}

std::optional<MonotonicNs> RefreshOf(const SensorOptions& wanted) {
  return wanted.refresh_s ? std::optional(NsFromSeconds(*wanted.refresh_s)) : std::nullopt;
}

std::optional<int> DecimalsOf(const SensorOptions& wanted) {
  return wanted.decimals ? std::optional(static_cast<int>(*wanted.decimals)) : std::nullopt;
}

// data writes of all --set options, in the order given
Result<std::vector<acquire::il_setting::Write>> WritesOf(const SensorOptions& wanted) {
  std::vector<acquire::il_setting::Write> writes;
  for (const std::string& text : wanted.settings) {
    HAPTOMETER_LET(const auto parsed, acquire::il_setting::Parse(text));
    writes.insert(writes.end(), parsed.begin(), parsed.end());
  }
  return writes;
}

Result<std::unique_ptr<Sensor>> OpenIl(const SensorOptions& wanted, Clock& clock) {
  const bool is_en1 = IsSensor(wanted.sensor, SensorType::kKeyenceEn1);
  HAPTOMETER_LET(const auto writes, WritesOf(wanted));
  // keyence-en1: what is not a file is a host, completed by the unit's own TCP port
  std::error_code error;
  const bool is_host = is_en1 && !std::filesystem::exists(wanted.port, error);
  const std::string name = is_host ? acquire::dl_en1::WithPort(wanted.port) : wanted.port;
  HAPTOMETER_LET(auto port, acquire::OpenPort(name, BaudOf(wanted)));
  acquire::KeyenceIlSetup setup{
      .baud = BaudOf(wanted),
      .refresh_ns = RefreshOf(wanted),
      .unit = is_en1 ? acquire::IlUnit::kDlEn1 : acquire::IlUnit::kDlRs1a,
      .command = wanted.command == "ms" ? acquire::dl::Command::kMs : acquire::dl::Command::kM0,
      .rate_hz = wanted.rate_hz,
      .writes = writes,
      .device_zero = wanted.device_zero,
      .decimals = DecimalsOf(wanted)};
  return std::make_unique<acquire::KeyenceIl>(std::move(port), std::move(setup), clock);
}

// m1 is the default of an LK-G: output 1 alone; m0 reads both outputs
Result<std::unique_ptr<Sensor>> OpenLkg(const SensorOptions& wanted, Clock& clock) {
  using acquire::lkg::Command;
  HAPTOMETER_LET(auto port, acquire::OpenPort(wanted.port, BaudOf(wanted)));
  const Command command = wanted.command == "m0"   ? Command::kM0
                          : wanted.command == "m2" ? Command::kM2
                                                   : Command::kM1;
  const acquire::KeyenceLkgSetup setup{.baud = BaudOf(wanted),
                                       .command = command,
                                       .rate_hz = wanted.rate_hz,
                                       .refresh_ns = RefreshOf(wanted),
                                       .decimals = DecimalsOf(wanted)};
  return std::make_unique<acquire::KeyenceLkg>(std::move(port), setup, clock);
}

// a scene's sensor, computed row by row on demand instead of read from a wire
class SceneSensor final : public acquire::Sensor {
 public:
  SceneSensor(const sim::Scene& scene, const std::string& path)
      : sensor_(*scene.sensor),
        motion_(sim::SensedMotion(scene)),
        // rows: 1 + 1e-12 keeps the last one where duration times rate is rounded down
        rows_(static_cast<std::int64_t>(std::floor(scene.duration_s.value_or(sim::kLongestRunS) *
                                                   sensor_.rate_hz * (1 + 1e-12)))) {
    // a record of one row has the channel's format and the metadata of all rows
    trial::Record record = sim::SimulateRecord(scene, 1 / sensor_.rate_hz);
    header_.timing = trial::Timing::kUniform;
    header_.rate_hz = sensor_.rate_hz;
    header_.channels = {FormatOf(record.channels.front())};
    header_.metadata = std::move(record.metadata);
    header_.metadata.fields["scene"] = Printable(path);
  }

  Result<void> Start(const std::atomic<bool>& /*stop*/) override { return {}; }
  const trial::TrialHeader& header() const override { return header_; }
  acquire::Findings Found() const override { return found; }
  // each Begin() plays the scene from its start
  MonotonicNs Begin() override {
    next_ = 0;
    return 0;
  }
  acquire::Outcome Next(acquire::Reading& reading) override {
    if (next_ >= rows_) return acquire::Outcome::kEnd;
    // reading n at sample n times samples per reading; its noise depends on seed and index only
    const trial::HeadReading read = trial::ReadingAt(
        sensor_.head, motion_, next_ * sim::SamplesPerReading(sensor_), sensor_.seed);
    reading.index = next_++;
    // as in a trial of `simulate`: NaN where the status is no measurement
    const double value_m = trial::IsMeasurement(read.status) ? read.value_m : std::nan("");
    reading.samples.assign(1, {RawOf(header_.channels.front(), value_m), read.status});
    return acquire::Outcome::kReading;
  }
  std::uint64_t discarded_bytes() const override { return 0; }

  acquire::Findings found;

 private:
  sim::Sensor sensor_;
  trial::Displacement motion_;
  std::int64_t rows_;
  std::int64_t next_ = 0;
  trial::TrialHeader header_;
};

Result<std::unique_ptr<Sensor>> OpenScene(const std::string& path) {
  HAPTOMETER_LET(auto scene, ReadPlayedScene(path));
  const bool is_ideal = !scene.sensor;
  // a scene without [sensor] gets an ideal one, with a remark
  if (is_ideal) scene.sensor = sim::IdealSensor();
  // duration times rate below 1: not one reading
  if (scene.duration_s && *scene.duration_s * scene.sensor->rate_hz < 1) {
    return CannotAnswer(path, "is shorter than one reading of its sensor",
                        "give [run] a longer duration_s");
  }
  auto sensor = std::make_unique<SceneSensor>(scene, path);
  if (is_ideal) {
    sensor->found.Note(acquire::FindingKind::kIdealSensor, {{"rate_hz", scene.sensor->rate_hz}});
  }
  return sensor;
}

// a trial or a scene at its speed
Result<std::unique_ptr<Sensor>> OpenPlayed(const SensorOptions& wanted, Clock& clock) {
  const bool is_scene = wanted.is_scene();
  HAPTOMETER_LET(auto played,
                 is_scene ? OpenScene(PortName(wanted)) : acquire::Replay::Open(wanted.port));
  // default speed: a trial is copied at full speed, a scene runs in real time
  HAPTOMETER_LET(const auto speed,
                 ReadSpeed(wanted.speed.empty() && !is_scene ? "max" : wanted.speed));
  return std::make_unique<acquire::PacedSensor>(std::move(played), speed, clock);
}

}  // namespace

Result<std::unique_ptr<Sensor>> OpenSensor(const SensorOptions& wanted, Clock& clock) {
  const SensorKind* kind = FindSensorKind(wanted.sensor);
  // CheckSensor() has refused unknown names before
  HAPTOMETER_CHECK(kind != nullptr, "sensor '{}' was not checked", wanted.sensor);
  switch (kind->type) {
    case SensorType::kKeyenceEn1:
    case SensorType::kKeyenceIl:
      return OpenIl(wanted, clock);
    case SensorType::kKeyenceLkg:
      return OpenLkg(wanted, clock);
    case SensorType::kModbus:
      return OpenModbus(wanted, clock);
    case SensorType::kPipe:
      return OpenPipe(wanted, clock);
    case SensorType::kReplay:
    case SensorType::kScene:
      return OpenPlayed(wanted, clock);
    case SensorType::kStream:
      break;
  }
  return OpenStream(wanted, clock);
}

}  // namespace haptometer::tools
