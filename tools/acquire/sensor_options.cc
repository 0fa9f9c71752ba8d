#include "tools/acquire/sensor_options.h"

#include <fmt/core.h>

#include <utility>

#include "tools/acquire/open_keyence.h"

namespace haptometer::tools {

void DeclareSensor(cli::Options& options, SensorOptions& wanted) {
  options.Text("--port", &wanted.port, "PORT",
               "Serial port, virtual terminal or HOST:PORT; for replay a trial.bin");
  options.Choice("--sensor", &wanted.sensor,
                 {"keyence-en1", "keyence-il", "keyence-lkg", "stream", "replay"},
                 "keyence-il: a DL-RS1A that is asked (default); keyence-en1: a DL-EN1 (TCP); "
                 "keyence-lkg: an LK-G3001; stream: lines that come unasked");
  options.Count("--baud", &wanted.baud, 50, 4'000'000,
                "Bits per second (keyence-il, keyence-lkg: 9600; stream: 921600)");
  options.Choice("--command", &wanted.command, {"m0", "m1", "m2", "ms"},
                 "What a Keyence is asked: m0 (default), ms (with the outputs); keyence-lkg: m1 "
                 "(default), m2, m0",
                 cli::Shown::kHelpAll);
  options.Count("--decimals", &wanted.decimals, 0, 5,
                "Of a value in mm, where a DL-EN1 or LK-G does not tell", cli::Shown::kHelpAll);
  options.Flag("--device-zero", &wanted.device_zero,
               "Shift the zero of the IL amplifiers to where they look now", cli::Shown::kHelpAll);
  options.Text("--format", &wanted.format, "PICTURE,UNIT,END",
               "Form of a stream's lines (+00.0000,mm,CR); END is CR, LF or CRLF");
  options.Number("--refresh", &wanted.refresh_s, Dimension::kTime,
                 "How often a Keyence refreshes its values (DL-RS1A with one amplifier: 7 ms)",
                 cli::Shown::kHelpAll);
  options.Number("--rate", &wanted.rate_hz, Dimension::kFrequency,
                 "Poll so often at most (as fast as the wire goes)");
  options.Repeated("--set", &wanted.settings, "KEY=VALUE",
                   "Change the IL amplifiers: sampling=0.33ms, averaging=1, hold=sample, "
                   "high-pass=off; may be repeated",
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
  if (wanted.rate_hz && !(wanted.rate_hz->value > 0)) {
    return Usage("--rate", "must be above 0", "write e.g. 50Hz");
  }
  if (wanted.rate_hz && (wanted.sensor == "stream" || wanted.sensor == "replay")) {
    return Usage("--rate",
                 fmt::format("{} is not asked, so it cannot be asked less often", wanted.sensor),
                 "leave it out");
  }
  if (auto checked = CheckKeyence(wanted); !checked) return checked;
  return {};
}

SensorOptions WithoutChanges(SensorOptions wanted) {
  wanted.device_zero = false;
  wanted.settings.clear();
  return wanted;
}

}  // namespace haptometer::tools
