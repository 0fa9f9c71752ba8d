#include "tools/acquire/sensor_options.h"

namespace haptometer::tools {

void DeclareSensor(cli::Options& options, SensorOptions& wanted) {
  options.Text("--port", &wanted.port, "PORT",
               "Serial port, virtual terminal or HOST:PORT; for replay a trial.bin");
  options.Choice(
      "--sensor", &wanted.sensor, {"keyence-il", "modbus", "stream", "replay"},
      "keyence-il: a DL-RS1A that is asked (default); modbus: a sensor with registers, asked "
      "as its --profile says; stream: lines that come unasked");
  options.Count("--baud", &wanted.baud, 50, 4'000'000,
                "Bits per second (keyence-il: 9600; modbus: the profile's; stream: 921600)");
  options.Text("--format", &wanted.format, "PICTURE,UNIT,END",
               "Form of a stream's lines (+00.0000,mm,CR); END is CR, LF or CRLF");
  options.Text("--profile", &wanted.profile, "NAME|FILE",
               "Which Modbus sensor: a built-in one (baumer-om20, ...) or a TOML file");
  options.Count("--slave", &wanted.slave, 0, 255, "Its Modbus address (the profile's)");
  options.Number("--poll-rate", &wanted.poll_rate_hz, Dimension::kFrequency,
                 "Ask a Modbus sensor at most so often (as fast as it answers)",
                 cli::Shown::kHelpAll);
  options.Number("--refresh", &wanted.refresh_s, Dimension::kTime,
                 "How often the DL-RS1A refreshes its values (7 ms with one amplifier)",
                 cli::Shown::kHelpAll);
}

Result<void> CheckSensor(const SensorOptions& wanted) {
  if (wanted.port.empty()) {
    return Usage("--port", "is missing", "name the sensor's port, e.g. --port /dev/ttyUSB0");
  }
  if (wanted.refresh_s && !(wanted.refresh_s->value > 0)) {
    return Usage("--refresh", "must be above 0", "write e.g. 7ms");
  }
  if (!wanted.format.empty() && wanted.sensor != "stream") {
    return Usage("--format", "is for lines that come unasked", "add --sensor stream");
  }
  const bool is_modbus = wanted.sensor == "modbus";
  if (is_modbus == wanted.profile.empty()) {
    return Usage("--profile", "belongs to --sensor modbus, and that needs it",
                 "give both, e.g. --sensor modbus --profile baumer-om20");
  }
  if (!is_modbus && (wanted.slave || wanted.poll_rate_hz)) {
    return Usage(wanted.slave ? "--slave" : "--poll-rate", "is for --sensor modbus",
                 "leave it out");
  }
  if (wanted.poll_rate_hz && !(wanted.poll_rate_hz->value >= 1e-3)) {
    return Usage("--poll-rate", "must be at least 1 mHz", "write e.g. 50Hz");
  }
  return {};
}

}  // namespace haptometer::tools
