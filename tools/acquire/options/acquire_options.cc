#include "tools/acquire/options/acquire_options.h"

#include <fmt/core.h>

#include "tools/cli/band.h"

namespace haptometer::tools {
namespace {

// a check keeps nothing, and ends by --duration alone
Result<void> CheckAlone(const AcquireOptions& wanted) {
  const RecordingOptions& recording = wanted.recording;
  const char* other = !recording.output.empty()      ? "-o"
                      : wanted.live                  ? "--live"
                      : recording.samples            ? "--samples"
                      : !recording.until.empty()     ? "--until"
                      : !recording.trigger.empty()   ? "--trigger"
                      : !recording.reconnect.empty() ? "--reconnect"
                      : recording.tare               ? "--tare"
                                                     : nullptr;
  if (other == nullptr) return {};
  return Usage("--check", fmt::format("keeps nothing and has no use for {}", other),
               "check first, then record");
}

}  // namespace

void DeclareAcquire(cli::Options& options, AcquireOptions& wanted) {
  DeclareSensor(options, wanted.sensor);
  DeclareRecording(options, wanted.recording);
  options.Flag("--live", &wanted.live,
               "Show level, band RMS and a plot; without -o nothing is kept");
  options.Flag("--check", &wanted.check,
               "Look for 10 s (--duration) whether the sensor is ready, and say what to fix");
  options.Number("--smallest-rms", &wanted.smallest_rms_m, Dimension::kLength,
                 "An RMS that --check has to find reportable to 10 %", cli::Shown::kHelpAll);
  options.Flag("--list-ports", &wanted.list_ports, "List the serial ports, and record nothing");
  options.Flag("--list-sensors", &wanted.list_sensors,
               "Say which sensors can answer --band and --resolution, and record nothing");
  options.Text("--band", &wanted.band, "LOWER-UPPERHz",
               "What --live, --check and --list-sensors ask about; 20-500Hz");
  options.Number("--resolution", &wanted.resolution_m, Dimension::kLength,
                 "For --list-sensors: largest step that is fine enough; 1um");
  DeclareDaemon(options, wanted.daemon);
}

Result<dsp::BandPass> BandOf(const AcquireOptions& wanted) {
  const auto corners = cli::ParseBand(wanted.band);
  if (!corners) return std::unexpected(corners.error());
  dsp::BandPass band;
  band.lower_hz = corners->lower_hz;
  band.upper_hz = corners->upper_hz;
  const auto possible = dsp::DesignBandPass(band, 4 * band.upper_hz);
  if (!possible) return std::unexpected(possible.error());
  return band;
}

Result<void> CheckAcquire(const AcquireOptions& wanted) {
  if (auto checked = CheckSensor(wanted.sensor); !checked) return checked;
  if (wanted.smallest_rms_m && !wanted.check) {
    return Usage("--smallest-rms", "is what a check asks for", "add --check");
  }
  if (wanted.check) return CheckAlone(wanted);
  if (!wanted.recording.output.empty()) return CheckOutput(wanted.recording);
  if (wanted.live) return {};
  return Usage("-o", "is missing",
               "name the trial to write, e.g. -o trial.bin, or look with --live or --check");
}

}  // namespace haptometer::tools
