#include "tools/study/study_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <tuple>

#include "dsp/statistics/moments.h"

namespace haptometer::tools {
namespace {

// text in front of the last run of digits that ends a name, and that number: s2 before s10
std::tuple<std::string_view, double, std::string_view> NaturalKey(const std::string& name) {
  std::size_t digits = name.size();
  while (digits > 0 && std::isdigit(static_cast<unsigned char>(name[digits - 1])) != 0) --digits;
  const double number = digits < name.size() ? std::stod(name.substr(digits)) : -1;
  return {std::string_view(name).substr(0, digits), number, name};
}

std::vector<std::string> Sorted(const std::set<std::string>& names) {
  std::vector<std::string> sorted(names.begin(), names.end());
  std::ranges::sort(sorted, {}, NaturalKey);
  return sorted;
}

void RefuseUnlabelled(std::vector<StudyTrial>& trials) {
  for (StudyTrial& trial : trials) {
    if (trial.error || (!trial.subject.empty() && !trial.condition.empty())) continue;
    const std::string_view missing = trial.subject.empty() ? "subject" : "condition";
    trial.error =
        Error{Cause::kCannotAnswer, trial.file, fmt::format("has no label {}", missing),
              fmt::format("say haptometer trial label {} {}=..., or give a pattern of the names",
                          trial.file, missing)};
    trial.answered = false;
    trial.reasons.push_back(trial.error->Text());
  }
}

// numbers repeats that are not labelled, in the order of the files
void NumberRepeats(std::vector<StudyTrial>& trials) {
  std::map<std::pair<std::string, std::string>, std::set<std::string>> taken;
  for (const StudyTrial& trial : trials) {
    if (!trial.repeat.empty()) taken[{trial.subject, trial.condition}].insert(trial.repeat);
  }
  std::set<std::tuple<std::string, std::string, std::string>> seen;
  for (StudyTrial& trial : trials) {
    if (trial.error) continue;
    auto& names = taken[{trial.subject, trial.condition}];
    for (int k = 1; trial.repeat.empty(); ++k) {
      if (names.insert(std::to_string(k)).second) trial.repeat = std::to_string(k);
    }
    if (seen.emplace(trial.subject, trial.condition, trial.repeat).second) continue;
    trial.error = Error{Cause::kCannotAnswer, trial.file,
                        fmt::format("is a second repeat {} of subject {} in {}", trial.repeat,
                                    trial.subject, trial.condition),
                        "mend the labels, or leave one out of the files"};
    trial.answered = false;
    trial.reasons.push_back(trial.error->Text());
  }
}

void FillCells(StudyTable& table) {
  const auto place = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  table.cells.assign(table.subjects.size(), std::vector<Cell>(table.conditions.size()));
  for (std::size_t i = 0; i < table.trials.size(); ++i) {
    const StudyTrial& trial = table.trials[i];
    if (trial.subject.empty() || trial.condition.empty()) continue;
    Cell& cell =
        table.cells[place(table.subjects, trial.subject)][place(table.conditions, trial.condition)];
    if (!trial.answered || !(*trial.rms_m > 0)) {
      ++cell.not_answered;
      continue;
    }
    cell.trials.push_back(i);
    cell.rms_m.push_back(*trial.rms_m);
    table.repeats = std::max(table.repeats, cell.trials.size());
  }
}

}  // namespace

std::optional<double> Cell::mean_m() const {
  return rms_m.empty() ? std::nullopt : std::optional(dsp::Mean(rms_m));
}

std::optional<double> Cell::mean_log() const {
  if (rms_m.empty()) return std::nullopt;
  std::vector<double> logs(rms_m.size());
  std::ranges::transform(rms_m, logs.begin(), [](double x) { return std::log(x); });
  return dsp::Mean(logs);
}

std::optional<std::size_t> StudyTable::Condition(const std::string& name) const {
  const auto found = std::ranges::find(conditions, name);
  if (found == conditions.end()) return std::nullopt;
  return static_cast<std::size_t>(found - conditions.begin());
}

std::vector<double> StudyTable::Logs(std::size_t subject, std::size_t condition) const {
  const Cell& cell = cells[subject][condition];
  std::vector<double> logs(cell.rms_m.size());
  std::ranges::transform(cell.rms_m, logs.begin(), [](double x) { return std::log(x); });
  return logs;
}

dsp::CompleteTable StudyTable::Complete(std::optional<double> (Cell::*mean)() const,
                                        std::vector<std::size_t>* whole) const {
  whole->clear();
  for (std::size_t s = 0; s < subjects.size(); ++s) {
    const bool has_all =
        std::ranges::none_of(cells[s], [](const Cell& cell) { return cell.rms_m.empty(); });
    if (has_all) whole->push_back(s);
  }
  dsp::CompleteTable table(whole->size(), conditions.size());
  for (std::size_t row = 0; row < whole->size(); ++row) {
    for (std::size_t c = 0; c < conditions.size(); ++c) {
      table.At(row, c) = *(cells[(*whole)[row]][c].*mean)();
    }
  }
  return table;
}

StudyTable MakeStudyTable(std::vector<StudyTrial> trials, const std::vector<std::string>& first) {
  StudyTable table;
  table.trials = std::move(trials);
  RefuseUnlabelled(table.trials);
  NumberRepeats(table.trials);
  std::set<std::string> subjects;
  std::set<std::string> conditions;
  for (const StudyTrial& trial : table.trials) {
    if (!trial.subject.empty()) subjects.insert(trial.subject);
    if (!trial.condition.empty()) conditions.insert(trial.condition);
  }
  for (const std::string& name : first) {
    if (conditions.erase(name) > 0) table.conditions.push_back(name);
  }
  for (std::string& name : Sorted(conditions)) table.conditions.push_back(std::move(name));
  table.subjects = Sorted(subjects);
  FillCells(table);
  return table;
}

}  // namespace haptometer::tools
