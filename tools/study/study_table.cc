#include "tools/study/study_table.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>
#include <mutex>
#include <set>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "base/jobs.h"
#include "base/mapped.h"
#include "base/median.h"
#include "base/text.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/window/window_remarks.h"
#include "dsp/statistics/outliers.h"
#include "tools/cli/progress.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_dsp.h"
#include "tools/results/kept_answers.h"
#include "tools/session/session_folder.h"
#include "trial/import/read_recording.h"

namespace haptometer::tools {

std::tuple<std::string_view, double, std::string_view> NaturalKey(const std::string& name) {
  std::size_t digits = name.size();
  while (digits > 0 && std::isdigit(static_cast<unsigned char>(name[digits - 1])) != 0) --digits;
  // a name without digits at its end sorts before its numbered forms
  const double number = digits < name.size() ? std::strtod(name.c_str() + digits, nullptr) : -1;
  return {std::string_view(name).substr(0, digits), number, name};
}

namespace {

std::vector<std::string> Sorted(const std::set<std::string>& names) {
  std::vector<std::string> sorted(names.begin(), names.end());
  std::ranges::sort(sorted, {}, NaturalKey);
  return sorted;
}

// a trial without subject or condition belongs to no cell
void RefuseUnlabelled(std::vector<StudyTrial>& trials) {
  for (StudyTrial& trial : trials) {
    if (trial.error || trial.excluded) continue;
    if (!trial.subject.empty() && !trial.condition.empty()) continue;
    const std::string_view missing = trial.subject.empty() ? "subject" : "condition";
    trial.error =
        Error{Cause::kCannotAnswer, trial.file, fmt::format("has no label {}", missing),
              fmt::format("use haptometer trial label {} {}=..., or give a pattern of the names",
                          trial.file, missing)};
    trial.answered = false;
  }
}

// numbers unlabelled repeats in the order of the files, with numbers that no label uses
void NumberRepeats(std::vector<StudyTrial>& trials) {
  // labelled repeats first, so that no number is given twice
  std::map<std::pair<std::string, std::string>, std::set<std::string>> taken;
  for (const StudyTrial& trial : trials) {
    // an excluded trial leaves its number to the one that was recorded in its place
    if (trial.excluded || trial.repeat.empty()) continue;
    taken[{trial.subject, trial.condition}].insert(trial.repeat);
  }
  std::set<std::tuple<std::string, std::string, std::string>> seen;
  for (StudyTrial& trial : trials) {
    if (trial.error || trial.excluded) continue;
    auto& names = taken[{trial.subject, trial.condition}];
    for (int k = 1; trial.repeat.empty(); ++k) {
      if (names.insert(std::to_string(k)).second) trial.repeat = std::to_string(k);
    }
    if (seen.emplace(trial.subject, trial.condition, trial.repeat).second) continue;
    trial.error = Error{Cause::kCannotAnswer, trial.file,
                        fmt::format("is a second repeat {} of subject {} in {}", trial.repeat,
                                    trial.subject, trial.condition),
                        "correct the labels, or leave one out of the files"};
    trial.answered = false;
  }
}

void FillCells(StudyTable& table) {
  const auto place = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  table.cells.assign(table.subjects.size(), std::vector<Cell>(table.conditions.size()));
  for (std::size_t i = 0; i < table.trials.size(); ++i) {
    const StudyTrial& trial = table.trials[i];
    if (trial.excluded || trial.subject.empty() || trial.condition.empty()) continue;
    Cell& cell =
        table.cells[place(table.subjects, trial.subject)][place(table.conditions, trial.condition)];
    // an RMS of 0 has no logarithm
    if (!trial.answered || !(*trial.rms_m > 0)) {
      ++cell.not_answered;
      continue;
    }
    cell.trials.push_back(i);
    cell.rms_m.push_back(*trial.rms_m);
    // expected repeats: the largest number of answered trials in a cell
    table.repeats = std::max(table.repeats, cell.trials.size());
  }
}

std::vector<double> Logs(const std::vector<double>& values) {
  return Mapped(values, [](double x) { return std::log(x); });
}

}  // namespace

std::optional<double> Cell::mean_m() const {
  return rms_m.empty() ? std::nullopt : std::optional(dsp::Mean(rms_m));
}

std::optional<double> Cell::mean_log() const {
  if (rms_m.empty()) return std::nullopt;
  return dsp::Mean(Logs(rms_m));
}

std::optional<std::size_t> StudyTable::Condition(const std::string& name) const {
  const auto found = std::ranges::find(conditions, name);
  if (found == conditions.end()) return std::nullopt;
  return static_cast<std::size_t>(found - conditions.begin());
}

std::vector<double> StudyTable::Logs(std::size_t subject, std::size_t condition) const {
  return tools::Logs(cells[subject][condition].rms_m);
}

dsp::CompleteTable StudyTable::Complete(std::optional<double> (Cell::*mean)() const,
                                        std::vector<std::size_t>* whole) const {
  whole->clear();
  // repeated measures need every condition of a subject: incomplete subjects are excluded
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
    if (trial.excluded) continue;
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

namespace {

// a label of manifest or pattern, else the file's own
std::string LabelOf(const TrialFile& file, const trial::Metadata& metadata,
                    const std::string& name) {
  for (const auto* labels : {&file.labels, &metadata.labels}) {
    const auto found = labels->find(name);
    if (found != labels->end()) return found->second;
  }
  return {};
}

// differences between the analysis of an answered trial and the question
void FindDeviations(const dsp::BandAnalysis& analysis, const dsp::BandQuestion& question,
                    StudyFindings& findings) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  // a lower order than asked for, because of the transients of a short record
  if (analysis.band.order != question.band.order) {
    findings.Note(StudyFinding::kOrderLowered, {{"order", analysis.band.order}});
  }
  if (analysis.findings.Has(dsp::FindingKind::kFrequencyMoves)) {
    findings.Doubt(StudyFinding::kFrequencyMoves);
  }
  if (!numbers.floor) findings.Note(StudyFinding::kNoNoiseCorrection);
  // doubts of the analysis by name; sweep, averaging and floor have words of their own, and the
  // width of one trial's interval is in the scatter between trials
  const std::vector<dsp::Finding> of_floor = dsp::FloorDoubts(numbers, analysis.record.rate_hz);
  for (const dsp::Finding& found : analysis.findings.list()) {
    const bool has_own = found.kind == dsp::FindingKind::kFrequencyMoves ||
                         found.kind == dsp::FindingKind::kAveragingUnknown ||
                         found.kind == dsp::FindingKind::kWideInterval ||
                         std::ranges::count(of_floor, found.kind, &dsp::Finding::kind) > 0;
    if (found.severity != Severity::kDoubt || has_own) continue;
    findings.Doubt(StudyFinding::kDoubtful,
                   {{"doubt", std::string(document::SentenceOf(found.kind).kind)}});
  }
  for (const dsp::Finding& doubt : of_floor) {
    findings.Doubt(StudyFinding::kFloorDoubtful, {{"doubt", document::WordsOf(doubt)}});
  }
  if (!numbers.sensor.amplitude_verified) findings.Doubt(StudyFinding::kAveragingUnknown);
}

void TakeAnalysis(const dsp::BandAnalysis& analysis, const dsp::BandQuestion& question,
                  StudyTrial& trial) {
  trial.reasons = document::RefusalsOf(analysis.findings);
  trial.has_no_drive = analysis.findings.Has(dsp::FindingKind::kNoDrive);
  // what was measured without a drive is the floor of a linearity
  if (trial.has_no_drive && analysis.numbers) {
    trial.rms_with_floor_m = analysis.numbers->rms.as_measured_m;
  }
  if (!analysis.answered || !analysis.numbers) return;
  const dsp::BandNumbers& numbers = *analysis.numbers;
  const dsp::RmsEstimate& rms = numbers.rms;
  const double floor_m = rms.floor_m.value_or(0);
  // with the floor in mean square: sqrt(rms^2 + floor^2), for the linearity over the drive
  trial.rms_with_floor_m = rms.below_floor ? rms.as_measured_m : std::hypot(rms.rms_m, floor_m);
  trial.answered = !rms.below_floor;
  // at or below the noise an RMS has an upper limit only
  if (rms.below_floor) {
    trial.findings.Refuse(StudyFinding::kBelowNoise,
                          {{"noise_m", floor_m}, {"at_most_m", rms.at_most_m}});
    return;
  }
  trial.rms_m = rms.rms_m;
  trial.rms_uncertainty_m = rms.standard_uncertainty_m;
  trial.gain_uncertainty = analysis.gain_uncertainty;
  if (numbers.tone) trial.tone_hz = numbers.tone->fit.frequency_hz;
  trial.numbers = NumbersOf(numbers);
  trial.is_of_drive = numbers.part.from_drive;
  trial.below_band_removed = numbers.below_band && numbers.below_band->modelled;
  trial.gain_corrected = numbers.sensor.divided_out;
  if (numbers.floor) trial.noise_from = numbers.floor->from;
  FindDeviations(analysis, question, trial.findings);
}

}  // namespace

StudyTrial AnalyzeTrial(const TrialFile& file, const dsp::BandQuestion& question,
                        const trial::ImportOptions& import) {
  StudyTrial trial;
  trial.file = Printable(file.path);
  const auto fail = [&](Error error) {
    if (error.where.empty()) error.where = file.path;
    trial.error = std::move(error);
    return trial;
  };
  // an error of the pattern comes before any reading
  if (file.error) return fail(*file.error);
  const auto recording = trial::ReadRecording(file.path, import);
  if (!recording) return fail(recording.error());
  const trial::Metadata& metadata = recording->record.metadata;
  trial.subject = LabelOf(file, metadata, "subject");
  trial.condition = LabelOf(file, metadata, "condition");
  trial.repeat = LabelOf(file, metadata, "repeat");
  trial.utc_start = metadata.utc_start;
  trial.drive_v = metadata.drive_amplitude_v;
  trial.sensor = metadata.sensor;
  if (!metadata.head.empty()) trial.sensor += (trial.sensor.empty() ? "" : " ") + metadata.head;
  trial.sources = trial::SourcesOf(metadata, recording->report);
  trial.excluded = trial::ExclusionOf(metadata);
  // of a session's trial its log decides, but for an exclusion by hand
  const bool is_by_hand = trial.excluded && !trial.excluded->starts_with(kSessionReason);
  if (file.excluded && !is_by_hand) {
    trial.excluded = file.excluded->empty() ? std::nullopt : file.excluded;
  }
  if (trial.excluded) return trial;
  // only the numbers are used, not the filtered samples
  dsp::BandQuestion numbers_alone = question;
  numbers_alone.keep_filtered = false;
  if (file.floor) {
    trial.floor = file.floor;
    numbers_alone.floor = *file.floor;
  }
  const auto analysis = dsp::AnalyzeBand(recording->record, numbers_alone);
  if (!analysis) return fail(analysis.error());
  TakeAnalysis(*analysis, question, trial);
  // losses and gaps of the recording that may change the RMS
  for (const trial::Finding& found : recording->report.AllFindings().list()) {
    if (found.severity == Severity::kNote) continue;
    trial.findings.Doubt(StudyFinding::kDataMissing, {{"what", document::WordsOf(found)}});
  }
  trial.is_doubtful = std::ranges::count(trial.findings.list(), Severity::kDoubt,
                                         &FindingOf<StudyFinding>::severity) > 0;
  return trial;
}

namespace {

// what decides a trial's answer beside its bytes and the question of all
std::string FurtherOf(const TrialFile& file) {
  std::string text = fmt::format("labels = {}\n", file.labels);
  if (file.excluded) text += fmt::format("excluded = {}\n", *file.excluded);
  if (file.floor) text += fmt::format("floor = {}\n", document::HashOfInput(file.floor->file));
  return text;
}

}  // namespace

Result<StudyTrial> AnalyzeTrial(const TrialFile& file, const dsp::BandQuestion& question,
                                const trial::ImportOptions& import, TrialResults& results) {
  // an error of the pattern comes before any reading
  if (file.error || !results.IsUsed()) return AnalyzeTrial(file, question, import);
  const auto compute = [&]() -> KeptAnswer {
    const StudyTrial trial = AnalyzeTrial(file, question, import);
    return {.bytes = BytesOf(trial), .is_error = trial.error.has_value()};
  };
  HAPTOMETER_LET(const auto bytes, results.Answer(file.path, FurtherOf(file), compute));
  auto trial = StudyTrialOf(bytes);
  if (!trial) return NotReadable(file.path);
  trial->file = Printable(file.path);
  if (!trial->excluded && !trial->error) trial->floor = file.floor;
  return *std::move(trial);
}

Result<std::vector<StudyTrial>> AnalyzeTrials(const std::vector<TrialFile>& files,
                                              const dsp::BandQuestion& question,
                                              const trial::ImportOptions& import,
                                              TrialResults& results, int threads) {
  const cli::Shard& shard = results.shard();
  const auto count = static_cast<std::size_t>(shard.RowsOf(files.size()));
  const auto file_of = [&](std::size_t i) -> const TrialFile& {
    return files[static_cast<std::size_t>(shard.PointOf(i))];
  };
  // inputs are noted in the order of the files, independent of the threads
  for (std::size_t i = 0; i < count; ++i) {
    if (!file_of(i).error) NoteInput(file_of(i).path);
  }
  std::vector<StudyTrial> trials(count);
  cli::Progress progress("trials");
  std::mutex progress_mutex;
  std::size_t done = 0;
  const auto make_worker = [&]() -> Worker {
    return [&](std::size_t i) -> Result<void> {
      if (cli::Interrupted()) return {};
      HAPTOMETER_LET(trials[i], AnalyzeTrial(file_of(i), question, import, results));
      const std::scoped_lock lock(progress_mutex);
      progress.Update(static_cast<double>(++done) / static_cast<double>(count));
      return {};
    };
  };
  HAPTOMETER_TRY(RunJobs(count, threads, make_worker));
  cli::LeaveIfInterrupted();
  return trials;
}

std::vector<StudyTrial> AnalyzeTrials(const std::vector<TrialFile>& files,
                                      const dsp::BandQuestion& question,
                                      const trial::ImportOptions& import) {
  auto none = TrialResults::Open({}, {}, false);
  HAPTOMETER_CHECK(none.has_value(), "no results are wanted");
  auto trials = AnalyzeTrials(files, question, import, *none,
                              cli::ThreadsOf(std::nullopt, kMostStudyThreads));
  HAPTOMETER_CHECK(trials.has_value(), "a trial's error belongs to the trial");
  return *std::move(trials);
}

namespace {

// relative standard uncertainty of an answered trial's RMS, without that of the calibration, which
// all trials of a sensor share
double RelativeUncertainty(const StudyTrial& trial) {
  const double relative = trial.rms_uncertainty_m.value_or(0) / *trial.rms_m;
  return std::sqrt(
      std::max(0.0, relative * relative - std::pow(trial.gain_uncertainty.value_or(0), 2)));
}

// of a mean: the median of its trials, which a single poor trial does not change
double RelativeUncertainty(const StudyTable& table, const Cell& cell) {
  return Median(
      Mapped(cell.trials, [&](std::size_t i) { return RelativeUncertainty(table.trials[i]); }));
}

// trials that stand apart from the repeats of their cell
void AppendOutlyingTrials(const StudyTable& table, std::vector<Outlying>& outlying) {
  std::vector<std::pair<std::size_t, std::size_t>> cells;
  std::vector<std::vector<double>> logs;
  std::vector<std::vector<double>> least;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) {
      cells.emplace_back(s, c);
      logs.push_back(table.Logs(s, c));
      // a trial with a large uncertainty of its own may deviate more
      least.push_back(Mapped(table.cells[s][c].trials, [&](std::size_t i) {
        return std::max(kLeastScatter, RelativeUncertainty(table.trials[i]));
      }));
    }
  }
  for (const dsp::Outlier& one : dsp::OutliersOfGroups(logs, least, kFalseAlarmsOfTrials)) {
    const auto [s, c] = cells[one.group];
    outlying.push_back({table.subjects[s], table.conditions[c],
                        table.trials[table.cells[s][c].trials[one.place]].file,
                        std::exp(one.deviation), one.t, one.p});
  }
}

// the mean of a cell's logarithms without trials that are named, unless all are
double MeanOfRetained(const StudyTable& table, const Cell& cell,
                      const std::vector<Outlying>& outlying) {
  std::vector<double> logs;
  for (std::size_t i = 0; i < cell.trials.size(); ++i) {
    const std::string& file = table.trials[cell.trials[i]].file;
    if (std::ranges::count(outlying, file, &Outlying::file) > 0) continue;
    logs.push_back(std::log(cell.rms_m[i]));
  }
  return logs.empty() ? *cell.mean_log() : dsp::Mean(logs);
}

// a subject's mean in one condition that fits neither subject nor condition
void AppendOutlyingCells(const StudyTable& table, std::vector<Outlying>& outlying) {
  std::vector<std::size_t> whole;
  dsp::CompleteTable means = table.Complete(&Cell::mean_log, &whole);
  dsp::CompleteTable least = means;
  for (std::size_t row = 0; row < whole.size(); ++row) {
    for (std::size_t c = 0; c < means.conditions(); ++c) {
      const Cell& cell = table.cells[whole[row]][c];
      means.At(row, c) = MeanOfRetained(table, cell, outlying);
      least.At(row, c) = std::max(kLeastScatter, RelativeUncertainty(table, cell));
    }
  }
  const double false_alarms = kFalseAlarmsOfCells + (table.repeats < 2 ? kFalseAlarmsOfTrials : 0);
  for (const dsp::Outlier& one : dsp::OutliersOfTable(means, least, false_alarms)) {
    outlying.push_back({table.subjects[whole[one.group]], table.conditions[one.place], "",
                        std::exp(one.deviation), one.t, one.p});
  }
}

// the same kind with the same numbers: reported once for all trials
bool IsSame(const FindingOf<StudyFinding>& a, const FindingOf<StudyFinding>& b) {
  return a.kind == b.kind &&
         std::ranges::equal(a.numbers, b.numbers, [](const auto& one, const auto& other) {
           return one.name == other.name && one.value == other.value;
         });
}

}  // namespace

std::vector<MissingTrials> FindMissing(const StudyTable& table) {
  std::vector<MissingTrials> missing;
  for (std::size_t s = 0; s < table.subjects.size(); ++s) {
    for (std::size_t c = 0; c < table.conditions.size(); ++c) {
      const std::size_t answered = table.cells[s][c].trials.size();
      if (answered == table.repeats && answered > 0) continue;
      missing.push_back({table.subjects[s], table.conditions[c], answered, table.repeats});
    }
  }
  return missing;
}

std::vector<Deviation> FindDeviations(const std::vector<StudyTrial>& trials) {
  std::vector<Deviation> deviations;
  for (const StudyTrial& trial : trials) {
    if (!trial.answered) continue;
    for (const FindingOf<StudyFinding>& finding : trial.findings.list()) {
      const auto is_it = [&](const Deviation& known) { return IsSame(known.finding, finding); };
      auto known = std::ranges::find_if(deviations, is_it);
      if (known == deviations.end()) known = deviations.insert(known, Deviation{finding, {}});
      known->files.push_back(trial.file);
    }
  }
  return deviations;
}

StudyFindings FindOtherFrequencies(const std::vector<StudyTrial>& trials) {
  StudyFindings findings;
  // the answered trials of each condition that have a tone
  std::map<std::string, std::vector<const StudyTrial*>> conditions;
  for (const StudyTrial& trial : trials) {
    if (trial.answered && trial.tone_hz) conditions[trial.condition].push_back(&trial);
  }
  for (const auto& [name, own] : conditions) {
    if (own.size() < 3) continue;
    const double median_hz =
        Median(Mapped(own, [](const StudyTrial* trial) { return *trial->tone_hz; }));
    const auto is_other = [&](const StudyTrial* trial) {
      return std::abs(*trial->tone_hz / median_hz - 1) > kOtherFrequencyShare;
    };
    // a condition of many frequencies has no median that its trials should have
    const auto others = static_cast<std::size_t>(std::ranges::count_if(own, is_other));
    if (2 * others >= own.size()) continue;
    for (const StudyTrial* trial : own) {
      if (!is_other(trial)) continue;
      findings.Add({Severity::kDoubt,
                    StudyFinding::kOtherFrequency,
                    {{"frequency_hz", *trial->tone_hz}, {"median_hz", median_hz}},
                    trial->file});
    }
  }
  return findings;
}

std::vector<Outlying> FindOutlying(const StudyTable& table) {
  std::vector<Outlying> outlying;
  AppendOutlyingTrials(table, outlying);
  AppendOutlyingCells(table, outlying);
  return outlying;
}

}  // namespace haptometer::tools
