#include "tools/session/attempt.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <memory>
#include <utility>

#include "acquire/recorder/recorder.h"
#include "acquire/recorder/row_sink.h"
#include "base/clock.h"
#include "base/input_file.h"
#include "dsp/analysis/band_analysis.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/sensor_options.h"
#include "tools/analyze/analyze_question.h"
#include "tools/analyze/expectation.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/document/findings_dsp.h"
#include "tools/document/provenance.h"
#include "trial/import/read_recording.h"
#include "trial/trial_writer.h"

namespace haptometer::tools {
namespace {

constexpr cli::VerbText kSourceText{
    .name = "session", .summary = "Options of acquire behind --.", .examples = {"", "", ""}};

// the first option that the plan or the log decides, or that a session does not have
const char* Decided(const RecordingOptions& recording) {
  return !recording.output.empty()      ? "-o"
         : recording.overwrite          ? "--overwrite"
         : !recording.labels.empty()    ? "--label"
         : recording.samples            ? "--samples"
         : recording.duration_s         ? "--duration"
         : !recording.until.empty()     ? "--until"
         : !recording.reconnect.empty() ? "--reconnect"
         : recording.tare               ? "--tare"
                                        : nullptr;
}

std::string PlanHash(const SessionFolder& session) {
  for (const document::InputFile& input : document::CollectProvenance({}).inputs) {
    if (input.path == session.plan_path()) return input.sha256;
  }
  return {};
}

// the trial's header: as of acquire, with plan, cell and attempt
trial::TrialHeader HeaderOf(const acquire::Sensor& sensor, const SessionFolder& session,
                            const SessionCell& cell, std::int64_t number, bool is_replay,
                            std::string command_line) {
  trial::TrialHeader header =
      RecordingHeader(sensor, is_replay, LabelsOf(cell), std::move(command_line));
  auto& fields = header.metadata.fields;
  const auto place = std::ranges::find(session.cells(), cell) - session.cells().begin();
  fields["session.plan_sha256"] = PlanHash(session);
  fields["session.cell"] = fmt::format("{} of {}", place + 1, session.cells().size());
  fields["session.attempt"] = std::to_string(number);
  fields[std::string(trial::kExcludedField)] = cell.is_floor() ? kFloorReason : kInterruptedReason;
  return header;
}

// doubts that are of the trial and not of every trial of its sensor
void AddDoubts(const dsp::Findings& findings, std::vector<std::string>& reasons) {
  for (const dsp::Finding& found : findings.list()) {
    if (found.severity != Severity::kDoubt) continue;
    if (found.kind == dsp::FindingKind::kAveragingUnknown) continue;
    reasons.push_back(document::WordsOf(found));
  }
}

// the verdict on a finished file, by what analyze says of it
Result<AttemptOutcome> Judge(const std::string& path, const SessionPlan& plan,
                             SessionAttempt attempt) {
  AttemptOutcome outcome{
      .attempt = std::move(attempt), .reasons = {}, .band_rms_m = {}, .tone_hz = {}};
  SessionVerdict& verdict = outcome.attempt.verdict.emplace(SessionVerdict::kBad);
  HAPTOMETER_LET(const auto question, QuestionOf(AnalyzeWords{}));
  HAPTOMETER_LET(const auto opened, trial::OpenRows(path));
  const auto analysis = dsp::AnalyzeBand(*opened.rows, question);
  if (!analysis) {
    outcome.reasons = {analysis.error().Text()};
    return outcome;
  }
  const bool has_value = analysis->answered && analysis->numbers;
  if (outcome.attempt.cell.is_floor()) {
    // a floor is the noise without a drive
    if (has_value) outcome.reasons = {"a drive is on"};
    if (!has_value) verdict = SessionVerdict::kGood;
    return outcome;
  }
  if (!has_value) {
    outcome.reasons = document::RefusalsOf(analysis->findings);
    return outcome;
  }
  outcome.band_rms_m = analysis->numbers->rms.rms_m;
  if (analysis->numbers->tone) outcome.tone_hz = analysis->numbers->tone->fit.frequency_hz;
  // the limits were read with the plan
  if (!plan.expect.empty()) {
    HAPTOMETER_LET(const auto expected, ParseExpectation(plan.expect));
    const auto sources = trial::SourcesOf(opened.rows->head().metadata, opened.report);
    for (const auto& found : DeviationsFrom(expected, *analysis, sources).list()) {
      outcome.reasons.push_back(document::WordsOf(found));
    }
  }
  AddDoubts(analysis->findings, outcome.reasons);
  for (const trial::Finding& found : opened.report.AllFindings().list()) {
    if (found.severity != Severity::kNote) outcome.reasons.push_back(document::WordsOf(found));
  }
  verdict = outcome.reasons.empty() ? SessionVerdict::kGood : SessionVerdict::kCheck;
  return outcome;
}

// into a new file, which nothing is written over for
Result<acquire::RecordingSummary> Record(acquire::Sensor& sensor, const std::string& path,
                                         const trial::TrialHeader& header,
                                         const acquire::RecordingLimits& limits, Clock& clock) {
  HAPTOMETER_LET(auto writer, trial::TrialWriter::Create(path, header, {}, clock));
  acquire::SingleTrial sink(writer);
  return acquire::Record(sensor, sink, clock, cli::Interrupted(), limits, {.say = InWords});
}

// the recording and the verdict; an error of either is BAD in the log before it is reported
Result<AttemptOutcome> RecordAndJudge(acquire::Sensor& sensor, const std::string& path,
                                      const trial::TrialHeader& header,
                                      const acquire::RecordingLimits& limits, Clock& clock,
                                      const SessionPlan& plan, const SessionAttempt& attempt) {
  HAPTOMETER_LET(const auto summary, Record(sensor, path, header, limits, clock));
  HAPTOMETER_LET(auto outcome, Judge(path, plan, attempt));
  const char* fault = summary.connection_lost ? "the connection was lost"
                      : summary.interrupted   ? "stopped before its end"
                                              : nullptr;
  if (fault != nullptr) {
    outcome.attempt.verdict = SessionVerdict::kBad;
    outcome.reasons.insert(outcome.reasons.begin(), fault);
  }
  return outcome;
}

}  // namespace

Result<SessionSource> ReadSource(const SessionPlan& plan) {
  SessionSource source;
  RecordingOptions recording;
  cli::Options options(kSourceText);
  DeclareSensor(options, source.sensor);
  DeclareRecording(options, recording);
  std::vector<const char*> words{"session"};
  words.reserve(plan.source.size() + 1);
  for (const std::string& word : plan.source) words.push_back(word.c_str());
  if (options.Parse(static_cast<int>(words.size()), words.data())) return Usage("", "");
  if (const char* decided = Decided(recording)) {
    return Usage(decided, "is not an option of a session's source", "leave it out");
  }
  HAPTOMETER_TRY(CheckSensor(source.sensor));
  HAPTOMETER_LET(source.plan, PlanRecording(recording, source.sensor, std::time(nullptr)));
  source.plan.limits.duration_ns = NsFromSeconds(plan.duration_s);
  return source;
}

Result<AttemptOutcome> RecordAttempt(SessionFolder& session, const SessionCell& cell,
                                     std::string command_line) {
  HAPTOMETER_LET(const auto source, ReadSource(session.plan()));
  // reading options begins with no inputs
  NoteInput(session.plan_path());
  // the sensor first: without it there is no attempt
  SystemClock clock;
  HAPTOMETER_LET(const auto sensor, OpenSensor(source.sensor, clock));
  HAPTOMETER_TRY(sensor->Start(cli::Interrupted()));
  const std::int64_t number = session.state().NextNumber(cell);
  const trial::TrialHeader header =
      HeaderOf(*sensor, session, cell, number, IsSensor(source.sensor.sensor, SensorType::kReplay),
               std::move(command_line));
  HAPTOMETER_LET(const auto limits, LimitsOf(source.plan, header, clock));
  // a name that no file and no earlier attempt has, whatever the clock says
  auto named = header.metadata.labels;
  named["attempt"] = std::to_string(number);
  const std::string path = NewTrialName(session.trials(), UtcNow(), header.metadata.sensor, named);
  const std::string file = std::filesystem::path(path).filename();
  SessionLogLine line{.utc = {},
                      .event = SessionEvent::kBegin,
                      .cell = cell,
                      .attempt = number,
                      .file = file,
                      .verdict = {},
                      .reason = {}};
  HAPTOMETER_TRY(session.Append(line));
  auto outcome =
      RecordAndJudge(*sensor, path, header, limits, clock, session.plan(),
                     {.cell = cell, .number = number, .file = file, .verdict = {}, .reason = {}});
  // read again for the verdict, and written by this command: no input
  ForgetInput(path);
  line.event = SessionEvent::kEnd;
  line.verdict = outcome ? outcome->attempt.verdict : SessionVerdict::kBad;
  line.reason =
      outcome ? fmt::format("{}", fmt::join(outcome->reasons, "; ")) : outcome.error().Text();
  HAPTOMETER_TRY(session.Append(line));
  HAPTOMETER_TRY(session.Settle(cell));
  if (outcome) outcome->attempt.reason = line.reason;
  return outcome;
}

}  // namespace haptometer::tools
