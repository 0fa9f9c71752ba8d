#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "acquire/sensor/reconnecting_sensor.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "tools/acquire/live_view.h"
#include "tools/session/attempt.h"
#include "tools/session/decisions.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_source.h"
#include "tools/session/watched_folder.h"

namespace haptometer::tools {

/// What the screen of a session asks for.
struct SessionCommand {
  enum class Kind : std::uint8_t {
    kRecord,
    kRedo,
    kFloor,
    kReject,
    kAccept,
    kRelabel,
    kNote,
    kSkip
  };
  Kind kind = Kind::kRecord;
  std::string text{};  ///< reason or note
  OtherCell other{};   ///< kRelabel
};

/// What the source does.
enum class SourceState : std::uint8_t {
  kOpening,
  kAway,     ///< it cannot be opened, and is tried again
  kReady,    ///< the next recording can begin
  kWaiting,  ///< for a file of the folder
  kRecording,
  kJudging,  ///< the recording has ended, its verdict is to come
};

/// What a screen shows of a session at one moment.
struct SessionView {
  SourceState state = SourceState::kOpening;
  MonotonicNs since_ns = 0;  ///< of the state, on CLOCK_MONOTONIC
  std::string remark{};      ///< on the state: why it is away, which file is growing
  SessionCounts counts{};
  std::optional<SessionCell> cell{};  ///< that is recorded, or comes next; empty: all are done
  std::size_t place = 0;              ///< of the cell in the plan, from 1; 0: not in it
  std::int64_t attempt = 1;           ///< number that its next attempt has or gets
  std::optional<AttemptOutcome> last{};
  std::string message{};                     ///< on the last command
  std::uint64_t bells = 0;                   ///< beginnings and ends of recordings so far
  std::shared_ptr<const LiveMeter> meter{};  ///< of the source that is open; may be empty
};

/// Records a session in a thread of its own, so that a screen is never waited for.
///
/// A device stays open between the recordings: its readings are shown, and its loss is noticed at
/// once. It is then opened again after each acquire::RetryPause, with the deadlines of OpenSensor
/// and Sensor::Start. A recording that loses it ends BAD, and its cell comes again next. What is
/// played or piped in is opened for each recording. A folder's next complete file becomes the next
/// trial without a command.
class SessionWorker {
 public:
  /// Begins. `session` is open to be changed; `command_line` goes into the trials.
  SessionWorker(SessionFolder session, SessionSource source, std::string command_line);
  /// Ends a recording, which is BAD then, and waits until its file is closed.
  ~SessionWorker();
  SessionWorker(const SessionWorker&) = delete;
  SessionWorker& operator=(const SessionWorker&) = delete;

  /// Carries `command` out as soon as no other is; what it gave is in View().
  void Ask(SessionCommand command);
  /// Ends the recording before its end; it is BAD then.
  void StopRecording();
  [[nodiscard]] SessionView View() const;
  /// Readable after a change of View(), until it is read.
  [[nodiscard]] int changed() const { return changed_; }
  /// Ends the thread, if it can within `longest_s`; an opening that hangs in the system cannot.
  [[nodiscard]] bool End(double longest_s);

 private:
  void Run();
  void Do(const SessionCommand& command);
  void Attempt(SessionCommand::Kind kind);
  [[nodiscard]] Result<SessionCell> CellOf(SessionCommand::Kind kind) const;
  [[nodiscard]] Result<std::string> Decide(const SessionCommand& command);
  [[nodiscard]] bool Open();
  void ReadSensor();
  void ExamineFolder();
  void Record(const SessionCell& cell);
  void Finish(const Result<AttemptOutcome>& outcome);
  void Enter(SourceState state, std::string remark = {}, bool rings = false);
  void Publish(const std::string* message = nullptr, std::optional<SourceState> state = {});
  void Wait(MonotonicNs ns);

  SessionFolder session_;
  SessionSource source_;
  std::string command_line_;
  SystemClock clock_;
  int changed_;

  // the worker's thread alone
  bool stays_open_;  // a device
  std::unique_ptr<acquire::Sensor> sensor_;
  std::shared_ptr<LiveMeter> meter_;  // of the sensor
  std::optional<WatchedFolder> folder_;
  bool is_held_ = false;  // an import failed: the next waits for a command
  acquire::RetryPause pause_;
  acquire::Reading reading_;
  std::optional<SessionCell> first_;  // is recorded, or comes before the plan's next: asked for

  std::atomic<bool> stop_recording_{false};
  std::atomic<bool> stop_opening_{false};
  std::atomic<bool> ends_{false};

  mutable std::mutex mutex_;  // over all below
  std::condition_variable wake_;
  std::deque<SessionCommand> commands_;
  SessionView view_;
  bool has_ended_ = false;

  std::thread thread_;  // last: it uses all of the above
};

}  // namespace haptometer::tools
