// study linearity FILES|CSV: RMS against the drive's amplitude.
#include <fmt/core.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tools/cli/band_question.h"
#include "tools/cli/import_words.h"
#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/study/linearity_result.h"
#include "tools/study/study_trial.h"
#include "tools/study/text_table.h"
#include "tools/study/words.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "study linearity";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary = "Whether the RMS goes in a line with the drive's amplitude.",
    .examples = {"haptometer study linearity sweep/*.bin",
                 "haptometer study linearity sweep.csv --floor 0.8um --plot linearity.svg",
                 "haptometer study linearity sweep/*.bin --json"}};

struct Wanted {
  std::vector<std::string> files;
  std::optional<Quantity> floor_m;
  std::string plot;
  cli::BandWords band;
  cli::ImportWords import;
};

// what could be read, and the status of what could not
struct Readings {
  std::vector<DriveReading> readings;
  int status = 0;
};

// a table that has its RMS already, told by its header
bool IsSweepTable(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".csv") return false;
  return ReadTextTable(path, {"drive_v", "rms_m"}).has_value();
}

Result<void> TakeTable(const std::string& path, Readings& taken) {
  const auto table = ReadTextTable(path, {"drive_v", "rms_m"});
  if (!table) return std::unexpected(table.error());
  const auto drive = NumbersOf(*table, "drive_v");
  if (!drive) return std::unexpected(drive.error());
  const auto rms = NumbersOf(*table, "rms_m");
  if (!rms) return std::unexpected(rms.error());
  const auto text = [&](const std::string& column, std::size_t row) {
    const auto found = table->columns.find(column);
    return found == table->columns.end() ? std::string() : found->second[row];
  };
  for (std::size_t i = 0; i < table->rows(); ++i) {
    if ((*drive)[i] < 0 || (*rms)[i] < 0) {
      return CannotAnswer(fmt::format("{}:{}", path, table->lines[i]),
                          "has a negative amplitude or RMS", "mend that line");
    }
    taken.readings.push_back({text("subject", i), text("condition", i), (*drive)[i], (*rms)[i]});
  }
  return {};
}

// Errors are reported; the other trials are still used. The floor is taken off all of them alike,
// by AnalyzeLinearity, so none is taken off here.
void TakeTrial(const StudyTrial& trial, Readings& taken) {
  std::optional<Error> error = trial.error;
  if (!error && !trial.rms_with_floor_m) {
    error = Error{Cause::kCannotAnswer, trial.file,
                  trial.reasons.empty() ? "has no RMS" : trial.reasons.front(), ""};
  }
  if (!error && (!trial.drive_v || !(*trial.drive_v >= 0))) {
    error = Error{Cause::kCannotAnswer, trial.file, "does not say its drive_amplitude_v",
                  "give a table with drive_v,rms_m"};
  }
  if (error) {
    taken.status = cli::WorseStatus(taken.status, cli::ReportError(kVerb, *error));
    return;
  }
  taken.readings.push_back(
      {trial.subject, trial.condition, *trial.drive_v, *trial.rms_with_floor_m});
}

Result<Readings> Read(const Wanted& wanted) {
  const auto question = cli::BandQuestionOf(wanted.band);
  if (!question) return std::unexpected(question.error());
  const auto import = cli::ImportOf(wanted.import);
  if (!import) return std::unexpected(import.error());
  Readings taken;
  std::vector<TrialFile> trials;
  for (const std::string& path : wanted.files) {
    if (!IsSweepTable(path)) {
      trials.push_back({.path = path, .labels = {}, .error = {}});
      continue;
    }
    if (auto read = TakeTable(path, taken); !read) {
      taken.status = cli::WorseStatus(taken.status, cli::ReportError(kVerb, read.error()));
    }
  }
  for (const StudyTrial& trial : AnalyzeTrials(trials, *question, *import)) {
    TakeTrial(trial, taken);
  }
  return taken;
}

}  // namespace

int RunStudyLinearity(int argc, const char* const* argv) {
  cli::Options options(kText);
  Wanted wanted;
  options.Positionals("files", &wanted.files,
                      "Trials that say their drive_amplitude_v, or CSV with drive_v,rms_m");
  options.Number("--floor", &wanted.floor_m, Dimension::kLength,
                 "RMS with the drive off, subtracted in power (default: the readings at 0 V)");
  options.Output("--plot", &wanted.plot, "FILE.svg|png|pdf", "Draw RMS against drive");
  cli::DeclareBand(&options, &wanted.band, cli::Shown::kHelpAll);
  cli::DeclareImport(&options, &wanted.import);
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (!wanted.plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(wanted.plot); !drawable) {
      return cli::ReportError(kVerb, drawable.error());
    }
  }
  const auto taken = Read(wanted);
  if (!taken) return cli::ReportError(kVerb, taken.error());
  if (taken->readings.empty()) return taken->status;
  const LinearityResult result = AnalyzeLinearity(
      taken->readings, wanted.floor_m ? std::optional(wanted.floor_m->value) : std::nullopt);
  cli::Print(options.json() ? LinearityJson(result) : LinearityText(result));
  int status = taken->status;
  for (const DriveLine& line : result.lines) {
    if (!line.line) status = cli::WorseStatus(status, ExitStatus(Cause::kCannotAnswer));
  }
  if (wanted.plot.empty()) return status;
  if (auto drawn = plot::DrawPanels(wanted.plot, LinearityPanels(result)); !drawn) {
    return cli::ReportError(kVerb, drawn.error());
  }
  return status;
}

}  // namespace haptometer::tools
