#include "tools/session/attempt.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "acquire/recorder/recorder.h"
#include "acquire/recorder/row_sink.h"
#include "base/clock.h"
#include "base/input_file.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/readings/faults.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/sensor_options.h"
#include "tools/analyze/analyze.h"
#include "tools/analyze/analyze_question.h"
#include "tools/analyze/expectation.h"
#include "tools/cli/output_file.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_dsp.h"
#include "tools/document/provenance.h"
#include "trial/import/read_recording.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

// a recording that is shorter than this share of what is planned has ended too early
constexpr double kLeastOfDuration = 0.9;

// the trial's header: as the source has it, with plan, cell and attempt
trial::TrialHeader HeaderOf(trial::TrialHeader header, const SessionFolder& session,
                            const SessionCell& cell, std::int64_t number) {
  auto& fields = header.metadata.fields;
  auto& labels = header.metadata.labels;
  // an imported file may have labels of its own: the plan decides
  for (const char* of_plan : {"subject", "condition", "repeat"}) labels.erase(of_plan);
  labels.merge(LabelsOf(cell));
  const auto place = std::ranges::find(session.cells(), cell) - session.cells().begin();
  fields["session.plan_sha256"] = document::Sha256Of(session.plan_path());
  fields["session.cell"] = fmt::format("{} of {}", place + 1, session.cells().size());
  fields["session.attempt"] = std::to_string(number);
  // what is planned, where the sensor does not know better
  auto& frequency_hz = header.metadata.drive_frequency_hz;
  if (!frequency_hz) frequency_hz = session.plan().drive_frequency_hz;
  auto& amplitude_v = header.metadata.drive_amplitude_v;
  if (!amplitude_v) amplitude_v = session.plan().drive_amplitude_v;
  fields[std::string(trial::kExcludedField)] = cell.is_floor() ? kFloorReason : kInterruptedReason;
  return header;
}

// whether all held readings lie beside the rows that the numbers are of: a value that noise repeats
// before the drive begins is no reason
bool AreHeldBesideWindow(const dsp::BandAnalysis& analysis) {
  const dsp::UsedPart& part = analysis.numbers->part;
  const dsp::Faults& faults = analysis.faults;
  return faults.Count(dsp::FaultKind::kHeld) <= dsp::kMostListed &&
         std::ranges::none_of(faults.list, [&](const dsp::Fault& fault) {
           return fault.kind == dsp::FaultKind::kHeld &&
                  fault.first_row < part.first_row + part.rows &&
                  fault.first_row + fault.rows > part.first_row;
         });
}

// doubts that are of the trial's numbers, and not of every trial of its sensor; a limit in place of
// an RMS is one here, because a plan asks for the RMS
void AddDoubts(const dsp::BandAnalysis& analysis, std::vector<std::string>& reasons) {
  for (const dsp::Finding& found : analysis.findings.list()) {
    const bool is_limit = found.kind == dsp::FindingKind::kBelowFloor;
    if (found.severity != Severity::kDoubt && !is_limit) continue;
    if (found.kind == dsp::FindingKind::kAveragingUnknown) continue;
    if (found.kind == dsp::FindingKind::kHeld && AreHeldBesideWindow(analysis)) continue;
    reasons.push_back(document::WordsOf(found));
  }
}

// a floor is the noise without a drive
void JudgeFloor(const std::string& path, const dsp::BandQuestion& question, bool has_value,
                AttemptOutcome& outcome) {
  if (has_value) {
    outcome.reasons = {"a drive is on"};
  } else if (const auto floor = ReadFloor(path, question, {}, 1); floor) {
    outcome.attempt.verdict = SessionVerdict::kGood;
  } else {
    outcome.reasons = {floor.error().Text()};
  }
}

// where a trial with a value differs from the plan, or is doubted
void JudgeValue(const SessionPlan& plan, const SessionState& state, const trial::OpenedRows& opened,
                const dsp::BandAnalysis& analysis, AttemptOutcome& outcome) {
  const dsp::BandNumbers& numbers = *analysis.numbers;
  if (!numbers.rms.below_floor && !numbers.is_lower_limit) {
    outcome.band_rms_m = numbers.rms.rms_m;
    outcome.band_rms_uncertainty_m = numbers.rms.standard_uncertainty_m;
  }
  if (numbers.tone) {
    outcome.tone_hz = numbers.tone->fit.frequency_hz;
    outcome.tone_uncertainty_hz =
        (numbers.tone->frequency_upper_hz - numbers.tone->frequency_lower_hz) /
        4;  // a 95 % interval
  }
  const auto sources = trial::SourcesOf(opened.rows->head().metadata, opened.report);
  const auto deviations = DeviationsFrom(ExpectationOf(plan), analysis, sources,
                                         state.RepeatsRms(outcome.attempt.cell));
  for (const auto& found : deviations.list()) outcome.reasons.push_back(document::WordsOf(found));
  AddDoubts(analysis, outcome.reasons);
  for (const trial::Finding& found : opened.report.AllFindings().list()) {
    if (found.severity != Severity::kNote) outcome.reasons.push_back(document::WordsOf(found));
  }
  outcome.attempt.verdict =
      outcome.reasons.empty() ? SessionVerdict::kGood : SessionVerdict::kCheck;
}

// an early end, as of a pipe or an import, and what its importer doubts; gaps are data that are
// lost
void JudgeFile(const SessionPlan& plan, const trial::Metadata& metadata, double duration_s,
               AttemptOutcome& outcome) {
  const std::size_t reasons = outcome.reasons.size();
  if (duration_s < kLeastOfDuration * plan.duration_s) {
    outcome.reasons.push_back(
        fmt::format("it ended after {:.3g} of {:g} s", duration_s, plan.duration_s));
  }
  const auto doubts = metadata.fields.find(std::string(kImportDoubts));
  if (doubts != metadata.fields.end()) outcome.reasons.push_back(doubts->second);
  const bool is_good = outcome.attempt.verdict == SessionVerdict::kGood;
  if (is_good && outcome.reasons.size() > reasons) outcome.attempt.verdict = SessionVerdict::kCheck;
}

// the verdict on a finished file, by what analyze says of it; `state` has its attempt in its cell
Result<AttemptOutcome> Judge(const SessionFolder& session, const SessionState& state,
                             SessionAttempt attempt) {
  const std::string path = session.trials() + attempt.file;
  AttemptOutcome outcome{.attempt = std::move(attempt), .reasons = {}};
  outcome.attempt.verdict = SessionVerdict::kBad;
  HAPTOMETER_LET(auto question, QuestionOf(AnalyzeWords{}));
  const bool is_floor = outcome.attempt.cell.is_floor();
  const auto is_usable = [&](const SessionAttempt& one) { return session.IsUsable(one); };
  const SessionAttempt* floor = is_floor ? nullptr : state.FloorOf(outcome.attempt, is_usable);
  if (floor != nullptr) {
    HAPTOMETER_LET(question.floor, ReadFloor(session.trials() + floor->file, question, {}, 1));
    outcome.floor = floor->file;
  }
  HAPTOMETER_LET(const auto opened, trial::OpenRows(path));
  const auto analysis = dsp::AnalyzeBand(*opened.rows, question);
  const bool has_value = analysis && analysis->answered && analysis->numbers;
  if (!analysis) {
    outcome.reasons = {analysis.error().Text()};
    return outcome;
  }
  if (is_floor) {
    JudgeFloor(path, question, has_value, outcome);
  } else if (!has_value) {
    outcome.reasons = document::RefusalsOf(analysis->findings);
  } else {
    JudgeValue(session.plan(), state, opened, *analysis, outcome);
  }
  JudgeFile(session.plan(), opened.rows->head().metadata, analysis->record.duration_s, outcome);
  return outcome;
}

// the trial and the verdict on it
Result<AttemptOutcome> WriteAndJudge(const AttemptSource& source, const std::string& path,
                                     const trial::TrialHeader& header, const SessionFolder& session,
                                     const SessionAttempt& attempt) {
  HAPTOMETER_LET(const auto summary, source.write(path, header));
  HAPTOMETER_LET(auto outcome, Judge(session, session.state(), attempt));
  // how much a source that ended early gave is judged by its file
  const bool is_stopped = summary.interrupted && !summary.source_ended;
  if (!summary.connection_lost && !is_stopped) return outcome;
  outcome.attempt.verdict = SessionVerdict::kBad;
  outcome.reasons.emplace(outcome.reasons.begin(),
                          summary.connection_lost ? kConnectionLost : kStopped);
  return outcome;
}

// what cannot be read is no failure of this program: BAD, with the reason
Result<AttemptOutcome> OutcomeOf(Result<AttemptOutcome> made, const SessionAttempt& attempt) {
  if (made || made.error().cause != Cause::kCannotAnswer) return made;
  AttemptOutcome outcome{.attempt = attempt, .reasons = {made.error().Text()}};
  outcome.attempt.verdict = SessionVerdict::kBad;
  return outcome;
}

// a name that no file and no earlier attempt has, for any state of the clock
std::string NewPath(const SessionFolder& session, const SessionCell& cell, std::int64_t number,
                    const std::string& sensor) {
  auto named = LabelsOf(cell);
  named["attempt"] = std::to_string(number);
  return NewTrialName(session.trials(), UtcNow(), sensor.empty() ? "import" : sensor, named);
}

}  // namespace

Result<trial::TrialWriter> CreateTrial(const std::string& path, const trial::TrialHeader& header,
                                       Clock& clock) {
  const std::string begun = path + ".new";
  HAPTOMETER_LET(auto writer, trial::TrialWriter::Create(begun, header, {}, clock));
  // NewPath() has found the name free, and this session is locked; other programs may write there
  if (auto named = cli::RenameNew(begun, path); !named) {
    std::error_code ignored;
    std::filesystem::remove(begun, ignored);
    return std::unexpected(named.error());
  }
  return writer;
}

Result<AttemptSource> RecordingOf(acquire::Sensor& sensor, const SessionSource& source,
                                  Clock& clock, const RecordingWatch& watch,
                                  std::string command_line) {
  const bool is_replay = IsSensor(source.sensor.sensor, SensorType::kReplay);
  AttemptSource made{.header = RecordingHeader(sensor, is_replay, {}, std::move(command_line)),
                     .write = {}};
  HAPTOMETER_LET(const auto limits, LimitsOf(source.plan, made.header, clock));
  made.write = [&sensor, &clock, watch, limits](
                   const std::string& path,
                   const trial::TrialHeader& header) -> Result<acquire::RecordingSummary> {
    HAPTOMETER_LET(auto writer, CreateTrial(path, header, clock));
    acquire::SingleTrial sink(writer);
    if (watch.begun) watch.begun();
    auto summary = acquire::Record(sensor, sink, clock, watch.stop, limits,
                                   {.reading = watch.reading, .say = InWords});
    if (watch.recorded) watch.recorded();
    return summary;
  };
  return made;
}

Result<AttemptOutcome> MakeAttempt(SessionFolder& session, const SessionCell& cell,
                                   const AttemptSource& source) {
  const std::int64_t number = session.state().NextNumber(cell);
  const trial::TrialHeader header = HeaderOf(source.header, session, cell, number);
  const std::string path = NewPath(session, cell, number, header.metadata.sensor);
  SessionLogLine line{.utc = {},
                      .event = SessionEvent::kBegin,
                      .cell = cell,
                      .attempt = number,
                      .file = std::filesystem::path(path).filename(),
                      .verdict = {},
                      .reason = source.origin};
  HAPTOMETER_TRY(session.Append(line));
  const SessionAttempt attempt = session.state().attempts.back();
  auto outcome = OutcomeOf(WriteAndJudge(source, path, header, session, attempt), attempt);
  // read again for the verdict, and written by this command: no input
  ForgetInput(path);
  // an import that found no room on the disk did not end: its file is imported again
  if (!outcome && !source.origin.empty()) return outcome;
  line.event = SessionEvent::kEnd;
  line.verdict = outcome ? outcome->attempt.verdict : SessionVerdict::kBad;
  line.reason = outcome ? fmt::format("{}", fmt::join(outcome->reasons, "; "))
                        : fmt::format("{}: {}", kStopped, outcome.error().Text());
  std::error_code error;
  if (!std::filesystem::exists(path, error)) line.reason += fmt::format("; {}", kNoTrial);
  if (outcome) line.band_rms_m = outcome->band_rms_m;
  HAPTOMETER_TRY(session.Append(line));
  HAPTOMETER_TRY(session.Settle(cell));
  if (outcome) outcome->attempt = *session.state().Find(line.file);
  return outcome;
}

Result<AttemptOutcome> JudgeAs(const SessionFolder& session, const SessionAttempt& attempt,
                               const SessionCell& cell) {
  const std::string path = session.trials() + attempt.file;
  std::error_code error;
  if (attempt.is_cut_short || !std::filesystem::exists(path, error)) {
    AttemptOutcome kept{
        .attempt = attempt, .reasons = {attempt.reason}, .band_rms_m = attempt.band_rms_m};
    kept.attempt.verdict = attempt.judged;
    return kept;
  }
  // as it would be in its cell
  SessionState state = session.state();
  SessionAttempt& moved = *std::ranges::find(state.attempts, attempt.file, &SessionAttempt::file);
  moved.cell = cell;
  auto outcome = OutcomeOf(Judge(session, state, moved), moved);
  ForgetInput(path);
  return outcome;
}

Result<AttemptOutcome> RecordAttempt(SessionFolder& session, const SessionCell& cell,
                                     const SessionSource& source, std::string command_line) {
  // the sensor first: without it there is no attempt
  SystemClock clock;
  HAPTOMETER_LET(const auto sensor, OpenSensor(source.sensor, clock));
  HAPTOMETER_TRY(sensor->Start(cli::Interrupted()));
  HAPTOMETER_LET(
      const auto recording,
      RecordingOf(*sensor, source, clock, {.stop = cli::Interrupted()}, std::move(command_line)));
  return MakeAttempt(session, cell, recording);
}

}  // namespace haptometer::tools
