#include "tools/acquire/check/sensor_check.h"

#include <fmt/core.h>

#include <string_view>

#include "base/error.h"
#include "tools/acquire/check/check_findings.h"
#include "tools/acquire/check/check_list.h"
#include "tools/acquire/check/check_output.h"
#include "tools/acquire/check/memory_trial.h"
#include "tools/cli/command_line.h"
#include "tools/cli/interrupt.h"
#include "tools/cli/report.h"
#include "trial/record.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "acquire";
constexpr MonotonicNs kUsualDurationNs = 10 * kNsPerS;

// the command line without what asks for this check, for the next one
std::string CommandOf(const std::vector<std::string>& words) {
  std::vector<std::string> kept;
  for (std::size_t word = 0; word < words.size(); ++word) {
    if (words[word] == "--check" || words[word] == "--json") continue;
    if (words[word].starts_with("--band=")) continue;
    if (words[word] == "--band") {
      ++word;  // and its value
      continue;
    }
    kept.push_back(words[word]);
  }
  return cli::CommandLine(kept);
}

}  // namespace

int RunSensorCheck(const cli::Options& options, const AcquireOptions& wanted,
                   const dsp::BandPass& band, const std::vector<std::string>& words,
                   acquire::Sensor& sensor, Clock& clock) {
  if (!trial::DisplacementChannel(sensor.header())) {
    return cli::ReportError(kVerb, {Cause::kCannotAnswer, PortName(wanted.sensor),
                                    "has no displacement channel in metres to check",
                                    "give the calibration of its voltage"});
  }
  acquire::RecordingLimits limits;
  limits.duration_ns = wanted.recording.duration_s
                           ? NsFromSeconds(wanted.recording.duration_s->value)
                           : kUsualDurationNs;
  const auto trial = RecordInMemory(sensor, clock, cli::Interrupted(), limits);
  if (!trial) return cli::ReportError(kVerb, trial.error());
  CheckQuestion question{.band = band, .command = CommandOf(words), .smallest_rms_m = {}};
  if (wanted.smallest_rms_m) question.smallest_rms_m = wanted.smallest_rms_m->value;
  const CheckFindings findings = FindingsOf(trial->record, trial->summary, band);
  const std::vector<CheckItem> items = CheckList(sensor.header(), findings, question);
  cli::Print(options.json() ? CheckJson(sensor.header(), findings, question, items)
                            : CheckText(items));
  return cli::InterruptedStatus(IsReady(items) ? 0 : ExitStatus(Cause::kCannotAnswer));
}

}  // namespace haptometer::tools
