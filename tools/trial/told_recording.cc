#include "tools/trial/told_recording.h"

#include <fmt/core.h>

#include "tools/cli/report.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {

Result<trial::Recording> ReadAndTell(std::string_view verb, const std::string& path,
                                     const trial::ImportOptions& import) {
  auto recording = trial::ReadRecording(path, import);
  if (!recording) return recording;
  for (const trial::Loss& loss : recording->report.losses) {
    cli::Remark(verb, fmt::format("{}: {}", path, Describe(loss)));
  }
  for (const std::string& remark : recording->report.remarks) {
    cli::Remark(verb, fmt::format("{}: {}", path, remark));
  }
  return recording;
}

}  // namespace haptometer::tools
