#pragma once

#include <atomic>
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
#include "tools/daemon/pulse.h"
#include "tools/daemon/status_report.h"

namespace haptometer::tools {

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

}  // namespace haptometer::tools
