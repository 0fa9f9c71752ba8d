#include "tools/acquire/open_sensor.h"

#include "acquire/protocol/stream_line.h"
#include "acquire/sensor/replay.h"
#include "acquire/sensor/stream_sensor.h"
#include "acquire/transport/open_port.h"
#include "tools/acquire/open_keyence.h"

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

}  // namespace

Result<std::unique_ptr<Sensor>> OpenSensor(const SensorOptions& wanted, Clock& clock) {
  if (wanted.sensor == "replay") return acquire::Replay::Open(wanted.port);
  if (IsKeyence(wanted.sensor)) return OpenKeyence(wanted, clock);
  return OpenStream(wanted, clock);
}

}  // namespace haptometer::tools
