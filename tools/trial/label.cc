// trial label: labels given after the recording.
#include <fmt/core.h>

#include <string>
#include <vector>

#include "tools/cli/key_values.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/trial/info_output.h"
#include "tools/trial/words.h"
#include "trial/import/read_recording.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

constexpr cli::VerbText kLabelText{
    .name = "trial label",
    .summary = "Add labels to a trial; the last word on a label counts, the older ones are kept.",
    .examples = {"haptometer trial label trial.bin subject=3",
                 "haptometer trial label trial.bin subject=4 --reason 'wrong subject noted'",
                 "haptometer trial label trial.bin 'condition=with adapter'"}};

// a file of another kind has its labels elsewhere
Error Explained(Error error, const std::string& path) {
  if (error.what != "is no trial") return error;
  const auto other = trial::ReadRecording(path);
  if (!other || other->report.kind == trial::FileKind::kTrial) return error;
  error.what = fmt::format("is a {}", Name(other->report.kind));
  error.remedy = other->report.kind == trial::FileKind::kCsv
                     ? "write the label into it, as a line '# label.subject = 3' above the columns"
                     : "label the trial itself and export it again";
  return error;
}

Result<void> Label(const std::string& path, const std::vector<std::string>& words,
                   const std::string& reason) {
  if (words.empty()) {
    return Usage("labels", "are missing", "write them behind the file, for example subject=3");
  }
  auto labels = cli::ReadKeyValues(words, "label");
  if (!labels) return std::unexpected(labels.error());
  const trial::Event event{
      .kind = trial::EventKind::kLabels, .text = reason, .labels = std::move(*labels)};
  auto done = trial::AppendEvent(path, event);
  if (!done) return std::unexpected(Explained(done.error(), path));
  return {};
}

}  // namespace

int RunTrialLabel(int argc, const char* const* argv) {
  std::string path;
  std::string reason;
  std::vector<std::string> words;
  std::vector<std::string> more;
  cli::Options options(kLabelText);
  options.Positional("file", &path, "trial.bin");
  options.Positionals("labels", &words, "key=value ...", 0);
  // the way acquire takes them
  options.Repeated("--label", &more, "KEY=VALUE", "As the plain words", cli::Shown::kHelpAll);
  options.Text("--reason", &reason, "TEXT", "Why, kept with the labels");
  if (const auto status = options.Parse(argc, argv)) return *status;
  words.insert(words.end(), more.begin(), more.end());
  if (auto done = Label(path, words, reason); !done) {
    return cli::ReportError(kLabelText.name, done.error());
  }
  if (options.json()) {
    const auto recording = trial::ReadRecording(path);
    if (!recording) return cli::ReportError(kLabelText.name, recording.error());
    PrintTrialInfoJson(path, *recording);
  }
  return 0;
}

}  // namespace haptometer::tools
