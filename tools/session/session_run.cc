#include "tools/session/session_run.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/input_file.h"
#include "base/text.h"
#include "tools/acquire/live_view.h"
#include "tools/acquire/recording.h"
#include "tools/cli/options.h"
#include "tools/cli/raw_terminal.h"
#include "tools/cli/terminal.h"
#include "tools/session/session_worker.h"

// session run: the terminal's screen of a session.

namespace haptometer::tools {
namespace {

using cli::Key;
using Kind = SessionCommand::Kind;

constexpr int kFrameMs = 200;
// a device without readings for this time is stated to send none
constexpr MonotonicNs kSilentNs = 2 * kNsPerS;
// how long a thread that hangs in opening a port is waited for at the end
constexpr double kLongestEndS = 3;

// --- what is typed behind a key: reason, note, cell ---

struct Question {
  std::string text;
  std::string answer{};
  bool may_be_empty = false;
};

// the questions that a command needs answers to, one after the other
struct Prompt {
  Kind kind = Kind::kNote;
  std::vector<Question> questions{};
  std::size_t at = 0;
  std::string remark{};  // on the answer that was given
};

// the answer that stands for the subject's floor, as the option of session relabel
constexpr std::string_view kFloorAnswer = "--floor";

std::optional<Prompt> PromptOf(std::string_view key) {
  if (key == "x") return Prompt{Kind::kReject, {{"rejected, because"}}};
  if (key == "a") return Prompt{Kind::kAccept, {{"accepted, because"}}};
  if (key == "n") return Prompt{Kind::kNote, {{"note on the last trial"}}};
  if (key == "s") return Prompt{Kind::kSkip, {{"skipped, because"}}};
  if (key != "l") return std::nullopt;
  return Prompt{Kind::kRelabel,
                {{"last trial is of subject (empty: as it is)", "", true},
                 {"condition (empty: as it is; --floor: it is the floor)", "", true},
                 {"repeat (empty: as it is)", "", true},
                 {"because"}}};
}

// why the plan does not have the part of a cell that was typed; empty where it does
std::string WrongPart(const Prompt& prompt, const SessionPlan& plan) {
  const std::string& answer = prompt.questions[prompt.at].answer;
  if (prompt.kind != Kind::kRelabel || prompt.at > 2 || answer.empty()) return {};
  if (prompt.at == 1 && answer == kFloorAnswer) return {};
  const auto& names = prompt.at == 0 ? plan.subjects : plan.conditions;
  const std::int64_t repeat = NumberFrom<std::int64_t>(answer).value_or(0);
  const bool is_planned = prompt.at == 2 ? repeat >= 1 && repeat <= plan.repeats
                                         : std::ranges::count(names, answer) > 0;
  return is_planned ? "" : answer + " is not in the plan";
}

SessionCommand CommandOf(const Prompt& prompt) {
  SessionCommand command{.kind = prompt.kind, .text = prompt.questions.back().answer};
  if (prompt.kind != Kind::kRelabel) return command;
  const std::string& condition = prompt.questions[1].answer;
  const bool is_floor = condition == kFloorAnswer;
  command.other = {.subject = prompt.questions[0].answer,
                   .condition = is_floor ? "" : condition,
                   .is_floor = is_floor,
                   .repeat = NumberFrom<std::int64_t>(prompt.questions[2].answer)};
  return command;
}

// the last character of a text is removed, all its bytes
void RemoveLast(std::string& text) {
  while (!text.empty() && (static_cast<unsigned char>(text.back()) & 0xc0U) == 0x80) {
    text.pop_back();
  }
  if (!text.empty()) text.pop_back();
}

// --- the screen ---

std::string StateLine(const SessionView& view, const std::string& source, double duration_s,
                      double elapsed_s) {
  switch (view.state) {
    case SourceState::kOpening:
      return fmt::format("{}: opening", source);
    case SourceState::kAway:
      return fmt::format("{}: WAITING for it since {:.0f} s: {}", source, elapsed_s, view.remark);
    case SourceState::kReady:
      return view.remark.empty() ? source + ": ready" : source + ": " + view.remark;
    case SourceState::kWaiting:
      return source + ": waiting for a file" + (view.remark.empty() ? "" : ", " + view.remark);
    case SourceState::kRecording:
      return fmt::format("RECORDING  {:.1f} of {:g} s", elapsed_s, duration_s);
    case SourceState::kJudging:
      return view.remark.empty() ? "recorded; analyzing" : view.remark + ": analyzing";
  }
  return {};
}

std::string PlaceLine(const SessionView& view, std::size_t cells) {
  if (!view.cell) return "all cells are done";
  return fmt::format("{} of {}   {}   attempt {}",
                     view.place == 0 ? "no cell" : fmt::format("cell {}", view.place), cells,
                     NameOf(*view.cell), view.attempt);
}

std::string CountsLine(const SessionCounts& counts) {
  std::string line = fmt::format("done {} of {}   GOOD {}   CHECK {}   BAD {}", counts.done,
                                 counts.planned, counts.good, counts.check, counts.bad);
  if (counts.floors > 0) {
    line += fmt::format("   floors {} of {}", counts.floors_done, counts.floors);
  }
  if (counts.skipped > 0) line += fmt::format("   skipped {}", counts.skipped);
  return line;
}

// the verdict with what deviates, and what to do
void AddVerdict(const SessionView& view, std::vector<std::string>& lines) {
  const AttemptOutcome& outcome = *view.last;
  const SessionVerdict verdict = *outcome.attempt.verdict;
  std::string line = fmt::format("{:<6} {}", Name(verdict), NameOf(outcome.attempt.cell));
  if (outcome.band_rms_m) line += fmt::format("   {:.4g} um RMS", *outcome.band_rms_m * 1e6);
  if (outcome.tone_hz) line += fmt::format(", {:.2f} Hz", *outcome.tone_hz);
  lines.push_back(line);
  for (const std::string& reason : outcome.reasons) lines.push_back("       " + reason);
  if (verdict == SessionVerdict::kCheck) {
    lines.emplace_back("       r records it again, x rejects it; else continue");
  } else if (verdict == SessionVerdict::kBad) {
    const bool comes_again = view.cell == outcome.attempt.cell;
    lines.emplace_back(comes_again ? "       it comes again next; s skips it"
                                   : "       r records it again");
  }
}

// what does not change on the screen
struct ScreenText {
  std::string title;
  std::string source;
  SessionPlan plan;
  std::size_t cells = 0;
  bool is_folder = false;
};

class SessionScreen {
 public:
  SessionScreen(cli::RawTerminal& terminal, SessionWorker& worker, ScreenText text)
      : terminal_(terminal), worker_(worker), text_(std::move(text)) {}

  // until q, Ctrl-C or a signal
  void Run();

 private:
  void Draw();
  [[nodiscard]] std::vector<std::string> Lines(const SessionView& view);
  [[nodiscard]] std::string LiveText(const SessionView& view);
  void AddKeys(const SessionView& view, std::vector<std::string>& lines) const;
  void Take(const Key& key);
  void TakeInPrompt(const Key& key);
  void TakeCommand(const std::string& key);

  cli::RawTerminal& terminal_;
  SessionWorker& worker_;
  ScreenText text_;
  SystemClock clock_;
  dsp::BandPass band_ = BandOf(AcquireOptions{}).value_or(dsp::BandPass{});
  std::optional<Prompt> prompt_;
  std::uint64_t bells_ = 0;
  std::uint64_t readings_ = 0;  // of the meter, when they last grew
  MonotonicNs readings_ns_ = 0;
  bool quits_ = false;
};

std::string SessionScreen::LiveText(const SessionView& view) {
  if (!view.meter || view.state == SourceState::kAway) return {};
  const LiveFigures figures = view.meter->Figures();
  if (figures.readings != readings_) {
    readings_ = figures.readings;
    readings_ns_ = clock_.Now();
  }
  const MonotonicNs silent_ns = clock_.Now() - readings_ns_;
  const bool is_read = view.state == SourceState::kReady || view.state == SourceState::kRecording;
  if (is_read && silent_ns > kSilentNs) {
    return fmt::format("no reading for {:.0f} s", SecondsFromNs(silent_ns));
  }
  return LiveLine(figures, band_);
}

// two lines, each within 80 columns
void SessionScreen::AddKeys(const SessionView& view, std::vector<std::string>& lines) const {
  if (view.state == SourceState::kRecording) {
    lines.insert(lines.end(), {"q stops the recording", ""});
    return;
  }
  const std::string_view record = text_.is_folder ? "" : "SPACE record   ";
  lines.push_back(fmt::format("{}r redo   f floor   s skip   q quit", record));
  lines.emplace_back("x reject   a accept   l relabel   n note");
}

std::vector<std::string> SessionScreen::Lines(const SessionView& view) {
  const double elapsed_s = SecondsFromNs(clock_.Now() - view.since_ns);
  std::vector<std::string> lines{"session " + text_.title,
                                 PlaceLine(view, text_.cells),
                                 CountsLine(view.counts),
                                 "",
                                 StateLine(view, text_.source, text_.plan.duration_s, elapsed_s),
                                 LiveText(view),
                                 ""};
  if (prompt_) {
    const Question& question = prompt_->questions[prompt_->at];
    lines.push_back(fmt::format("{}: {}_   (Enter, Esc)", question.text, question.answer));
    lines.push_back(prompt_->remark);
  } else {
    AddKeys(view, lines);
  }
  lines.push_back(view.message);
  lines.emplace_back();
  if (view.last) AddVerdict(view, lines);
  return lines;
}

void SessionScreen::Draw() {
  const SessionView view = worker_.View();
  // a bell for each beginning and end, also if two came between two frames
  for (; bells_ < view.bells; ++bells_) terminal_.Bell();
  terminal_.Show(Lines(view));
}

void SessionScreen::TakeInPrompt(const Key& key) {
  Question& question = prompt_->questions[prompt_->at];
  prompt_->remark.clear();
  switch (key.kind) {
    case Key::Kind::kText:
      question.answer += key.text;
      return;
    case Key::Kind::kBackspace:
      RemoveLast(question.answer);
      return;
    case Key::Kind::kEnter:
      break;
    default:
      prompt_.reset();
      return;
  }
  if (question.answer.find_first_not_of(' ') == std::string::npos && !question.may_be_empty) return;
  prompt_->remark = WrongPart(*prompt_, text_.plan);
  if (!prompt_->remark.empty()) return;
  // a floor has no repeat
  prompt_->at += question.answer == kFloorAnswer && prompt_->at == 1 ? 2 : 1;
  if (prompt_->at < prompt_->questions.size()) return;
  worker_.Ask(CommandOf(*prompt_));
  prompt_.reset();
}

void SessionScreen::TakeCommand(const std::string& key) {
  const SourceState state = worker_.View().state;
  // keys that are struck during a recording, as a second time on a pedal, do not begin the next
  if (state == SourceState::kRecording || state == SourceState::kJudging) {
    if (key == "q" && state == SourceState::kRecording) worker_.StopRecording();
    if (key == "q" && state == SourceState::kJudging) quits_ = true;
    return;
  }
  if (key == " ") worker_.Ask({.kind = Kind::kRecord});
  if (key == "r") worker_.Ask({.kind = Kind::kRedo});
  if (key == "f") worker_.Ask({.kind = Kind::kFloor});
  if (key == "q") quits_ = true;
  prompt_ = PromptOf(key);
}

void SessionScreen::Take(const Key& key) {
  if (key.kind == Key::Kind::kInterrupt) {
    cli::InterruptAsBy(SIGINT);
  } else if (prompt_) {
    TakeInPrompt(key);
  } else if (key.kind == Key::Kind::kEnter) {
    TakeCommand(" ");
  } else {
    TakeCommand(key.text);
  }
}

void SessionScreen::Run() {
  while (!quits_ && !cli::Interrupted().load()) {
    Draw();
    std::array<pollfd, 2> both{pollfd{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0},
                               pollfd{.fd = worker_.changed(), .events = POLLIN, .revents = 0}};
    if (poll(both.data(), both.size(), kFrameMs) <= 0) continue;
    eventfd_t count = 0;
    if (both[1].revents != 0) static_cast<void>(eventfd_read(worker_.changed(), &count));
    if (both[0].revents == 0) continue;
    for (const Key& key : terminal_.Keys()) Take(key);
  }
}

Result<int> Run(const std::string& folder, std::string command_line) {
  HAPTOMETER_LET(auto session, SessionFolder::Open(folder));
  HAPTOMETER_LET(const auto source, ReadSource(session.plan(), kSessionRunText.name));
  if (IsSensor(source.sensor.sensor, SensorType::kPipe) && source.sensor.port.empty()) {
    return Usage("--sensor pipe", "reads the input that the keys come from",
                 "name a pipe with --port, or use session next");
  }
  const ScreenText text{.title = session.folder(),
                        .source = NameOf(source),
                        .plan = session.plan(),
                        .cells = session.cells().size(),
                        .is_folder = source.folder.has_value()};
  cli::CatchInterrupts();
  HAPTOMETER_LET(const auto terminal, cli::RawTerminal::Open());
  SessionWorker worker(std::move(session), source, std::move(command_line));
  SessionScreen(*terminal, worker, text).Run();
  const bool is_opening =
      worker.View().state == SourceState::kOpening || worker.View().state == SourceState::kAway;
  const bool has_ended = worker.End(is_opening ? kLongestEndS : kLongestTimeS);
  const SessionCounts counts = worker.View().counts;
  terminal->Restore();
  cli::Remark(kSessionRunText.name,
              fmt::format("{}: {} of {} trials are done", folder, counts.done, counts.planned));
  // a thread that hangs in the system records nothing, and is left behind
  if (!has_ended) std::quick_exit(cli::InterruptedStatus(0));
  return 0;
}

}  // namespace

int RunSessionRun(int argc, const char* const* argv) {
  std::string folder;
  cli::Options options(kSessionRunText);
  options.Positional("folder", &folder, "Folder of the session");
  if (const auto status = options.Parse(argc, argv)) return *status;
  const auto status = Run(folder, cli::CommandLine({argv, argv + argc}));
  if (status) return cli::InterruptedStatus(*status);
  if (status.error().what.empty()) return ExitStatus(status.error().cause);
  return cli::ReportError(kSessionRunText.name, status.error());
}

}  // namespace haptometer::tools
