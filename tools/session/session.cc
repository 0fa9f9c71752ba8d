#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "base/mapped.h"
#include "tools/cli/options.h"
#include "tools/cli/terminal.h"
#include "tools/cli/verb_words.h"
#include "tools/document/present.h"
#include "tools/session/attempt.h"
#include "tools/session/decisions.h"
#include "tools/session/imported_trial.h"
#include "tools/session/session_document.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_pack.h"
#include "tools/session/session_run.h"
#include "tools/session/session_source.h"
#include "tools/session/watched_folder.h"
#include "tools/verbs.h"

// session: a plan of trials, recorded one after the other, with a verdict after each.

namespace haptometer::tools {
namespace {

// an error without words was reported where it arose (ReadSource)
int Report(std::string_view verb, const Error& error) {
  return error.what.empty() ? ExitStatus(error.cause) : cli::ReportError(verb, error);
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
  options.Positional("folder", &folder,
                     "The new folder of the session; behind -- the options of acquire");
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
    if (!duration_s) return Usage("--duration", "is missing", "write, for example, --duration 4s");
    plan.duration_s = *duration_s;
    HAPTOMETER_LET(plan.contrasts, ParseContrasts(contrasts));
    if (own < argc) plan.source = WithFullPaths({argv + own + 1, argv + argc});
    HAPTOMETER_TRY(CheckPlan(plan, folder));
    HAPTOMETER_LET(const auto source, ReadSource(plan, kNewText.name));
    HAPTOMETER_TRY(CheckSource(source, folder));
    if (source.folder) {
      HAPTOMETER_LET(const auto files, FilesIn(*source.folder));
      plan.files_before = Mapped<std::string>(files, [](const auto& file) { return TextOf(file); });
    }
    HAPTOMETER_TRY(SessionFolder::Create(folder, plan));
    return PlanDocument(folder, plan, spread);
  };
  auto document = make();
  if (!document) return Report(kNewText.name, document.error());
  document::Outputs outputs;
  outputs.json = options.json();
  return document::Present(*std::move(document), outputs, argc, argv);
}

// --- the words for a session that is there ---

// what the command line states; each word declares what it has
struct Asked {
  std::string folder;
  Decision decision;
  OtherCell other;
  std::string text;
  std::optional<double> wait_s;
  document::Outputs outputs;
  std::string command_line;
};

struct Answer {
  document::Document document;
  int status = 0;
};

// what a word has to answer with
struct Call {
  std::string_view verb;
  SessionFolder& session;
  const Asked& asked;
  void Say(const std::string& words) const { cli::Remark(verb, words); }
};

// a word: its options, and what it does with a session that is open
struct Word {
  cli::VerbText text;
  void (*declare)(cli::Options& options, Asked& asked);
  Result<Answer> (*answer)(const Call& call);
  bool only_reads = false;
};

void DeclareFile(cli::Options& options, Asked& asked) {
  options.Text("--file", &asked.decision.file, "NAME", "Of another attempt than the last")
      .Default("the last that ended");
}

void DeclareReason(cli::Options& options, Asked& asked) {
  options.Text("--reason", &asked.decision.reason, "TEXT", "Why, stored in the log");
}

void DeclareDecision(cli::Options& options, Asked& asked) {
  DeclareFile(options, asked);
  DeclareReason(options, asked);
}

void DeclareRelabel(cli::Options& options, Asked& asked) {
  DeclareDecision(options, asked);
  options.Text("--subject", &asked.other.subject, "NAME", "Subject of the trial")
      .Default("as it is");
  options.Text("--condition", &asked.other.condition, "NAME", "Condition of the trial")
      .Default("as it is");
  options.Count("--repeat", &asked.other.repeat, 1, kMostRepeats, "Repeat of the trial")
      .Default("as it is");
  options.Flag("--floor", &asked.other.is_floor, "It is the subject's floor");
  options.Exclude("--floor", {"--condition", "--repeat"}, "a floor has neither");
}

void DeclareNote(cli::Options& options, Asked& asked) {
  DeclareFile(options, asked);
  options.Text("--text", &asked.text, "TEXT", "The note, stored in the log");
}

void DeclareWait(cli::Options& options, Asked& asked) {
  options
      .Number("--wait", &asked.wait_s, Dimension::kTime, cli::Within(0, kLongestTimeS),
              "How long a file of --from-folder is waited for")
      .Default("10 min");
}

void DeclareRedo(cli::Options& options, Asked& asked) {
  DeclareFile(options, asked);
  DeclareWait(options, asked);
}

Result<Answer> ShowStatus(const Call& call) {
  const auto found = call.session.CompareWithLog();
  Answer answer{StatusDocument(call.verb, call.session, found)};
  // counted apart: the log does not know what was done to a trial by hand
  const auto excluded = std::ranges::count(found.list(), FolderFinding::kExcludedByUser,
                                           &FindingOf<FolderFinding>::kind);
  document::Section& root = answer.document.root;
  root.Add({"excluded_by_user", excluded > 0 ? "excluded by trial exclude" : ""},
           static_cast<std::size_t>(excluded));
  return answer;
}

// how long a file of another program is waited for
constexpr double kUsualWaitS = 600;

// an attempt of the cell, from the plan's sensor or folder
Result<AttemptOutcome> Attempt(const Call& call, const SessionCell& cell) {
  const auto& [verb, session, asked] = call;
  HAPTOMETER_LET(const auto source, ReadSource(session.plan(), verb));
  // reading options begins with no inputs
  NoteInput(session.plan_path());
  if (source.folder) {
    call.Say("waiting for a file of " + NameOf(cell));
    return ImportAttempt(session, cell, *source.folder,
                         {asked.wait_s.value_or(kUsualWaitS), cli::Interrupted(),
                          [&](const std::string& words) { call.Say(words); }},
                         asked.command_line);
  }
  if (asked.wait_s) return Usage("--wait", "is for a source --from-folder", "leave it out");
  call.Say(NameOf(cell));
  return RecordAttempt(session, cell, source, asked.command_line);
}

// next, redo, floor
Result<Answer> Record(const Call& call, const Result<SessionCell>& cell) {
  if (!cell) return std::unexpected(cell.error());
  cli::CatchInterrupts();
  HAPTOMETER_LET(const auto outcome, Attempt(call, *cell));
  const bool is_good = *outcome.attempt.verdict == SessionVerdict::kGood;
  return Answer{AttemptDocument(call.verb, call.session, outcome),
                is_good ? 0 : ExitStatus(Cause::kCannotAnswer)};
}

// what was decided on stderr, and what is done and comes next on stdout
Result<Answer> Decided(const Call& call, const Result<std::string>& done) {
  if (!done) return std::unexpected(done.error());
  call.Say(*done);
  return Answer{StatusDocument(call.verb, call.session)};
}

constexpr auto kSessionWords = std::to_array<Word>(
    {{{"session next",
       "Record the next trial of the plan and judge it: status 0 GOOD, 3 CHECK or BAD.",
       {"haptometer session next day1", "haptometer session next day1 --json",
        "haptometer session redo day1"}},
      DeclareWait,
      [](const Call& call) { return Record(call, ChooseNext(call.session)); }},
     {{"session redo",
       "Record the last trial, or that of a file, again: a new attempt that counts from now on.",
       {"haptometer session redo day1", "haptometer session redo day1 --file NAME.bin",
        "haptometer session status day1 --all"}},
      DeclareRedo,
      [](const Call& call) {
        return Record(call, ChooseLast(call.session, call.asked.decision.file));
      }},
     {{"session reject",
       "Reject the last trial with a reason: it is BAD, stays, and is excluded.",
       {"haptometer session reject day1 --reason 'finger slipped'",
        "haptometer session reject day1 --file NAME.bin --reason 'wrong actuator'",
        "haptometer session accept day1 --reason 'wrong key'"}},
      DeclareDecision,
      [](const Call& call) { return Decided(call, Reject(call.session, call.asked.decision)); }},
     {{"session accept",
       "Undo a rejection, and let this attempt count for its cell until a newer one ends.",
       {"haptometer session accept day1 --reason 'wrong key'",
        "haptometer session accept day1 --file NAME.bin --reason 'the first was better'",
        "haptometer session status day1 --all"}},
      DeclareDecision,
      [](const Call& call) { return Decided(call, Accept(call.session, call.asked.decision)); }},
     {{"session relabel",
       "State that the last trial is of another cell of the plan; undone the same way.",
       {"haptometer session relabel day1 --condition stock --reason 'adapters swapped'",
        "haptometer session relabel day1 --subject 4 --reason 'subject 4 came first'",
        "haptometer session relabel day1 --floor --reason 'the drive was off'"}},
      DeclareRelabel,
      [](const Call& call) {
        return Decided(call, Relabel(call.session, call.asked.decision, call.asked.other));
      }},
     {{"session floor",
       "Record the floor of the present subject: a trial with the drive off.",
       {"haptometer session floor day1", "haptometer session floor day1 --json",
        "haptometer session next day1"}},
      DeclareWait,
      [](const Call& call) { return Record(call, ChooseFloor(call.session)); }},
     {{"session note",
       "Keep a note with the last trial, or with the next cell where none has ended.",
       {"haptometer session note day1 --text 'cold finger'",
        "haptometer session note day1 --file NAME.bin --text 'warm finger'",
        "haptometer session status day1 --all"}},
      DeclareNote,
      [](const Call& call) {
        return Decided(call, Note(call.session, call.asked.decision.file, call.asked.text));
      }},
     {{"session skip",
       "Skip the next cell with a reason: it comes again behind all others.",
       {"haptometer session skip day1 --reason 'cone is broken'", "haptometer session next day1",
        "haptometer session status day1 --all"}},
      DeclareReason,
      [](const Call& call) {
        return Decided(call, Skip(call.session, call.asked.decision.reason));
      }},
     {{"session status",
       "Show what of a session is done, and what comes next.",
       {"haptometer session status day1", "haptometer session status day1 --all",
        "haptometer session status day1 --json"}},
      [](cli::Options& options, Asked& asked) {
        options.Flag("--all", &asked.outputs.all, "Print all attempts and the provenance too");
      },
      ShowStatus,
      true}});

// the frame of these words: options, the session, the answer
int RunOnSession(int argc, const char* const* argv) {
  const Word& word = *std::ranges::find_if(
      kSessionWords, [&](const Word& one) { return one.text.name.ends_with(argv[0]); });
  const std::string_view verb = word.text.name;
  Asked asked;
  cli::Options options(word.text);
  options.Positional("folder", &asked.folder, "Folder of the session");
  word.declare(options, asked);
  if (const auto status = options.Parse(argc, argv)) return *status;
  asked.outputs.json = options.json();
  asked.command_line = cli::CommandLine({argv, argv + argc});
  auto session =
      word.only_reads ? SessionFolder::Read(asked.folder) : SessionFolder::Open(asked.folder);
  if (!session) return cli::ReportError(verb, session.error());
  // status has it among its findings
  const std::string damage = word.only_reads ? std::string() : session->DamageInWords();
  if (!damage.empty()) cli::Remark(verb, damage);
  auto answer = word.answer({verb, *session, asked});
  if (!answer) return cli::InterruptedStatus(Report(verb, answer.error()));
  const int status = document::Present(std::move(answer->document), asked.outputs, argc, argv);
  return cli::WorseStatus(status, cli::InterruptedStatus(answer->status));
}

constexpr auto kWords = [] {
  std::array<cli::VerbWord, kSessionWords.size() + 4> words{
      {{"new", RunNew, kNewText.summary, kNewText.examples[0]},
       {"run", RunSessionRun, kSessionRunText.summary, kSessionRunText.examples[0]}}};
  for (std::size_t i = 0; i < kSessionWords.size(); ++i) {
    const cli::VerbText& text = kSessionWords[i].text;
    words[i + 2] = {text.name.substr(text.name.find(' ') + 1), RunOnSession, text.summary,
                    text.examples[0]};
  }
  words[words.size() - 2] = {"pack", RunSessionPack, kSessionPackText.summary,
                             kSessionPackText.examples[0]};
  words[words.size() - 1] = {"verify", RunSessionVerify, kSessionVerifyText.summary,
                             kSessionVerifyText.examples[0]};
  return words;
}();

}  // namespace

int RunSession(int argc, const char* const* argv) {
  return cli::RunVerbWord(
      "session", "Plan a session of trials and record it, with a verdict after each trial.", kWords,
      argc, argv);
}

}  // namespace haptometer::tools
