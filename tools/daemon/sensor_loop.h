#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "acquire/recorder/recorder.h"
#include "acquire/recorder/row_sink.h"
#include "acquire/sensor/reconnecting_sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "tools/daemon/daemon_config.h"
#include "tools/daemon/status.h"

namespace haptometer::tools {

/// The signs of life of one thread, for the watchdog. Written by that thread, read by any.
class Pulse {
 public:
  void Beat(MonotonicNs now_ns) { beat_ns_.store(now_ns); }
  /// The thread is over, or not begun: nobody expects a beat.
  void Rest() { beat_ns_.store(kResting); }

  /// Whether it rests or has beaten within the last `longest_ns`.
  [[nodiscard]] bool IsAlive(MonotonicNs now_ns, MonotonicNs longest_ns) const {
    const MonotonicNs beat_ns = beat_ns_.load();
    return beat_ns == kResting || now_ns - beat_ns <= longest_ns;
  }

 private:
  static constexpr MonotonicNs kResting = -1;
  std::atomic<MonotonicNs> beat_ns_{kResting};
};

/// One sensor of the daemon, in its own thread until it is stopped: waits for room on the disk and
/// for the device, records trials, and begins again whenever that ends.
class SensorLoop {
 public:
  /// Begins. All must outlive the loop; `command_line` goes into the trials.
  SensorLoop(const DaemonSensor& sensor, const DaemonConfig& config, std::string command_line,
             Clock& clock);
  /// Stops and waits until the trial is closed.
  ~SensorLoop();
  SensorLoop(const SensorLoop&) = delete;
  SensorLoop& operator=(const SensorLoop&) = delete;

  /// Asks it to end; returns at once.
  void Stop();

  /// Begins the next file with the next reading; nothing where none is written.
  void Rotate();

  [[nodiscard]] SensorStatus Status() const;
  /// Whether both of its threads got on within the last `longest_ns`.
  [[nodiscard]] bool IsAlive(MonotonicNs longest_ns) const;
  /// Why it ended by itself: the file asks for what the sensor does not have.
  [[nodiscard]] std::optional<Error> refused() const;

 private:
  void Run();
  [[nodiscard]] bool WaitForRoom();
  [[nodiscard]] std::unique_ptr<acquire::ReconnectingSensor> WaitForDevice();
  void RecordTrials(acquire::ReconnectingSensor& sensor);
  [[nodiscard]] Result<void> RecordInto(acquire::TrialRotation& trials,
                                        acquire::ReconnectingSensor& sensor);
  [[nodiscard]] trial::TrialHeader Header(const acquire::Sensor& sensor);
  void ShowProgress(const acquire::RecordingSummary& summary, const std::string& refusal);
  void Count(const acquire::RecordingSummary& summary);
  void CloseCounts();
  void Enter(LoopState state);
  void WriteTo(acquire::TrialRotation* trials);
  void MeasureRate(MonotonicNs now_ns);
  void NoteError(const Error& error);
  [[nodiscard]] bool SetLastError(const std::string& text);  ///< false: it was that already
  void Say(std::string_view text) const;
  void Nap(MonotonicNs ns);

  const DaemonSensor& wanted_;
  const DaemonConfig& config_;
  std::string command_line_;
  Clock& clock_;

  std::atomic<bool> stop_{false};            ///< the loop is to end
  std::atomic<bool> stop_recording_{false};  ///< the recording is: for this, or for want of room
  Pulse reading_;
  Pulse writing_;

  // the loop's thread alone
  std::string last_file_;     ///< that was closed, for the next one to name
  std::string pause_note_;    ///< why there is a pause before the next trial
  MonotonicNs retry_ns_ = 0;  ///< pause after a trial that could not be written
  MonotonicNs rate_since_ns_ = 0;
  std::uint64_t rate_readings_ = 0;

  mutable std::mutex mutex_;                  ///< for what follows
  acquire::TrialRotation* trials_ = nullptr;  ///< while they are written
  SensorStatus status_;
  SensorStatus before_;  ///< counts of the recordings that are over
  std::optional<Error> refused_;

  std::thread thread_;  ///< last: it uses all of the above
};

/// Bytes that may still be written below `directory`; empty where the system does not tell.
[[nodiscard]] std::optional<std::uint64_t> FreeBytes(const std::string& directory);

/// Hands rows on to trials as long as the disk has room, and ends the recording before it is full.
///
/// Five times a second it looks at what is free; below the reserve it asks the recording to stop,
/// and the last trial is closed with a remark that says why. Used by the writing thread.
class GuardedTrials final : public acquire::RowSink {
 public:
  struct Watched {
    std::string directory;
    std::uint64_t reserve_bytes;
    std::atomic<bool>& stop;  ///< set when the room is gone
    Pulse& pulse;             ///< beats with every look at what waits to be written
  };

  /// All must outlive the sink.
  GuardedTrials(acquire::RowSink& trials, Watched watched, Clock& clock)
      : trials_(trials), watched_(std::move(watched)), clock_(clock) {}

  [[nodiscard]] Result<void> Append(const trial::Row& row) override;
  [[nodiscard]] Result<void> AddEvent(trial::Event event) override;
  [[nodiscard]] Result<void> FlushIfDue() override;
  [[nodiscard]] Result<void> Finish() override;

  /// Whether it stopped the recording.
  [[nodiscard]] bool disk_is_low() const { return disk_is_low_; }

 private:
  void LookAtDisk();

  acquire::RowSink& trials_;
  Watched watched_;
  Clock& clock_;
  MonotonicNs next_look_ns_ = 0;
  bool disk_is_low_ = false;
};

}  // namespace haptometer::tools
