#include "tools/acquire/open_sensor.h"

#include <fmt/core.h>

#include "acquire/protocol/stream_line.h"
#include "acquire/sensor/modbus_profile.h"
#include "acquire/sensor/modbus_sensor.h"
#include "acquire/sensor/pipe_sensor.h"
#include "acquire/sensor/replay.h"
#include "acquire/sensor/stream_sensor.h"
#include "acquire/transport/modbus_port.h"
#include "acquire/transport/open_port.h"
#include "base/error.h"
#include "tools/acquire/open_keyence.h"
#include "tools/acquire/scene_sensor.h"
#include "tools/acquire/sensor_kind.h"

namespace haptometer::tools {
namespace {

using acquire::Sensor;

constexpr int kDefaultStreamBaud = 921600;

Result<std::unique_ptr<Sensor>> OpenStream(const SensorOptions& wanted, Clock& clock) {
  acquire::StreamSetup setup;
  setup.baud = static_cast<int>(wanted.baud.value_or(kDefaultStreamBaud));
  if (!wanted.format.empty()) {
    const auto format = acquire::ParseStreamFormat(wanted.format);
    if (!format) return std::unexpected(format.error());
    setup.format = *format;
  }
  auto port = acquire::OpenPort(wanted.port, setup.baud);
  if (!port) return std::unexpected(port.error());
  return std::make_unique<acquire::StreamSensor>(std::move(*port), setup, clock);
}

// options beat the profile
Result<std::unique_ptr<Sensor>> OpenModbus(const SensorOptions& wanted, Clock& clock) {
  auto profile = acquire::FindProfile(wanted.profile);
  if (!profile) return std::unexpected(profile.error());
  if (wanted.baud) profile->wire.baud = static_cast<int>(*wanted.baud);
  if (wanted.slave) profile->wire.slave = static_cast<int>(*wanted.slave);
  if (const std::string wrong = acquire::WhatIsWrong(*profile); !wrong.empty()) {
    return Usage("--profile " + wanted.profile, wrong, "give another --baud or --slave");
  }
  auto port = acquire::OpenModbusPort(wanted.port, profile->wire);
  if (!port) return std::unexpected(port.error());
  acquire::ModbusSetup setup{.profile = std::move(*profile)};
  if (wanted.rate_hz) setup.rate_hz = wanted.rate_hz->value;
  return std::make_unique<acquire::ModbusSensor>(std::move(*port), std::move(setup), clock);
}

Result<std::unique_ptr<Sensor>> OpenPipe(const SensorOptions& wanted, Clock& clock) {
  const auto format = acquire::SampleFormatFromName(wanted.format);
  if (!format) {
    return Usage("--format", fmt::format("'{}' is no form of samples", wanted.format),
                 "use f64, f32, i16 or text");
  }
  auto channels = acquire::ReadPipeChannels(wanted.channels, *format, wanted.calibration);
  if (!channels) return std::unexpected(channels.error());
  auto pipe = acquire::InputPipe::Open(wanted.port);
  if (!pipe) return std::unexpected(pipe.error());
  acquire::PipeSetup setup{
      .format = *format, .rate_hz = wanted.rate_hz->value, .channels = std::move(*channels)};
  return std::make_unique<acquire::PipeSensor>(std::move(*pipe), std::move(setup), clock);
}

// a trial or a scene at its speed
Result<std::unique_ptr<Sensor>> OpenPlayed(const SensorOptions& wanted, Clock& clock) {
  const bool is_scene = wanted.is_scene();
  auto played = is_scene ? OpenScene(PortName(wanted)) : acquire::Replay::Open(wanted.port);
  if (!played) return played;
  // a trial is copied, a scene is watched
  const auto speed = ReadSpeed(wanted.speed.empty() && !is_scene ? "max" : wanted.speed);
  if (!speed) return std::unexpected(speed.error());
  return std::make_unique<acquire::PacedSensor>(std::move(*played), *speed, clock);
}

}  // namespace

Result<std::unique_ptr<Sensor>> OpenSensor(const SensorOptions& wanted, Clock& clock) {
  const SensorKind* kind = FindSensorKind(wanted.sensor);
  HAPTOMETER_CHECK(kind != nullptr, "sensor '{}' was not checked", wanted.sensor);
  switch (kind->type) {
    case SensorType::kKeyenceEn1:
    case SensorType::kKeyenceIl:
    case SensorType::kKeyenceLkg:
      return OpenKeyence(wanted, clock);
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
