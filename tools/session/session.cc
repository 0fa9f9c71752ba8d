#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/alike_names.h"
#include "base/input_file.h"
#include "base/mapped.h"
#include "tools/acquire/recording.h"
#include "tools/acquire/recording_document.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/cli/verb_words.h"
#include "tools/document/keys.h"
#include "tools/document/present.h"
#include "tools/session/attempt.h"
#include "tools/session/decisions.h"
#include "tools/session/imported_trial.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_pack.h"
#include "tools/session/session_run.h"
#include "tools/session/session_source.h"
#include "tools/session/trial_headers.h"
#include "tools/session/watched_folder.h"
#include "tools/study/study_document.h"
#include "tools/verbs.h"

// session: a plan of trials, recorded one after the other, with a verdict after each.

namespace haptometer::tools {
namespace {

using document::Item;
using document::Key;
using document::Section;

// keys of more than one place
constexpr Key kAttempt{"attempt", "attempt"};
constexpr Key kPlanned{"planned"};
constexpr Key kDone{"done"};
constexpr Key kNext{"next", "next"};

// --- documents ---

Section CellSection(const SessionCell& cell) {
  Section section;
  section.Add({document::kSubject.name}, cell.subject);
  section.Add({kCondition.name}, document::TextOrNotKnown(cell.condition));
  section.Add({kRepeat.name}, cell.is_floor() ? document::Value() : document::Value(cell.repeat));
  section.Add({"is_floor"}, cell.is_floor());
  return section;
}

// subject, condition and repeat of the cell that comes next; null where all are done
void AddNext(const SessionCounts& counts, Section& section) {
  Section next = CellSection(counts.next.value_or(SessionCell{}));
  next.name = kNext.name;
  next.is_known = counts.next.has_value();
  section.sections.push_back(std::move(next));
  section.Add({"", kNext.label},
              counts.next ? NameOf(*counts.next) : std::string("nothing, all cells are done"));
}

Section FloorsSection(const SessionCounts& counts) {
  Section floors{.name = "floors"};
  floors.Add(kPlanned, counts.floors);
  floors.Add(kDone, counts.floors_done);
  if (counts.floors > 0) {
    floors.Add({"", "floors"}, fmt::format("{} of {}", counts.floors_done, counts.floors));
  }
  return floors;
}

// a row for each attempt, in the order of their beginnings
Section AttemptsSection(const SessionFolder& session) {
  Section list{.name = "attempts",
               .heading = "attempts",
               .shape = Section::Shape::kTable,
               .detail = document::Detail::kAll};
  for (const SessionAttempt& attempt : session.state().attempts) {
    const bool is_running = session.IsRunning(attempt);
    Section& row = list.sections.emplace_back();
    row.Add(document::kSubject, attempt.cell.subject);
    row.Add(kCondition, document::TextOrNotKnown(attempt.cell.condition));
    row.Add(kRepeat, attempt.cell.repeat);
    row.Add(kAttempt, attempt.number);
    row.Add({document::kVerdict.name, "verdict"},
            attempt.verdict ? document::Value(Name(*attempt.verdict)) : document::Value());
    row.Add({"is_running"}, is_running);
    row.Add({document::kBandRms.name, "RMS", document::kMetre}, attempt.band_rms_m).resolution =
        attempt.band_rms_m ? *attempt.band_rms_m * 1e-3 : 0;
    row.Add({document::kFile.name, "file"}, attempt.file);
    row.Add({document::kReasons.name, "reasons"},
            document::TextOrNotKnown(is_running ? "is being recorded" : attempt.reason));
    row.Add(document::kNotes,
            document::TextOrNotKnown(fmt::format("{}", fmt::join(attempt.notes, "; "))));
  }
  return list;
}

// a row for each cell that is skipped, or has notes without an attempt
Section RemarksSection(const Key& key, std::string_view text_name,
                       const std::vector<SessionRemark>& remarks) {
  Section list{.name = key.name,
               .heading = std::string(key.label),
               .shape = Section::Shape::kTable,
               .detail = document::Detail::kAll};
  for (const SessionRemark& remark : remarks) {
    Section& row = list.sections.emplace_back(CellSection(remark.cell));
    row.Add({"", "cell"}, NameOf(remark.cell));
    row.Add({text_name, text_name}, remark.text);
  }
  return list;
}

document::Document StatusDocument(const SessionFolder& session) {
  const SessionCounts counts = session.Counts();
  document::Document document{.verb = "session status", .title = session.folder()};
  Section& root = document.root;
  root.Add({"", "done"}, fmt::format("{} of {} trials", counts.done, counts.planned));
  root.Add(kPlanned, counts.planned);
  root.Add(kDone, counts.done);
  root.Add({"good", "GOOD"}, counts.good);
  root.Add({"check", "CHECK"}, counts.check);
  root.Add({kBadKey.name, "BAD"}, counts.bad);
  AddNext(counts, root);
  const auto add_if = [&](const Key& key, std::string_view label, std::size_t count) {
    root.Add({key.name, count > 0 ? label : ""}, count);
  };
  root.Add({"attempt_count", "attempts"}, counts.attempts);
  add_if({"skipped_count"}, "cells skipped", counts.skipped);
  const auto running = static_cast<std::size_t>(std::ranges::count_if(
      session.state().attempts,
      [&](const SessionAttempt& attempt) { return session.IsRunning(attempt); }));
  add_if({"attempts_running"}, "attempts being recorded", running);
  add_if({"attempts_not_ended"}, "attempts that did not end", counts.interrupted - running);
  add_if({"attempts_outside_plan"}, "attempts outside the plan", counts.outside);
  add_if({"damaged_lines"}, "lines of the log that are damaged", session.state().damaged_lines);
  root.sections.push_back(FloorsSection(counts));
  root.sections.push_back(AttemptsSection(session));
  root.sections.push_back(
      RemarksSection({"skipped", "skipped cells"}, "reason", session.state().skipped));
  root.sections.push_back(RemarksSection({"cell_notes", "notes of cells"}, document::kNotes.name,
                                         session.state().notes));
  return document;
}

document::Document AttemptDocument(std::string_view verb, const SessionFolder& session,
                                   const AttemptOutcome& outcome) {
  const SessionAttempt& attempt = outcome.attempt;
  document::Document document{
      .verb = std::string(verb),
      .title = std::string(Name(*attempt.verdict)) + "  " + NameOf(attempt.cell)};
  Section& root = document.root;
  root.sections.push_back(CellSection(attempt.cell));
  root.Add(kAttempt, attempt.number);
  root.Add({document::kFile.name, "file"}, session.trials() + attempt.file);
  root.Add(document::kVerdict, Name(*attempt.verdict));
  using document::Form;
  root.Add({document::kBandRms.name, "band RMS", document::kMetre, Form::kUncertain},
           outcome.band_rms_m, outcome.band_rms_uncertainty_m);
  root.Add({document::kToneFrequency.name, "tone", document::kHertz, Form::kUncertain},
           outcome.tone_hz, outcome.tone_uncertainty_hz);
  root.Add({"noise_floor", "noise floor"}, document::TextOrNotKnown(outcome.floor));
  root.Add({document::kReasons.name}, outcome.reasons);
  for (const std::string& reason : outcome.reasons) root.Add({"", "because"}, reason);
  const SessionCounts counts = session.Counts();
  AddNext(counts, root);
  root.Add({"", "done"}, fmt::format("{} of {} trials", counts.done, counts.planned));
  return document;
}

// the difference that the study can show; `spread`: relative standard deviation of the subjects'
// differences, where it is stated
void AddDetectable(const SessionPlan& plan, std::optional<double> spread, Section& root) {
  const auto effect = DetectableEffect(plan);
  const std::size_t contrasts = ContrastsOf(plan);
  root.Add({"contrast_count"}, contrasts);
  Item& item = root.Add({"detectable_effect_d_z", "difference that is shown"}, effect);
  item.resolution = 0.01;
  item.note = fmt::format(
      "standard deviations of the subjects' differences, at 80 % power: paired t at 5 %{}",
      contrasts > 1 ? fmt::format(", Holm over {} contrasts", contrasts) : "");
  if (!effect) {
    root.Find(Severity::kNote, "no-detectable-effect",
              "what difference the study can show is not determined: it takes 2 subjects and 2 "
              "conditions at least");
  }
  if (!effect || !spread) return;
  Item& share = root.Add({"detectable_difference", "", document::kShare}, *effect * *spread);
  share.label = "in percent";
  share.resolution = 1e-3;
  share.note = fmt::format("where the subjects' differences scatter by {:g} %", 100 * *spread);
}

// what of a plan should be known before the first trial
void FindInPlan(const SessionPlan& plan, Section& root) {
  for (const auto& [label, names] :
       {std::pair("subject", &plan.subjects), std::pair("condition", &plan.conditions)}) {
    for (const AlikeNames& pair : NamesAlike(*names)) {
      root.Find(
          Severity::kDoubt, "planned-names-alike",
          "the {label}s {one} and {other} differ by one letter: if they are one, plan again in "
          "another folder",
          {{"label", std::string(label)}, {"one", pair.one}, {"other", pair.other}});
    }
  }
  const Expectation expected = ExpectationOf(plan);
  if (expected.rms_m || expected.amplitude_m || expected.distance_m) return;
  root.Find(Severity::kNote, "scale-not-checked",
            "scale and polarity of the sensor are not checked: no rms, amplitude or distance is in "
            "--expect");
}

document::Document PlanDocument(const std::string& folder, const SessionPlan& plan,
                                std::optional<double> spread) {
  const std::vector<SessionCell> cells = CellsOf(plan);
  const SessionCounts counts = CountCells(cells, {});
  document::Document document{.verb = "session new", .title = folder};
  Section& root = document.root;
  root.Add({kPlanned.name, "trials"}, counts.planned);
  root.Add({"", "of"}, fmt::format("{}, {}, {}", Counted(plan.subjects.size(), "subject"),
                                   Counted(plan.conditions.size(), "condition"),
                                   Counted(static_cast<std::size_t>(plan.repeats), "repeat")));
  root.Add({document::kOrder.name, "order"}, Name(plan.order));
  root.sections.push_back(FloorsSection(counts));
  root.Add({"recording_s", "recording", document::kSecond},
           plan.duration_s * static_cast<double>(cells.size()))
      .note = "without what lies between";
  AddDetectable(plan, spread, root);
  FindInPlan(plan, root);
  AddNext(counts, root);
  return document;
}

// an error without words was reported where it arose (ReadSource)
int Report(const cli::VerbText& text, const Error& error) {
  return error.what.empty() ? ExitStatus(error.cause) : cli::ReportError(text.name, error);
}

// --- session new ---

constexpr cli::VerbText kNewText{
    .name = "session new",
    .summary = "Plan a session: write its folder, with session.toml and an empty log.",
    .examples = {"haptometer session new day1 --subjects 8 --conditions stock,adapter --repeats 3 "
                 "--duration 4s -- --port /dev/ttyUSB0",
                 "haptometer session new day1 --subjects ann,ben --conditions a,b,c --floor "
                 "per-subject --seed 7 --duration 3s --expect 'tone=225Hz+-1Hz' -- --sensor stream "
                 "--port /dev/ttyUSB1",
                 "haptometer session next day1"}};

// whether a session is to be made; help and the description of the options need no source
bool IsPlanning(int argc, const char* const* argv) {
  return argc > 1 && std::none_of(argv + 1, argv + argc, [](std::string_view word) {
           return word == "-h" || word == "--version" || word == "--describe-options" ||
                  word.starts_with("--help");
         });
}

// "10%" as a share
Result<double> ReadSpread(const std::string& text) {
  const bool is_percent = text.ends_with('%');
  const auto percent =
      ParseQuantity(std::string_view(text).substr(0, text.empty() ? 0 : text.size() - 1),
                    Dimension::kNone, "--spread");
  if (is_percent && percent && percent->exact() && percent->value > 0) return percent->value / 100;
  return Usage("--spread", fmt::format("'{}' is no share above 0", text), "write it as 10%");
}

int RunNew(int argc, const char* const* argv) {
  // what stands behind -- is acquire's
  const auto* const dashes = std::find_if(
      argv, argv + argc, [](const char* word) { return std::string_view(word) == "--"; });
  const auto own = static_cast<int>(dashes - argv);
  if (own == argc && IsPlanning(argc, argv)) {
    return cli::ReportError(
        kNewText.name, {Cause::kUsage, "--", "is missing",
                        "write the source behind it: -- --port /dev/ttyUSB0, or another sensor of "
                        "acquire, or -- --from-folder DIR --pattern '*.csv'"});
  }
  SessionPlan plan;
  std::string folder;
  std::string subjects;
  std::string conditions;
  std::string order = "balanced";
  std::string floor = "none";
  std::optional<double> duration_s;
  std::vector<std::string> contrasts;
  std::optional<double> spread;
  cli::Options options(kNewText);
  options.Positional("folder", &folder, "The new folder of the session");
  options.Text("--subjects", &subjects, "N|NAMES", "How many subjects, or their names with commas");
  options.Text("--conditions", &conditions, "NAMES", "The conditions, with commas between");
  options.Count("--repeats", &plan.repeats, 1, kMostRepeats,
                "Trials of each subject in each condition");
  options.Choice("--order", &order, {"balanced", "random", "given"},
                 "Order of the conditions: a Williams design, shuffled blocks, or as listed");
  options.Count("--seed", &plan.seed, 0, std::int64_t{1} << 53, "Of the order");
  options.Choice("--floor", &floor, {"none", "per-subject"},
                 "A trial with the drive off before each subject's trials");
  options.Number("--duration", &duration_s, Dimension::kTime, cli::Above(0), "Of each trial");
  options.Text("--expect", &plan.expect, "LIMITS",
               "What a trial has to keep to, as of analyze: 'tone=225Hz+-1Hz, change<5%'");
  options.Number("--drive-frequency", &plan.drive_frequency_hz, Dimension::kFrequency,
                 cli::Above(0), "Of the drive; the tone of a trial has to be within 1 %");
  options.Number("--drive-amplitude", &plan.drive_amplitude_v, Dimension::kVoltage, cli::Above(0),
                 "Of the drive, written into the trials");
  options
      .Repeated("--contrast", &contrasts, "TREATMENT:CONTROL",
                "What study compares; may be repeated")
      .Default("every condition against the first");
  options.Parsed(
      "--spread", "PERCENT",
      [&](const std::string& text) -> Result<void> {
        HAPTOMETER_LET(spread, ReadSpread(text));
        return {};
      },
      "Standard deviation of the subjects' differences, as 10%: what the study can show in "
      "percent");
  if (const auto status = options.Parse(own, argv)) return *status;
  const auto make = [&]() -> Result<document::Document> {
    HAPTOMETER_LET(plan.subjects, ReadSubjects(subjects));
    plan.conditions = NamesIn(conditions);
    plan.order = OrderNamed(order).value_or(plan.order);
    plan.has_floors = floor != "none";
    plan.duration_s = duration_s.value_or(0);
    HAPTOMETER_LET(plan.contrasts, ParseContrasts(contrasts));
    if (own < argc) plan.source = WithFullPaths({argv + own + 1, argv + argc});
    HAPTOMETER_TRY(CheckPlan(plan, "session"));
    HAPTOMETER_LET(const auto source, ReadSource(plan));
    HAPTOMETER_TRY(CheckSource(source, folder));
    if (source.folder) {
      HAPTOMETER_LET(const auto files, FilesIn(*source.folder));
      plan.files_before = Mapped<std::string>(files, [](const auto& file) { return TextOf(file); });
    }
    HAPTOMETER_TRY(SessionFolder::Create(folder, plan));
    return PlanDocument(folder, plan, spread);
  };
  auto document = make();
  if (!document) return Report(kNewText, document.error());
  document::Outputs outputs;
  outputs.json = options.json();
  return document::Present(*std::move(document), outputs, argc, argv);
}

// --- session status ---

constexpr cli::VerbText kStatusText{
    .name = "session status",
    .summary = "Show what of a session is done, and what comes next.",
    .examples = {"haptometer session status day1", "haptometer session status day1 --all",
                 "haptometer session status day1 --json"}};

int RunStatus(int argc, const char* const* argv) {
  std::string folder;
  document::Outputs outputs;
  cli::Options options(kStatusText);
  options.Positional("folder", &folder, "Folder of the session");
  options.Flag("--all", &outputs.all, "Print all attempts and the provenance too");
  if (const auto status = options.Parse(argc, argv)) return *status;
  outputs.json = options.json();
  const auto session = SessionFolder::Read(folder);
  if (!session) return cli::ReportError(kStatusText.name, session.error());
  document::Document document = StatusDocument(*session);
  // counted apart: the log does not know what was done to a trial by hand
  const auto by_hand = CompareHeaders(*session);
  const auto excluded = std::ranges::count(by_hand.list(), HeaderFinding::kExcludedByUser,
                                           &FindingOf<HeaderFinding>::kind);
  document.root.Add({"excluded_by_user", excluded > 0 ? "excluded by trial exclude" : ""},
                    static_cast<std::size_t>(excluded));
  document::AddFindings(document.root, by_hand);
  return document::Present(std::move(document), outputs, argc, argv);
}

// --- recording: next, redo, floor ---

using Choose = std::function<Result<SessionCell>(const SessionFolder&)>;

// how long a file of another program is waited for
constexpr double kUsualWaitS = 600;

// an attempt of the cell, from the plan's sensor or folder
Result<AttemptOutcome> Attempt(SessionFolder& session, const SessionCell& cell,
                               const std::optional<double>& wait_s, std::string command_line) {
  HAPTOMETER_LET(const auto source, ReadSource(session.plan()));
  // reading options begins with no inputs
  NoteInput(session.plan_path());
  if (source.folder) {
    return ImportAttempt(session, cell, *source.folder, wait_s.value_or(kUsualWaitS),
                         cli::Interrupted(), std::move(command_line));
  }
  if (wait_s) return Usage("--wait", "is for a source --from-folder", "leave it out");
  return RecordAttempt(session, cell, source, std::move(command_line));
}

int RunRecording(const cli::VerbText& text, const Choose& choose, int argc,
                 const char* const* argv) {
  std::string folder;
  std::optional<double> wait_s;
  document::Outputs outputs;
  cli::Options options(text);
  options.Positional("folder", &folder, "Folder of the session");
  options
      .Number("--wait", &wait_s, Dimension::kTime, cli::Within(0, kLongestTimeS),
              "How long a file of --from-folder is waited for")
      .Default("10 min");
  if (const auto status = options.Parse(argc, argv)) return *status;
  outputs.json = options.json();
  auto session = SessionFolder::Open(folder);
  if (!session) return cli::ReportError(text.name, session.error());
  const auto cell = choose(*session);
  if (!cell) return cli::ReportError(text.name, cell.error());
  cli::CatchInterrupts();
  cli::Remark(text.name, NameOf(*cell));
  const auto outcome = Attempt(*session, *cell, wait_s, cli::CommandLine({argv, argv + argc}));
  if (!outcome) return cli::InterruptedStatus(Report(text, outcome.error()));
  const int status =
      document::Present(AttemptDocument(text.name, *session, *outcome), outputs, argc, argv);
  const bool is_good = *outcome->attempt.verdict == SessionVerdict::kGood;
  return cli::WorseStatus(status,
                          cli::InterruptedStatus(is_good ? 0 : ExitStatus(Cause::kCannotAnswer)));
}

constexpr cli::VerbText kNextText{
    .name = "session next",
    .summary = "Record the next trial of the plan and judge it: status 0 GOOD, 3 CHECK or BAD.",
    .examples = {"haptometer session next day1", "haptometer session next day1 --json",
                 "haptometer session redo day1"}};

int RunNext(int argc, const char* const* argv) {
  return RunRecording(kNextText, ChooseNext, argc, argv);
}

constexpr cli::VerbText kRedoText{
    .name = "session redo",
    .summary = "Record the last trial again, as a new attempt that counts from now on.",
    .examples = {"haptometer session redo day1", "haptometer session redo day1 --json",
                 "haptometer session status day1 --all"}};

int RunRedo(int argc, const char* const* argv) {
  return RunRecording(kRedoText, ChooseLast, argc, argv);
}

constexpr cli::VerbText kFloorText{
    .name = "session floor",
    .summary = "Record the floor of the present subject: a trial with the drive off.",
    .examples = {"haptometer session floor day1", "haptometer session floor day1 --json",
                 "haptometer session next day1"}};

int RunFloor(int argc, const char* const* argv) {
  return RunRecording(kFloorText, ChooseFloor, argc, argv);
}

// --- decisions on a finished attempt: reject, relabel ---

void DeclareDecision(cli::Options& options, std::string& folder, Decision& decision) {
  options.Positional("folder", &folder, "Folder of the session");
  options.Text("--file", &decision.file, "NAME", "Of another attempt than the last")
      .Default("the last that ended");
  options.Text("--reason", &decision.reason, "TEXT", "Reason, stored in the log and the trial");
}

// what was decided on stderr, and what is done and comes next on stdout
int Decide(const cli::VerbText& text, const std::string& folder, bool is_json,
           const std::function<Result<std::string>(SessionFolder&)>& decide, int argc,
           const char* const* argv) {
  auto session = SessionFolder::Open(folder);
  if (!session) return cli::ReportError(text.name, session.error());
  const auto done = decide(*session);
  if (!done) return cli::ReportError(text.name, done.error());
  cli::Remark(text.name, *done);
  document::Document document = StatusDocument(*session);
  document.verb = text.name;
  document::Outputs outputs;
  outputs.json = is_json;
  return document::Present(std::move(document), outputs, argc, argv);
}

constexpr cli::VerbText kRejectText{
    .name = "session reject",
    .summary = "Reject the last trial with a reason: it is BAD, stays, and is excluded.",
    .examples = {"haptometer session reject day1 --reason 'finger slipped'",
                 "haptometer session reject day1 --file NAME.bin --reason 'wrong actuator'",
                 "haptometer session redo day1"}};

int RunReject(int argc, const char* const* argv) {
  std::string folder;
  Decision decision;
  cli::Options options(kRejectText);
  DeclareDecision(options, folder, decision);
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto reject = [&](SessionFolder& session) { return Reject(session, decision); };
  return Decide(kRejectText, folder, options.json(), reject, argc, argv);
}

constexpr cli::VerbText kRelabelText{
    .name = "session relabel",
    .summary = "State that the last trial is of another cell of the plan; undone the same way.",
    .examples = {"haptometer session relabel day1 --condition stock --reason 'adapters swapped'",
                 "haptometer session relabel day1 --subject 4 --reason 'subject 4 came first'",
                 "haptometer session status day1 --all"}};

int RunRelabel(int argc, const char* const* argv) {
  std::string folder;
  Decision decision;
  OtherCell other;
  cli::Options options(kRelabelText);
  DeclareDecision(options, folder, decision);
  options.Text("--subject", &other.subject, "NAME", "Subject of the trial").Default("as it is");
  options.Text("--condition", &other.condition, "NAME", "Condition of the trial")
      .Default("as it is");
  options.Count("--repeat", &other.repeat, 1, kMostRepeats, "Repeat of the trial")
      .Default("as it is");
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto relabel = [&](SessionFolder& session) { return Relabel(session, decision, other); };
  return Decide(kRelabelText, folder, options.json(), relabel, argc, argv);
}

// --- remarks: note, skip ---

constexpr cli::VerbText kNoteText{
    .name = "session note",
    .summary = "Keep a note with the last trial, or with the next cell where none has ended.",
    .examples = {"haptometer session note day1 --text 'cold finger'",
                 "haptometer session note day1 --file NAME.bin --text 'warm finger'",
                 "haptometer session status day1 --all"}};

int RunNote(int argc, const char* const* argv) {
  std::string folder;
  std::string file;
  std::string text;
  cli::Options options(kNoteText);
  options.Positional("folder", &folder, "Folder of the session");
  options.Text("--file", &file, "NAME", "Of another attempt than the last")
      .Default("the last that ended");
  options.Text("--text", &text, "TEXT", "The note, stored in the log");
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto note = [&](SessionFolder& session) { return Note(session, file, text); };
  return Decide(kNoteText, folder, options.json(), note, argc, argv);
}

constexpr cli::VerbText kSkipText{
    .name = "session skip",
    .summary = "Skip the next cell with a reason: it comes again behind all others.",
    .examples = {"haptometer session skip day1 --reason 'cone is broken'",
                 "haptometer session next day1", "haptometer session status day1 --all"}};

int RunSkip(int argc, const char* const* argv) {
  std::string folder;
  std::string reason;
  cli::Options options(kSkipText);
  options.Positional("folder", &folder, "Folder of the session");
  options.Text("--reason", &reason, "TEXT", "Reason, stored in the log");
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto skip = [&](SessionFolder& session) { return Skip(session, reason); };
  return Decide(kSkipText, folder, options.json(), skip, argc, argv);
}

constexpr auto kWords = std::to_array<cli::VerbWord>(
    {{"new", RunNew, kNewText.summary, kNewText.examples[0]},
     {"run", RunSessionRun, kSessionRunText.summary, kSessionRunText.examples[0]},
     {"next", RunNext, kNextText.summary, kNextText.examples[0]},
     {"redo", RunRedo, kRedoText.summary, kRedoText.examples[0]},
     {"reject", RunReject, kRejectText.summary, kRejectText.examples[0]},
     {"relabel", RunRelabel, kRelabelText.summary, kRelabelText.examples[0]},
     {"floor", RunFloor, kFloorText.summary, kFloorText.examples[0]},
     {"note", RunNote, kNoteText.summary, kNoteText.examples[0]},
     {"skip", RunSkip, kSkipText.summary, kSkipText.examples[0]},
     {"status", RunStatus, kStatusText.summary, kStatusText.examples[0]},
     {"pack", RunSessionPack, kSessionPackText.summary, kSessionPackText.examples[0]},
     {"verify", RunSessionVerify, kSessionVerifyText.summary, kSessionVerifyText.examples[0]}});

}  // namespace

int RunSession(int argc, const char* const* argv) {
  return cli::RunVerbWord(
      "session", "Plan a session of trials and record it, with a verdict after each trial.", kWords,
      argc, argv);
}

}  // namespace haptometer::tools
