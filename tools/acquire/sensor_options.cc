#include "tools/acquire/sensor_options.h"

namespace haptometer::tools {

void DeclareSensor(cli::Options& options, SensorOptions& wanted) {
  options.Text("--port", &wanted.port, "PORT",
               "Serial port, virtual terminal or HOST:PORT; for replay a trial.bin");
  options.Choice("--sensor", &wanted.sensor, {"keyence-il", "stream", "replay"},
                 "keyence-il: a DL-RS1A that is asked (default); stream: lines that come unasked");
  options.Count("--baud", &wanted.baud, 50, 4'000'000,
                "Bits per second (keyence-il: 9600; stream: 921600)");
  options.Text("--format", &wanted.format, "PICTURE,UNIT,END",
               "Form of a stream's lines (+00.0000,mm,CR); END is CR, LF or CRLF");
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
  return {};
}

}  // namespace haptometer::tools
