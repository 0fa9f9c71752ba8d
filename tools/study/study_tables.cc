#include <fmt/core.h>
#include <fmt/ranges.h>

#include <iterator>

#include "tools/cli/csv_cell.h"
#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {

std::string NumberCell(const std::optional<double>& number) {
  return number ? fmt::format("{:.17g}", *number) : std::string();
}

bool IsOutlying(const StudyResult& study, const StudyTrial& trial) {
  for (const Outlying& outlying : study.outlying) {
    if (outlying.file == trial.file) return true;
  }
  return false;
}

}  // namespace

std::string LongTable(const StudyResult& study) {
  std::string text =
      "subject,condition,repeat,band_rms_m,band_rms_standard_uncertainty_m,answered,outlying,"
      "remarks,file\n";
  for (const StudyTrial& trial : study.table.trials) {
    std::vector<std::string> remarks = trial.reasons;
    remarks.insert(remarks.end(), trial.deviations.begin(), trial.deviations.end());
    fmt::format_to(
        std::back_inserter(text), "{},{},{},{},{},{:d},{:d},{},{}\n", cli::CellOf(trial.subject),
        cli::CellOf(trial.condition), cli::CellOf(trial.repeat), NumberCell(trial.rms_m),
        NumberCell(trial.rms_uncertainty_m), trial.answered, IsOutlying(study, trial),
        cli::CellOf(fmt::format("{}", fmt::join(remarks, "; "))), cli::CellOf(trial.file));
  }
  return text;
}

std::string WideTable(const StudyResult& study) {
  std::string text = "subject";
  for (const std::string& condition : study.table.conditions) {
    fmt::format_to(std::back_inserter(text), ",{},{}", cli::CellOf(condition + "_mean_m"),
                   cli::CellOf(condition + "_trials"));
  }
  text += '\n';
  for (std::size_t s = 0; s < study.table.subjects.size(); ++s) {
    text += cli::CellOf(study.table.subjects[s]);
    for (const Cell& cell : study.table.cells[s]) {
      fmt::format_to(std::back_inserter(text), ",{},{}", NumberCell(cell.mean_m()),
                     cell.trials.size());
    }
    text += '\n';
  }
  return text;
}

}  // namespace haptometer::tools
