#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/result.h"
#include "trial/trial_writer.h"

namespace haptometer::acquire {

/// When a recording ends by itself; without either it runs until it is stopped.
struct RecordingLimits {
  std::optional<MonotonicNs> duration_ns;  ///< counted from Sensor::Begin
  std::optional<std::uint64_t> readings;
  /// Rows that may wait for the disk: 100 s of a 10 kHz sensor, about 50 MB.
  std::size_t most_waiting_rows = 1'000'000;
};

/// What came of a recording.
struct RecordingSummary {
  std::uint64_t readings = 0;                                       ///< all rows
  std::array<std::uint64_t, trial::kSampleStatusCount> statuses{};  ///< rows by RowStatus
  std::uint64_t gaps = 0;               ///< places where readings are missing (GapCounter)
  std::optional<double> rate_hz;        ///< (rows - 1) / (last - first time); empty below 2 rows
  std::optional<double> interval_sd_s;  ///< jitter: standard deviation of the intervals
  std::uint64_t discarded_bytes = 0;    ///< bytes that formed no reading
  double elapsed_s = 0;                 ///< from the beginning to the last row
  bool connection_lost = false;         ///< it ended because the device went away

  /// Rows whose status is neither ok nor repeated.
  [[nodiscard]] std::uint64_t bad() const;
  [[nodiscard]] std::uint64_t repeated() const;
  /// readings - bad - repeated
  [[nodiscard]] std::uint64_t distinct() const { return readings - bad() - repeated(); }
};

/// Runs `sensor` (started) into `writer` until a limit, `stop`, the end of a replay or the loss of
/// the connection, then finishes the file with its closing record. A lost connection is a remark in
/// the file and a flag of the summary; what was recorded is kept.
///
/// The calling thread reads; a second one writes (recorder/row_queue.h says why). `progress`, if
/// set, is called by the calling thread about twice a second of `clock`. The writer's clock is its
/// own; if it is a ManualClock it must not be `clock`.
/// Errors (Cause::kFailed): the disk is full or too slow; the file keeps what it holds.
[[nodiscard]] Result<RecordingSummary> Record(
    Sensor& sensor, trial::TrialWriter& writer, Clock& clock, const std::atomic<bool>& stop,
    const RecordingLimits& limits,
    const std::function<void(const RecordingSummary&)>& progress = {});

}  // namespace haptometer::acquire
