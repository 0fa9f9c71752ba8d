// trial info: what a recording holds.
#include "tools/cli/import_words.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/trial/info_output.h"
#include "tools/trial/words.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {
namespace {

constexpr cli::VerbText kText{
    .name = "trial info",
    .summary = "What a recording holds: channels, rows, times, gaps, labels, losses.",
    .examples = {"haptometer trial info trial.bin", "haptometer trial info trial.bin --json",
                 "haptometer trial info scope.csv --columns time_s,displacement_mm"}};

}  // namespace

int RunTrialInfo(int argc, const char* const* argv) {
  std::string path;
  cli::ImportWords import;
  cli::Options options(kText);
  options.Positional("file", &path, "trial.bin, CSV with time_s, LabVIEW .lvm, HDF5");
  cli::DeclareImport(&options, &import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto wanted = cli::ImportOf(import);
  if (!wanted) return cli::ReportError(kText.name, wanted.error());
  const auto recording = trial::ReadRecording(path, *wanted);
  if (!recording) return cli::ReportError(kText.name, recording.error());
  if (options.json()) {
    PrintTrialInfoJson(path, *recording);
  } else {
    PrintTrialInfo(path, *recording);
  }
  return 0;
}

}  // namespace haptometer::tools
