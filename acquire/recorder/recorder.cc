#include "acquire/recorder/recorder.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquire/recorder/recording_statistics.h"
#include "acquire/recorder/row_ring.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kProgressEveryNs = kNsPerS / 2;
constexpr MonotonicNs kNotedSilenceNs = 3 * kNsPerS;
// of a length, up to which the readings of a whole recording reach at least
constexpr double kWholeShare = 0.99;
// after a loss, rows are accepted again when 1/8 of the ring is free
constexpr std::size_t kResumeFraction = 8;

// --- the writing thread ---

// writes all rows and events that wait, each event at its place among the rows
Result<void> WriteWaiting(RowRing& ring, RowSink& sink) {
  while (true) {
    // the row first: an event that was added before it is then there
    const auto row = ring.Front();
    if (auto event = ring.TakeEvent()) {
      HAPTOMETER_TRY(sink.AddEvent(std::move(*event)));
      continue;
    }
    if (!row) return {};
    HAPTOMETER_TRY(sink.Append(*row));
    ring.Pop();
  }
}

// until the ring is closed and empty, or the disk fails
Result<void> WriteRows(RowRing& ring, RowSink& sink) {
  while (ring.Wait()) {
    HAPTOMETER_TRY(WriteWaiting(ring, sink));
    HAPTOMETER_TRY(sink.FlushIfDue());
  }
  return {};
}

// --- the reading thread ---

enum class Ending : std::uint8_t { kDone, kStopped, kSourceEnded, kConnectionLost, kWriterGaveUp };

using Missing = std::optional<std::optional<std::uint64_t>>;  // as in trial::Event

// Reads the sensor up to an end, and passes rows and events to the ring.
class Reader {
 public:
  Reader(Sensor& sensor, RowRing& ring, Clock& clock, const std::atomic<bool>& stop,
         const RecordingLimits& limits, const RecordingHooks& hooks)
      : sensor_(sensor),
        ring_(ring),
        clock_(clock),
        stop_(stop),
        limits_(limits),
        hooks_(hooks),
        watch_(limits.trigger.value_or(TriggerSetup{}), sensor.header()),
        before_(limits.trigger ? limits.trigger->pre_samples : 0, sensor.header().channels.size()),
        phase_(limits.trigger ? Phase::kArmed : Phase::kRecording),
        origin_ns_(sensor.Begin()),
        tally_(sensor, origin_ns_) {}

  Ending Run();
  [[nodiscard]] RecordingSummary Summary() const { return tally_.Summary(); }
  [[nodiscard]] bool EndedEarly() const;
  [[nodiscard]] const std::optional<Finding>& silence() const { return silence_; }

 private:
  enum class Phase : std::uint8_t { kRecording, kArmed, kHoldOff };

  [[nodiscard]] std::optional<Ending> Step();
  [[nodiscard]] bool Take(MonotonicNs time_ns);
  void Fire(MonotonicNs time_ns);
  [[nodiscard]] bool EndsShot(MonotonicNs time_ns) const;
  [[nodiscard]] bool NextShot();
  void NoteReading(MonotonicNs time_ns);
  void JudgeSilence(MonotonicNs silent_ns, MonotonicNs length_ns);
  [[nodiscard]] MonotonicNs SilentNs() const { return clock_.Now() - origin_ns_ - came_clock_ns_; }
  void WaitForRoom() const;
  void Keep(const Reading& reading);
  void NoteLost();
  void Say(trial::EventKind kind, std::string text, Missing missing = {});
  void ShowProgress();

  Sensor& sensor_;
  RowRing& ring_;
  Clock& clock_;
  const std::atomic<bool>& stop_;
  const RecordingLimits& limits_;
  const RecordingHooks& hooks_;
  TriggerWatch watch_;
  PreSamples before_;
  Phase phase_;
  MonotonicNs origin_ns_;
  Tally tally_;
  Reading reading_;
  MonotonicNs shot_start_ns_ = 0;    ///< since the beginning: 0, or the trigger
  std::uint64_t shot_readings_ = 0;  ///< from there on
  std::uint64_t lost_here_ = 0;      ///< rows without room that the trial does not hold yet
  std::uint64_t missing_here_ = 0;   ///< and those that the sensor reports as lost before them
  bool has_come_ = false;            ///< a reading
  MonotonicNs came_ns_ = 0;          ///< the last one, by its own time since the beginning
  MonotonicNs came_clock_ns_ = 0;    ///< and by the clock
  MonotonicNs longest_wait_ns_ = 0;  ///< for a reading
  std::optional<Finding> silence_;
  MonotonicNs away_since_ns_ = 0;
  MonotonicNs progress_ns_ = 0;
};

void Reader::Say(trial::EventKind kind, std::string text, Missing missing) {
  trial::Event event;
  event.kind = kind;
  // a source that waits has a time of its own
  event.time_ns = sensor_.waits() ? tally_.SinceBegin(reading_) : clock_.Now() - origin_ns_;
  event.text = std::move(text);
  event.missing = missing;
  ring_.PushEvent(std::move(event));
}

void Reader::NoteLost() {
  if (lost_here_ == 0) return;
  Say(trial::EventKind::kGap,
      fmt::format("{} readings were lost here: the disk was slower than the sensor", lost_here_),
      // one gap for all of them: rows without room, and rows that the sensor itself lost
      std::optional(lost_here_ + std::exchange(missing_here_, 0)));
  tally_.Lose(std::exchange(lost_here_, 0));
}

// a source that waits is not outrun by the disk
void Reader::WaitForRoom() const {
  constexpr std::chrono::milliseconds kNap(1);
  while (sensor_.waits() && ring_.room() == 0 && !ring_.given_up() && !stop_.load()) {
    std::this_thread::sleep_for(kNap);
  }
}

void Reader::Keep(const Reading& reading) {
  WaitForRoom();
  // after a loss there is some room first: a gap a row would cost more than the rows
  // 1 row in normal operation, 1/8 of the ring after a loss
  const std::size_t needed = lost_here_ == 0 ? 1 : 1 + ring_.capacity() / kResumeFraction;
  if (ring_.room() < std::min(needed, ring_.capacity())) {
    ++lost_here_;
    missing_here_ += static_cast<std::uint64_t>(reading.lost_before);
    return;
  }
  NoteLost();
  // the gap comes before the row, at its place in the trial
  if (reading.lost_before > 0) {
    Say(trial::EventKind::kGap,
        fmt::format("readings lost here, by the sensor's own count: {}", reading.lost_before),
        std::optional(static_cast<std::uint64_t>(reading.lost_before)));
  } else if (reading.follows_gap) {
    Say(trial::EventKind::kGap, "readings may be missing here, as in the recording",
        std::optional<std::uint64_t>());
  }
  const bool is_in = ring_.Push(reading, origin_ns_);
  HAPTOMETER_CHECK(is_in, "{} readings", tally_.Summary().readings);
  tally_.Add(reading);
}

void Reader::Fire(MonotonicNs time_ns) {
  tally_.Fire();
  // without a number: how many rows are missing since the last shot is not known
  Say(trial::EventKind::kRemark,
      fmt::format("trigger {} {} rows from here: {}", tally_.Summary().triggers, before_.kept(),
                  watch_.Text()),
      std::optional<std::uint64_t>());
  // rows before the trigger first, in the order of time
  before_.Drain([this](const Reading& earlier) { Keep(earlier); });
  shot_start_ns_ = time_ns;
  shot_readings_ = 0;
  phase_ = Phase::kRecording;
}

// ends by duration since the trigger (or the beginning), or by number of readings
bool Reader::EndsShot(MonotonicNs time_ns) const {
  return (limits_.duration_ns && time_ns - shot_start_ns_ >= *limits_.duration_ns) ||
         (limits_.readings && shot_readings_ >= *limits_.readings);
}

// whether another trigger is waited for
bool Reader::NextShot() {
  if (!limits_.trigger || tally_.Summary().triggers >= limits_.trigger->shots) return false;
  phase_ = Phase::kHoldOff;
  return true;
}

// Whether a source that ended gave less than was asked for, of each shot. The last row of a
// duration lies an interval before its end, in bursts some more: 1 % is left to it.
bool Reader::EndedEarly() const {
  constexpr double kIntervals = 1.5;
  const RecordingSummary summary = tally_.Summary();
  if (limits_.trigger && summary.triggers < limits_.trigger->shots) return true;
  // the last shot was whole
  if (phase_ != Phase::kRecording) return false;
  if (limits_.readings && shot_readings_ < *limits_.readings) return true;
  if (!limits_.duration_ns) return false;
  const double interval_s = summary.rate_hz ? 1 / *summary.rate_hz : 0;
  const double shot_s = summary.elapsed_s - SecondsFromNs(shot_start_ns_);
  return shot_s + kIntervals * interval_s < kWholeShare * SecondsFromNs(*limits_.duration_ns);
}

// a row is a reading where the source answered, be it that there is no value
void Reader::NoteReading(MonotonicNs time_ns) {
  const trial::SampleStatus status = RowStatus(reading_);
  if (status == trial::SampleStatus::kLate || status == trial::SampleStatus::kBadFrame) return;
  longest_wait_ns_ = std::max({longest_wait_ns_, time_ns - came_ns_, SilentNs()});
  came_ns_ = time_ns;
  // the rows of a file may be ahead of the clock
  came_clock_ns_ = std::max(clock_.Now() - origin_ns_, time_ns);
  has_come_ = true;
}

// whether the source was silent for the last `silent_ns` of `length_ns`, unlike before
void Reader::JudgeSilence(MonotonicNs silent_ns, MonotonicNs length_ns) {
  constexpr double kWaits = 1.5;
  constexpr double kShortestS = 0.25;
  const double usual_s =
      kWaits * SecondsFromNs(longest_wait_ns_) + SecondsFromNs(sensor_.LostReplyNs()) + kShortestS;
  const double length_s = SecondsFromNs(length_ns);
  const double last_s = length_s - SecondsFromNs(silent_ns);
  if (!has_come_ || length_s - last_s <= usual_s || last_s >= kWholeShare * length_s) return;
  silence_ = Finding{.severity = Severity::kDoubt,
                     .kind = FindingKind::kFellSilent,
                     .numbers = {{"last_reading_s", last_s}, {"length_s", length_s}}};
}

// one reading of the sensor; false for the first one behind the end
bool Reader::Take(MonotonicNs time_ns) {
  tally_.See();
  if (hooks_.reading) hooks_.reading(reading_);
  // the end of a shot follows from the reading's own time, not from the clock
  if (phase_ == Phase::kRecording && EndsShot(time_ns) && !NextShot()) {
    if (limits_.duration_ns) {
      JudgeSilence(*limits_.duration_ns + shot_start_ns_ - came_ns_, *limits_.duration_ns);
    }
    return false;
  }
  NoteReading(time_ns);
  if (phase_ == Phase::kHoldOff && time_ns - shot_start_ns_ >= limits_.trigger->hold_off_ns) {
    phase_ = Phase::kArmed;
  }
  // an edge needs the value before it, so the watch receives every reading
  const bool fires = limits_.trigger && watch_.Fires(reading_);
  if (phase_ == Phase::kArmed && fires) Fire(time_ns);
  // outside of a shot a reading is a possible pre-sample of the next trigger
  if (phase_ != Phase::kRecording) {
    before_.Keep(reading_);
    return true;
  }
  ++shot_readings_;
  Keep(reading_);
  // the last one that was asked for needs no other behind it
  return !limits_.readings || shot_readings_ < *limits_.readings || NextShot();
}

std::optional<Ending> Reader::Step() {
  switch (sensor_.Next(reading_)) {
    case Outcome::kReading:
      if (!Take(tally_.SinceBegin(reading_))) return Ending::kDone;
      break;
    case Outcome::kNothing: {
      // the end of the time where no row comes
      const MonotonicNs elapsed_ns = clock_.Now() - origin_ns_;
      if (phase_ == Phase::kRecording && EndsShot(elapsed_ns) && !NextShot()) {
        tally_.End(elapsed_ns);
        if (limits_.duration_ns) JudgeSilence(SilentNs(), *limits_.duration_ns);
        return Ending::kDone;
      }
      break;
    }
    case Outcome::kEnd:
      return Ending::kSourceEnded;
    case Outcome::kGone:
      return Ending::kConnectionLost;
    case Outcome::kAway:
      // the interruption counts as one gap
      away_since_ns_ = clock_.Now();
      tally_.Leave();
      Say(trial::EventKind::kRemark, "the connection was lost");
      break;
    case Outcome::kBack:
      tally_.Return();
      Say(trial::EventKind::kReconnect,
          fmt::format("the device is back after {:.3f} s",
                      SecondsFromNs(clock_.Now() - away_since_ns_)),
          std::optional<std::uint64_t>());
      break;
  }
  return std::nullopt;
}

void Reader::ShowProgress() {
  if (!hooks_.progress || clock_.Now() - progress_ns_ < kProgressEveryNs) return;
  progress_ns_ = clock_.Now();
  hooks_.progress(tally_.Summary());
}

// one step per reading or slice; the stop is tested before each
Ending Reader::Run() {
  progress_ns_ = clock_.Now();
  Ending ending = Ending::kStopped;
  while (!stop_.load() && !ring_.given_up()) {
    if (limits_.until_ns && clock_.Now() >= *limits_.until_ns) {
      JudgeSilence(SilentNs(), *limits_.until_ns - origin_ns_);
      ending = Ending::kDone;
      break;
    }
    if (const auto ended = Step()) {
      ending = *ended;
      break;
    }
    ShowProgress();
  }
  // an error of the disk takes precedence over the other endings
  if (ring_.given_up()) ending = Ending::kWriterGaveUp;
  // interrupted: the recording ends now, not at the last row
  if (ending == Ending::kStopped) {
    const MonotonicNs elapsed_ns = clock_.Now() - origin_ns_;
    tally_.End(elapsed_ns);
    // a stop is no end that was asked for: a note, of a silence of some seconds
    if (SilentNs() >= kNotedSilenceNs) JudgeSilence(SilentNs(), elapsed_ns);
    if (silence_) silence_->severity = Severity::kNote;
  }
  NoteLost();
  if (ending == Ending::kConnectionLost) {
    // a device that was disconnected and then abandoned has its remark already
    const bool is_told = tally_.Summary().is_away;
    Say(trial::EventKind::kRemark,
        is_told ? "waiting for the device ended" : "the connection was lost");
  }
  return ending;
}

// findings as texts of remarks: "doubt: errors on the wire: 1 timeout"
std::vector<std::string> Sentences(const Findings& findings, const RecordingHooks& hooks) {
  std::vector<std::string> sentences;
  if (!hooks.say) return sentences;
  for (const Finding& found : findings.list()) {
    const bool is_doubt = found.severity == Severity::kDoubt;
    sentences.push_back(std::string(is_doubt ? trial::kDoubtMark : "") + hooks.say(found));
  }
  return sentences;
}

bool HasEnd(const RecordingLimits& limits) {
  return limits.duration_ns || limits.readings || limits.until_ns || limits.trigger;
}

}  // namespace

std::uint64_t RecordingSummary::repeated() const {
  return statuses[static_cast<std::size_t>(trial::SampleStatus::kRepeated)];
}

// readings that are neither ok nor repeated
std::uint64_t RecordingSummary::bad() const {
  return readings - repeated() - statuses[static_cast<std::size_t>(trial::SampleStatus::kOk)];
}

Result<RecordingSummary> Record(Sensor& sensor, RowSink& sink, Clock& clock,
                                const std::atomic<bool>& stop, const RecordingLimits& limits,
                                const RecordingHooks& hooks) {
  RowRing ring(limits.most_waiting_bytes, sensor.header().channels.size());
  // the disk has its own thread: a slow write must not delay a poll
  Result<void> written;
  std::thread writing([&] {
    written = WriteRows(ring, sink);
    if (!written) ring.GiveUp();
  });
  // findings before the first row, so that only new ones are added at the end
  const std::vector<std::string> said = Sentences(sensor.Found(), hooks);
  Reader reader(sensor, ring, clock, stop, limits, hooks);
  const Ending ending = reader.Run();
  RecordingSummary summary = reader.Summary();
  summary.connection_lost = ending == Ending::kConnectionLost;
  if (reader.silence()) summary.found.Add(*reader.silence());
  summary.fell_silent = reader.silence() && ending == Ending::kDone;
  summary.source_ended =
      summary.fell_silent || (ending == Ending::kSourceEnded && reader.EndedEarly());
  // without a stated end, a stop is the regular ending
  summary.interrupted = summary.source_ended || (ending == Ending::kStopped && HasEnd(limits));
  if (summary.interrupted) {
    ring.PushEvent(
        {.kind = trial::EventKind::kRemark, .text = std::string(trial::kInterruptedText)});
  }
  // what is known of the device only now
  Findings found = sensor.Found();
  found.AddAll(summary.found);
  for (std::string& text : Sentences(found, hooks)) {
    if (std::ranges::find(said, text) != said.end()) continue;
    ring.PushEvent({.kind = trial::EventKind::kRemark, .text = std::move(text)});
  }
  // the thread writes what is left, and ends
  ring.Close();
  writing.join();
  if (!written) return std::unexpected(written.error());
  HAPTOMETER_TRY(sink.Finish());
  return summary;
}

}  // namespace haptometer::acquire
