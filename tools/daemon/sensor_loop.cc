#include "tools/daemon/sensor_loop.h"

#include <fmt/core.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <utility>

#include "tools/acquire/recording.h"
#include "tools/acquire/sensor_options.h"
#include "tools/cli/terminal.h"

namespace haptometer::tools {
namespace {

// intervals: of the check for room, the longest between retries, and that of the shown rate
constexpr MonotonicNs kMs = 1'000'000;
constexpr MonotonicNs kLookForRoomEveryNs = kNsPerS;
constexpr MonotonicNs kLongestRetryNs = 60 * kNsPerS;  // each attempt may leave an empty file
constexpr MonotonicNs kRateOverNs = 2 * kNsPerS;

// room to begin again, bytes: an eighth above the reserve, so that the disk is not full at once
std::uint64_t RoomToBegin(std::uint64_t reserve_bytes) { return reserve_bytes + reserve_bytes / 8; }

}  // namespace

SensorLoop::SensorLoop(const DaemonSensor& sensor, const DaemonConfig& config,
                       std::string command_line, Clock& clock)
    : wanted_(sensor), config_(config), command_line_(std::move(command_line)), clock_(clock) {
  status_.name = sensor.name;
  status_.port = sensor.options.port;
  status_.sensor = sensor.options.sensor;
  status_.since_utc = UtcNow();
  // a first beat, so that the watchdog's time counts from here
  reading_.Beat(clock_.Now());
  thread_ = std::thread([this] { Run(); });
}

SensorLoop::~SensorLoop() {
  Stop();
  thread_.join();
}

void SensorLoop::Stop() {
  // in this order: Run() clears stop_recording_ first and then reads stop_
  stop_.store(true);
  stop_recording_.store(true);
}

SensorStatus SensorLoop::Status() const {
  const std::lock_guard lock(mutex_);
  SensorStatus status = status_;
  if (trials_ != nullptr) status.file = trials_->file();
  return status;
}

void SensorLoop::Rotate() {
  const std::lock_guard lock(mutex_);
  if (trials_ != nullptr) trials_->RotateAtNextRow();
}

// both threads, as either may block: the reading one on the port, the writing one on the disk
bool SensorLoop::IsAlive(MonotonicNs longest_ns) const {
  const MonotonicNs now_ns = clock_.Now();
  return reading_.IsAlive(now_ns, longest_ns) && writing_.IsAlive(now_ns, longest_ns);
}

std::optional<Error> SensorLoop::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

// --- what the thread does ---

void SensorLoop::Run() {
  // one pass for each recording: room on the disk, then a device, then trials until it ends
  while (!stop_.load()) {
    stop_recording_.store(false);
    if (stop_.load() || !WaitForRoom()) break;
    const auto sensor = WaitForDevice();
    if (!sensor) break;
    RecordTrials(*sensor);
  }
  Enter(LoopState::kStopped);
  reading_.Rest();
}

bool SensorLoop::WaitForRoom() {
  // first the reserve itself; once that was not met, the larger RoomToBegin()
  for (std::uint64_t least = config_.reserve_bytes; !stop_.load(); Nap(kLookForRoomEveryNs)) {
    const auto free_bytes = FreeBytes(config_.trials.directory);
    // a disk whose free space is not known is used
    if (!free_bytes || *free_bytes >= least) return true;
    if (least == config_.reserve_bytes) {
      Say(fmt::format("waits: less than {} bytes are free in {}", least, config_.trials.directory));
      Enter(LoopState::kWaitingForDisk);
      const std::lock_guard lock(mutex_);
      ++status_.disk_waits;
      // stored in the next trial's metadata as the reason of the gap in time
      pause_note_ = "the disk had no room since " + status_.since_utc;
    }
    least = RoomToBegin(config_.reserve_bytes);
  }
  return false;
}

// a started sensor, or nullptr when the loop stops or the configuration is wrong
std::unique_ptr<acquire::ReconnectingSensor> SensorLoop::WaitForDevice() {
  const auto open = [this] { return OpenSensor(wanted_.options, clock_); };
  acquire::RetryPause pause;
  while (!stop_.load()) {
    reading_.Beat(clock_.Now());
    auto sensor = std::make_unique<acquire::ReconnectingSensor>(open, std::nullopt, clock_);
    const auto started = sensor->Start(stop_recording_);
    if (started) return sensor;
    if (stop_.load()) break;
    Enter(LoopState::kWaitingForDevice);
    NoteError(started.error());
    // settings that the sensor does not have: no retry can correct the file
    if (started.error().cause == Cause::kUsage) {
      const std::lock_guard lock(mutex_);
      refused_ = started.error();
      break;
    }
    Nap(pause.Next());
  }
  return nullptr;
}

trial::TrialHeader SensorLoop::Header(const acquire::Sensor& sensor) {
  trial::TrialHeader header = RecordingHeader(sensor, false, wanted_.labels, command_line_);
  // each trial states the reason of a pause before it, and the file that it continues
  if (!pause_note_.empty()) header.metadata.notes.push_back(std::exchange(pause_note_, {}));
  if (!last_file_.empty()) header.metadata.fields["continues"] = last_file_;
  return header;
}

void SensorLoop::RecordTrials(acquire::ReconnectingSensor& sensor) {
  const auto name = [this](std::uint64_t part) {
    return NextTrialPath(config_.trials, wanted_.name, UtcNow(), part);
  };
  auto trials = acquire::TrialRotation::Begin(name, Header(sensor), config_.rotation, clock_,
                                              {.flush_interval_s = config_.flush_s});
  // errors of the disk end in `written`; a lost device does not end a recording
  const auto written = trials ? RecordInto(**trials, sensor) : std::unexpected(trials.error());
  CloseCounts();
  if (written) {
    retry_ns_ = 0;
    return;
  }
  // a full disk or a removed directory: written trials stay, and the recording is tried again
  NoteError(written.error());
  Enter(LoopState::kWaitingForDisk);
  pause_note_ =
      "the trial before could not be written: " + cli::WithOptions(written.error().Text(), "");
  // pause doubled from 1 s to 60 s: each attempt may leave an empty file
  retry_ns_ = std::clamp(2 * retry_ns_, kNsPerS, kLongestRetryNs);
  Nap(retry_ns_);
}

Result<void> SensorLoop::RecordInto(acquire::TrialRotation& trials,
                                    acquire::ReconnectingSensor& sensor) {
  WriteTo(&trials);
  Enter(LoopState::kRecording);
  Say(fmt::format("records {} into {}", sensor.header().metadata.source, trials.file()));
  // the sink ends the recording when the free space falls below the reserve
  GuardedTrials sink(trials,
                     {.directory = config_.trials.directory,
                      .reserve_bytes = config_.reserve_bytes,
                      .stop = stop_recording_,
                      .pulse = writing_},
                     clock_);
  const auto progress = [&](const acquire::RecordingSummary& so_far) {
    ShowProgress(so_far, cli::WithOptions(sensor.last_refusal(), ""));
  };
  const auto summary = acquire::Record(sensor, sink, clock_, stop_recording_, {},
                                       {.reading = {}, .progress = progress, .say = InWords});
  // the writing thread has ended: no beat is expected of it
  writing_.Rest();
  WriteTo(nullptr);
  last_file_ = trials.file();
  if (!summary) return std::unexpected(summary.error());
  Count(*summary);
  if (sink.disk_is_low()) Say(fmt::format("closed {}: the disk is nearly full", last_file_));
  return {};
}

// --- what is reported ---

// called about twice per second by the reading thread, also while the device is away
void SensorLoop::ShowProgress(const acquire::RecordingSummary& summary,
                              const std::string& refusal) {
  const MonotonicNs now_ns = clock_.Now();
  reading_.Beat(now_ns);
  const SensorStatus shown = Status();
  if (summary.is_away && shown.state == LoopState::kRecording) Say("the connection was lost");
  Count(summary);
  if (Status().reconnects > shown.reconnects) Say("is back");
  Enter(summary.is_away ? LoopState::kAway : LoopState::kRecording);
  if (summary.is_away && !refusal.empty()) (void)SetLastError(refusal);
  MeasureRate(now_ns);
}

// readings per second over the last 2 s: a mean over days would mask a present change
void SensorLoop::MeasureRate(MonotonicNs now_ns) {
  if (now_ns - rate_since_ns_ < kRateOverNs) return;
  const std::lock_guard lock(mutex_);
  const double seconds = SecondsFromNs(now_ns - rate_since_ns_);
  const std::uint64_t came = status_.readings - rate_readings_;
  status_.rate_hz.reset();
  if (came > 0 && rate_since_ns_ > 0) status_.rate_hz = static_cast<double>(came) / seconds;
  rate_since_ns_ = now_ns;
  rate_readings_ = status_.readings;
}

// counts since the daemon's start: closed recordings plus the present one
void SensorLoop::Count(const acquire::RecordingSummary& summary) {
  const std::lock_guard lock(mutex_);
  status_.readings = before_.readings + summary.readings;
  status_.bad = before_.bad + summary.bad();
  status_.gaps = before_.gaps + summary.gaps;
  status_.lost = before_.lost + summary.lost;
  status_.reconnects = before_.reconnects + summary.reconnects;
}

// the recording is over; its counts enter those of closed recordings
void SensorLoop::CloseCounts() {
  const std::lock_guard lock(mutex_);
  before_ = status_;
  status_.rate_hz.reset();
  rate_since_ns_ = 0;
}

void SensorLoop::Enter(LoopState state) {
  const std::lock_guard lock(mutex_);
  if (status_.state == state) return;
  status_.state = state;
  status_.since_utc = UtcNow();
}

void SensorLoop::WriteTo(acquire::TrialRotation* trials) {
  const std::lock_guard lock(mutex_);
  trials_ = trials;
}

void SensorLoop::NoteError(const Error& error) {
  // --NAME in a message becomes NAME, since settings are keys of the daemon's file
  const std::string text = cli::WithOptions(error.Text(), "");
  if (SetLastError(text)) Say(text);
}

// a repeated error is stored once: retries do not fill the log
bool SensorLoop::SetLastError(const std::string& text) {
  const std::lock_guard lock(mutex_);
  if (status_.last_error == text) return false;
  status_.last_error = text;
  return true;
}

void SensorLoop::Say(std::string_view text) const {
  cli::Remark("acquire", fmt::format("{}: {}", wanted_.name, text));
}

// sleeps in steps of 100 ms with a beat each, and ends early on Stop()
void SensorLoop::Nap(MonotonicNs ns) {
  const MonotonicNs until_ns = clock_.Now() + ns;
  while (!stop_.load()) {
    const MonotonicNs now_ns = clock_.Now();
    reading_.Beat(now_ns);
    if (now_ns >= until_ns) return;
    clock_.SleepUntil(std::min(until_ns, now_ns + 100 * kMs));
  }
}

namespace {

// interval between two checks of the free space
constexpr MonotonicNs kLookEveryNs = kNsPerS / 5;

}  // namespace

std::optional<std::uint64_t> FreeBytes(const std::string& directory) {
  struct statvfs disk{};
  if (statvfs(directory.c_str(), &disk) != 0) return std::nullopt;
  // f_bavail: blocks that unprivileged users may write, in units of f_frsize
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

void GuardedTrials::LookAtDisk() {
  const MonotonicNs now_ns = clock_.Now();
  watched_.pulse.Beat(now_ns);
  if (disk_is_low_ || now_ns < next_look_ns_) return;
  next_look_ns_ = now_ns + kLookEveryNs;
  const auto free_bytes = FreeBytes(watched_.directory);
  disk_is_low_ = free_bytes && *free_bytes < watched_.reserve_bytes;
  // ends the recording properly: the last trial is closed while there is room for it
  if (disk_is_low_) watched_.stop.store(true);
}

Result<void> GuardedTrials::Append(const trial::Row& row) {
  LookAtDisk();
  return trials_.Append(row);
}

Result<void> GuardedTrials::AddEvent(trial::Event event) {
  return trials_.AddEvent(std::move(event));
}

Result<void> GuardedTrials::FlushIfDue() {
  LookAtDisk();
  return trials_.FlushIfDue();
}

// a trial that is closed early states its reason
Result<void> GuardedTrials::Finish() {
  if (disk_is_low_) {
    trial::Event event;
    event.kind = trial::EventKind::kRemark;
    event.text =
        fmt::format("closed: less than {} bytes are free on the disk", watched_.reserve_bytes);
    HAPTOMETER_TRY(trials_.AddEvent(std::move(event)));
  }
  return trials_.Finish();
}

}  // namespace haptometer::tools
