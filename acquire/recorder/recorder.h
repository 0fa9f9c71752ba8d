#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>

#include "acquire/recorder/row_sink.h"
#include "acquire/recorder/trigger.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// When a recording begins to count, and when it ends by itself; without an end it runs until it is
/// stopped.
struct RecordingLimits {
  std::optional<MonotonicNs> duration_ns{};  ///< from Sensor::Begin, or from each trigger
  std::optional<std::uint64_t> readings{};   ///< of the recording, or from each trigger on
  std::optional<MonotonicNs> until_ns{};     ///< on the recorder's clock
  /// Rows are recorded from the trigger on. More than one shot needs a duration or a number of
  /// readings, by which a shot ends.
  std::optional<TriggerSetup> trigger{};
  /// Memory for rows that wait for the disk: 200 s of one channel at 10 kHz. Memory that is not
  /// needed is not touched.
  std::size_t most_waiting_bytes = std::size_t{64} << 20;
};

/// What came of a recording.
struct RecordingSummary {
  std::uint64_t readings = 0;  ///< all rows
  std::uint64_t measured = 0;  ///< rows in which some channel has a measurement
  std::uint64_t seen = 0;      ///< readings that came, recorded or not
  std::array<std::uint64_t, trial::kSampleStatusCount> statuses{};  ///< rows by RowStatus
  std::uint64_t gaps = 0;         ///< places where readings are missing, for whatever reason
  std::uint64_t lost = 0;         ///< readings that came and found the disk too slow
  std::uint64_t reconnects = 0;   ///< times the device went away and came back
  std::uint64_t triggers = 0;     ///< that fired
  std::optional<double> rate_hz;  ///< mean over the intervals between rows, with those of losses
                                  ///< that the sensor counts and without pauses of triggers,
                                  ///< absences and other losses; empty below 2 rows
  std::optional<double> interval_sd_s;  ///< jitter: standard deviation of the intervals
  std::uint64_t discarded_bytes = 0;    ///< bytes that formed no reading
  double elapsed_s = 0;                 ///< from the beginning to the last row
  bool is_away = false;                 ///< the device is gone at the moment
  bool connection_lost = false;         ///< it ended because the device went away
  bool source_ended = false;            ///< a program or a file gave less than was asked for, or
                                        ///< the source fell silent before the end
  bool fell_silent = false;             ///< the latter
  Findings found{};                     ///< of the recording, beside those of its sensor
  bool interrupted = false;             ///< that, or a stop before the end that was asked for

  /// Rows whose status is neither ok nor repeated.
  [[nodiscard]] std::uint64_t bad() const;
  [[nodiscard]] std::uint64_t repeated() const;
  /// readings - bad - repeated
  [[nodiscard]] std::uint64_t distinct() const { return readings - bad() - repeated(); }
};

/// Who looks on. They are called by the reading thread, which must get back to its port within a
/// few milliseconds.
struct RecordingHooks {
  std::function<void(const Reading&)> reading{};  ///< each reading that comes, recorded or not
  std::function<void(const RecordingSummary&)> progress{};  ///< about twice a second of the clock
  /// What a finding says, for the trial's remarks, where "doubt: " stands before a doubt; empty:
  /// none of those that the sensor makes only at the end are written.
  std::function<std::string(const Finding&)> say{};
};

/// Runs `sensor` (started) into `sink` until a limit, `stop`, the end of a replay or the loss of
/// the connection, then finishes it.
///
/// The calling thread reads; a second one writes (recorder/row_ring.h says why). What the ring has
/// no room for while the disk stalls is counted in `lost` and stands in the trial as a gap with its
/// number, unless the source waits (Sensor::waits). A lost connection, a return, a trigger, an
/// interruption, and what the sensor finds only at the end, are events in the trial.
///
/// A source falls silent where the last reading (a row that is neither kLate nor kBadFrame) came
/// before 99 % of a duration or of the time to `until_ns`, and longer before its end than 1.5 times
/// the longest wait before, the cost of a lost reply (Sensor::LostReplyNs) and 0.25 s: kFellSilent,
/// a doubt. Before a stop it is a note, of 3 s and more.
///
/// Between a thousand rows and the next event nothing allocates memory. The sink's clock is its
/// own; if it is a ManualClock it must not be `clock`. Errors (Cause::kFailed): the disk is full;
/// the file keeps what it holds.
[[nodiscard]] Result<RecordingSummary> Record(Sensor& sensor, RowSink& sink, Clock& clock,
                                              const std::atomic<bool>& stop,
                                              const RecordingLimits& limits,
                                              const RecordingHooks& hooks = {});

}  // namespace haptometer::acquire
