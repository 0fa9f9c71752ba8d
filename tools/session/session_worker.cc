#include "tools/session/session_worker.h"

#include <fmt/core.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/input_file.h"
#include "tools/acquire/recording.h"
#include "tools/session/imported_trial.h"

namespace haptometer::tools {
namespace {

using Kind = SessionCommand::Kind;

dsp::BandPass DefaultBand() {
  const auto band = BandOf(AcquireOptions{});
  HAPTOMETER_CHECK(band, "{}", band.error().Text());
  return *band;
}

constexpr std::string_view kNotThere = "the device is not there";

bool IsAttempt(Kind kind) {
  return kind == Kind::kRecord || kind == Kind::kRedo || kind == Kind::kFloor;
}

}  // namespace

SessionWorker::SessionWorker(SessionFolder session, SessionSource source, std::string command_line)
    : session_(std::move(session)),
      source_(std::move(source)),
      command_line_(std::move(command_line)),
      changed_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      stays_open_(!source_.folder && !FindSensorKind(source_.sensor.sensor)->ends_by_itself) {
  if (source_.folder) folder_.emplace(*source_.folder, session_.plan());
  view_.message = session_.DamageInWords();
  thread_ = std::thread([this] { Run(); });
}

SessionWorker::~SessionWorker() {
  static_cast<void>(End(0));
  thread_.join();
  close(changed_);
}

bool SessionWorker::End(double longest_s) {
  ends_ = true;
  stop_recording_ = true;
  stop_opening_ = true;
  wake_.notify_all();
  std::unique_lock lock(mutex_);
  return wake_.wait_for(lock, std::chrono::duration<double>(longest_s),
                        [this] { return has_ended_; });
}

void SessionWorker::Ask(SessionCommand command) {
  {
    const std::lock_guard lock(mutex_);
    commands_.push_back(std::move(command));
  }
  wake_.notify_all();
}

void SessionWorker::StopRecording() { stop_recording_ = true; }

SessionView SessionWorker::View() const {
  const std::lock_guard lock(mutex_);
  return view_;
}

// until a command comes, or for `ns`
void SessionWorker::Wait(MonotonicNs ns) {
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, std::chrono::nanoseconds(ns),
                 [this] { return ends_.load() || !commands_.empty(); });
}

void SessionWorker::Enter(SourceState state, std::string remark, bool rings) {
  const std::lock_guard lock(mutex_);
  if (view_.state == state && view_.remark == remark) return;
  if (view_.state != state) view_.since_ns = clock_.Now();
  view_.state = state;
  view_.remark = std::move(remark);
  view_.bells += static_cast<std::uint64_t>(rings);
  static_cast<void>(eventfd_write(changed_, 1));
}

// the session's state to the screen; the message stays where there is no new one
void SessionWorker::Publish(const std::string* message, std::optional<SourceState> state) {
  const SessionCounts counts = session_.Counts();
  const std::lock_guard lock(mutex_);
  view_.counts = counts;
  view_.cell = first_ ? first_ : counts.next;
  if (view_.cell) {
    const auto place = std::ranges::find(session_.cells(), *view_.cell);
    view_.place = place == session_.cells().end()
                      ? 0
                      : static_cast<std::size_t>(place - session_.cells().begin()) + 1;
    view_.attempt = session_.state().NextNumber(*view_.cell);
  }
  // a decision may have changed the last attempt
  const SessionAttempt* last = session_.state().LastFinished();
  if (view_.last && last != nullptr && last->file == view_.last->attempt.file) {
    AttemptOutcome& shown = *view_.last;
    if (last->Reasons() != shown.attempt.Reasons()) shown.reasons = {last->Reasons()};
    shown.attempt = *last;
    shown.band_rms_m = last->band_rms_m;
  }
  if (message != nullptr) view_.message = *message;
  if (state) {
    view_.state = *state;
    view_.remark.clear();
    view_.since_ns = clock_.Now();
  }
  static_cast<void>(eventfd_write(changed_, 1));
}

void SessionWorker::Run() {
  Publish();
  while (!ends_) {
    std::optional<SessionCommand> command;
    {
      const std::lock_guard lock(mutex_);
      if (!commands_.empty()) {
        command = std::move(commands_.front());
        commands_.pop_front();
      }
    }
    if (command) {
      Do(*command);
    } else if (folder_) {
      ExamineFolder();
    } else {
      ReadSensor();
    }
  }
  sensor_.reset();
  {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;
  }
  wake_.notify_all();
}

void SessionWorker::Do(const SessionCommand& command) {
  if (IsAttempt(command.kind)) {
    Attempt(command.kind);
    return;
  }
  const auto done = Decide(command);
  const std::string message = done ? *done : done.error().Text();
  Publish(&message);
}

Result<std::string> SessionWorker::Decide(const SessionCommand& command) {
  const Decision decision{.reason = command.text};
  switch (command.kind) {
    case Kind::kReject:
      return Reject(session_, decision);
    case Kind::kAccept:
      return Accept(session_, decision);
    case Kind::kRelabel:
      return Relabel(session_, decision, command.other);
    case Kind::kNote:
      return Note(session_, "", command.text);
    default:
      break;
  }
  // what was asked for is no cell of the plan's order: it is left, with the reason as a note
  if (!first_) return Skip(session_, command.text);
  HAPTOMETER_TRY(Note(session_, "", command.text));
  return "not now: " + NameOf(*std::exchange(first_, std::nullopt));
}

Result<SessionCell> SessionWorker::CellOf(Kind kind) const {
  if (kind == Kind::kRedo) return ChooseLast(session_);
  if (kind == Kind::kFloor) return ChooseFloor(session_);
  if (first_) return *first_;
  return ChooseNext(session_);
}

void SessionWorker::Attempt(Kind kind) {
  const auto cell = CellOf(kind);
  std::string message;
  if (!cell) {
    message = cell.error().Text();
  } else if (folder_) {
    // the next file is of this cell
    if (kind != Kind::kRecord) first_ = *cell;
    is_held_ = false;
    message = kind == Kind::kRecord ? "a file is waited for, no key is needed" : "";
  } else if (stays_open_ && !sensor_) {
    message = kNotThere;
  } else {
    Record(*cell);
    return;
  }
  Publish(&message);
}

// false: it does not open now
bool SessionWorker::Open() {
  const bool was_away = View().state == SourceState::kAway;
  if (!was_away) Enter(SourceState::kOpening);
  stop_opening_ = false;
  if (ends_) return false;
  auto opened = OpenSensor(source_.sensor, clock_);
  Result<void> started;
  if (opened) started = (*opened)->Start(stop_opening_);
  if (!opened || !started) {
    const Error& error = opened ? started.error() : opened.error();
    Enter(stays_open_ ? SourceState::kAway : SourceState::kReady, error.Text());
    return false;
  }
  sensor_ = std::move(*opened);
  pause_.Reset();
  // settings of the device and its zero are written once, not at each return
  source_.sensor = WithoutChanges(source_.sensor);
  meter_ = std::make_shared<LiveMeter>(sensor_->header(), DefaultBand());
  {
    const std::lock_guard lock(mutex_);
    view_.meter = meter_;
    if (view_.message == kNotThere) view_.message.clear();
  }
  static_cast<void>(sensor_->Begin());
  Enter(SourceState::kReady, {}, was_away);
  return true;
}

// between two recordings
void SessionWorker::ReadSensor() {
  if (!stays_open_) {
    Enter(SourceState::kReady, View().remark);
    Wait(kNsPerS);
    return;
  }
  if (!sensor_ && !Open()) {
    Wait(pause_.Next());
    return;
  }
  switch (sensor_->Next(reading_)) {
    case acquire::Outcome::kReading:
      meter_->Add(reading_);
      break;
    case acquire::Outcome::kEnd:
    case acquire::Outcome::kGone:
      sensor_.reset();
      Enter(SourceState::kAway, "the device is disconnected");
      break;
    default:
      break;
  }
}

void SessionWorker::ExamineFolder() {
  const auto cell = CellOf(Kind::kRecord);
  if (!cell) {
    Enter(SourceState::kReady, "no file is waited for");
    Wait(kNsPerS);
    return;
  }
  // a full disk is no reason to begin attempts without an end
  if (is_held_) {
    Enter(SourceState::kAway, "the last import failed; SPACE tries it again");
    Wait(kNsPerS);
    return;
  }
  auto found = folder_->Examine(session_.state(), clock_.Now());
  if (!found) {
    Enter(SourceState::kAway, found.error().Text());
  } else if (!*found) {
    Enter(SourceState::kWaiting, folder_->pending());
  } else {
    Enter(SourceState::kJudging, (*found)->file.name, true);
    const auto outcome =
        MakeAttempt(session_, (*found)->continued.value_or(*cell),
                    ImportOf(folder_->source(), (*found)->file, clock_, command_line_));
    is_held_ = !outcome;
    Finish(outcome);
    // each file is an input of its own trial alone
    ForgetInputs();
    return;
  }
  Wait(kExamineEveryNs);
}

void SessionWorker::Record(const SessionCell& cell) {
  if (!sensor_ && !Open()) return;
  stop_recording_ = false;
  if (ends_) return;
  const RecordingWatch watch{
      .stop = stop_recording_,
      .reading = [this](const acquire::Reading& reading) { meter_->Add(reading); },
      .begun = [this] { Enter(SourceState::kRecording, {}, true); },
      .recorded = [this] { Enter(SourceState::kJudging, {}, true); }};
  const auto recording = RecordingOf(*sensor_, source_, clock_, watch, command_line_);
  first_ = cell;
  Publish();
  Finish(recording ? MakeAttempt(session_, cell, *recording) : std::unexpected(recording.error()));
  if (stays_open_) return;
  sensor_.reset();
  const std::lock_guard lock(mutex_);
  view_.meter.reset();
}

void SessionWorker::Finish(const Result<AttemptOutcome>& outcome) {
  if (outcome) {
    first_.reset();
    const std::lock_guard lock(mutex_);
    view_.last = *outcome;
  }
  const std::string message = outcome ? "" : outcome.error().Text();
  // the verdict and the end of the attempt at once
  Publish(&message, folder_ ? SourceState::kWaiting : SourceState::kReady);
}

}  // namespace haptometer::tools
