#include <fmt/core.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "base/nearest.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/trial_info.h"
#include "tools/verbs.h"
#include "trial/append_event.h"
#include "trial/block.h"
#include "trial/byte_sink.h"
#include "trial/export/csv.h"
#include "trial/read_recording.h"

namespace haptometer::tools {
namespace {

constexpr cli::VerbText kInfo{
    .name = "trial info",
    .summary = "What a recording holds: channels, rows, times, gaps, labels, losses.",
    .examples = {"haptometer trial info trial.bin", "haptometer trial info trial.bin --json",
                 "haptometer trial info impulse.csv"}};

constexpr cli::VerbText kLabel{
    .name = "trial label",
    .summary = "Add labels to a trial; the last word on a label counts.",
    .examples = {"haptometer trial label trial.bin subject=3",
                 "haptometer trial label trial.bin subject=3 condition=stock",
                 "haptometer trial label trial.bin 'condition=with adapter'"}};

constexpr cli::VerbText kExport{
    .name = "trial export",
    .summary = "Write a recording as CSV in SI units, to stdout or a file.",
    .examples = {"haptometer trial export trial.bin",
                 "haptometer trial export trial.bin -o trial.csv",
                 "haptometer trial export trial.bin | head"}};

int Info(int argc, const char* const* argv) {
  std::string path;
  cli::Options options(kInfo);
  options.Positional("file", &path, "trial.bin, or a CSV with time_s");
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto recording = trial::ReadRecording(path);
  if (!recording) return cli::ReportError(kInfo.name, recording.error());
  if (options.json()) {
    PrintTrialInfoJson(path, *recording);
  } else {
    PrintTrialInfo(path, *recording);
  }
  return 0;
}

// "subject=3" into `event`; a later word on the same key counts
Result<void> TakeLabel(const std::string& text, trial::Event* event) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    return Usage(text, "is no label", "write it as key=value, for example subject=3");
  }
  event->labels[text.substr(0, equals)] = text.substr(equals + 1);
  return {};
}

int Label(int argc, const char* const* argv) {
  std::string path;
  std::vector<std::string> labels;
  cli::Options options(kLabel);
  options.Positional("file", &path, "trial.bin");
  options.Positionals("labels", &labels, "key=value ...");
  if (const auto status = options.Parse(argc, argv)) return *status;
  trial::Event event;
  event.kind = trial::EventKind::kLabels;
  for (const std::string& label : labels) {
    if (auto taken = TakeLabel(label, &event); !taken) {
      return cli::ReportError(kLabel.name, taken.error());
    }
  }
  if (auto done = trial::AppendEvent(path, event); !done) {
    Error error = done.error();
    // a CSV has its labels in its own lines
    if (error.what == "is no trial" && trial::ReadRecording(path)) {
      error.what = "is a CSV";
      error.remedy = "write the label into it, as a line '# label.subject = 3' above the columns";
    }
    return cli::ReportError(kLabel.name, error);
  }
  if (options.json()) {
    const auto recording = trial::ReadRecording(path);
    if (!recording) return cli::ReportError(kLabel.name, recording.error());
    PrintTrialInfoJson(path, *recording);
  }
  return 0;
}

// a text sink that writes to stdout
Result<void> ToStdout(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) {
    return {};
  }
  return Failed("stdout", std::string("could not be written: ") + std::strerror(errno),
                "say -o FILE to write to a file");
}

Result<void> ExportToFile(const trial::Record& record, const std::string& path, bool overwrite) {
  auto sink =
      trial::CreateFileSink(path, overwrite ? trial::IfExists::kReplace : trial::IfExists::kRefuse);
  if (!sink) return std::unexpected(sink.error());
  auto done = trial::WriteCsv(record, [&](std::string_view text) {
    return trial::WriteAll(sink->get(), trial::BytesOfText(text));
  });
  if (done) done = (*sink)->Sync();
  if (done) return {};
  return Failed(path, "could not be written whole: " + done.error().what,
                "make room and export again; the trial itself is unchanged");
}

int Export(int argc, const char* const* argv) {
  std::string path;
  std::string output;
  bool overwrite = false;
  cli::Options options(kExport);
  options.Positional("file", &path, "trial.bin, or a CSV with time_s");
  options.Text("-o,--output", &output, "FILE", "Write to FILE instead of stdout");
  options.Flag("--overwrite", &overwrite, "Replace FILE where it exists");
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (options.json()) {
    return cli::ReportError(kExport.name, {Cause::kUsage, "--json", "does not go with an export",
                                           "say haptometer trial info FILE --json"});
  }
  const auto recording = trial::ReadRecording(path);
  if (!recording) return cli::ReportError(kExport.name, recording.error());
  // what the CSV cannot say
  for (const trial::Loss& loss : recording->report.losses) {
    cli::Remark(kExport.name, path + ": " + Describe(loss));
  }
  const auto done = output.empty() ? trial::WriteCsv(recording->record, ToStdout)
                                   : ExportToFile(recording->record, output, overwrite);
  if (!done) return cli::ReportError(kExport.name, done.error());
  return 0;
}

void PrintHelp() {
  fmt::print("What a recording holds; label it, export it.\n\n");
  for (const cli::VerbText& text : {kInfo, kLabel, kExport}) {
    fmt::print("  haptometer {:<13} {}\n", text.name, text.summary);
  }
  fmt::print("\nExamples:\n  {}\n  {}\n  {}\n", kInfo.examples[0], kLabel.examples[1],
             kExport.examples[1]);
}

}  // namespace

int RunTrial(int argc, const char* const* argv) {
  const std::string word = argc > 1 ? argv[1] : "--help";
  if (word == "info") return Info(argc - 1, argv + 1);
  if (word == "label") return Label(argc - 1, argv + 1);
  if (word == "export") return Export(argc - 1, argv + 1);
  if (word == "--help" || word == "-h" || word == "--help-all") {
    PrintHelp();
    return argc > 1 ? 0 : 2;
  }
  const std::string nearest = Nearest(word, {"info", "label", "export"});
  return cli::ReportError("trial",
                          {Cause::kUsage, word, "is not something trial can do",
                           nearest.empty() ? "see haptometer trial --help"
                                           : fmt::format("did you mean trial {}?", nearest)});
}

}  // namespace haptometer::tools
