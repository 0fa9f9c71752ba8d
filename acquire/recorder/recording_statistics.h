#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "acquire/recorder/recorder.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"

namespace haptometer::acquire {

/// Mean rate and scatter of the intervals between times, while they come (Welford's recurrence,
/// which does not cancel where a sum of squares would). O(1) a time.
class IntervalStatistics {
 public:
  /// A row; `missing` are known to have been lost before it. The interval over these counts for the
  /// rate, as so many more, and for no deviation.
  void Add(MonotonicNs time_ns, std::uint64_t missing);
  /// The interval up to the next time is none of the source's: it does not count.
  void Restart();

  /// Whether `missing` rows explain the interval up to `time_ns`, which may be 0.25 s longer and
  /// 0.05 s shorter: a counter that wraps does not say how often it has, and a damaged one counts
  /// what was never lost.
  [[nodiscard]] bool Explains(MonotonicNs time_ns, std::uint64_t missing) const;

  /// Intervals, those of lost rows too, per second of their own time; empty where no time has
  /// passed. Rows that come in blocks, an interval of half the mean and more ahead of each, have
  /// the time up to the next block: the first and the last block do not count, if there are others.
  [[nodiscard]] std::optional<double> RateHz() const;
  /// Standard deviation of the intervals in s (divided by n - 1); empty below two intervals.
  [[nodiscard]] std::optional<double> DeviationSeconds() const;

 private:
  std::uint64_t intervals_ = 0;  ///< between neighbours
  bool has_time_ = false;
  // intervals, those over lost rows too, and their time
  struct Span {
    std::uint64_t places = 0;
    MonotonicNs ns = 0;

    void Take(std::uint64_t more, MonotonicNs more_ns) {
      places += more;
      ns += more_ns;
    }
  };
  static constexpr MonotonicNs kNone = std::numeric_limits<MonotonicNs>::max();

  Span all_;
  Span whole_;                    ///< of whole blocks
  Span block_;                    ///< since the last block began
  MonotonicNs begin_ns_ = kNone;  ///< the interval ahead of that
  MonotonicNs last_ns_ = 0;
  double mean_s_ = 0;
  double squares_s2_ = 0;  ///< sum of squared deviations from the mean
};

/// Counts the places where readings are missing, while they come. O(1) a row.
///
/// - A uniform grid: the index jumps.
/// - A polled sensor: an interval longer than eight usual ones; several in a row are one gap.
/// - A free-running sensor: silence longer than eight usual intervals and 50 ms, which nothing
/// makes
///   up for: after a stall of the host all that waited arrives at once, and is no gap. It is one
///   when half a second later at least half of what the silence should have brought is still
///   missing. Silences within that half second count as one.
/// - A free-running sensor that numbers its lines: no silence between two of them is one.
/// The usual interval is the mean so far without the gaps.
class GapCounter {
 public:
  explicit GapCounter(trial::Timing timing, bool is_numbered = false)
      : timing_(timing), is_numbered_(is_numbered) {}

  void Add(const Reading& reading);

  /// What is missing before the next reading is meant to be, or is counted by somebody else: the
  /// interval up to it is no gap.
  void Restart();

  /// The recording ended at `time_ns`: a silence up to there that is too long is a gap too, though
  /// no reading followed it. Not for uniform grids, whose rows have no arrival.
  void End(MonotonicNs time_ns);

  /// Gaps up to the last reading, which decides what is still open.
  [[nodiscard]] std::uint64_t gaps() const;

 private:
  void AddInterval(MonotonicNs time_ns);
  void WatchSilence(MonotonicNs time_ns, bool is_long);
  [[nodiscard]] bool SilenceWasGap(MonotonicNs now_ns) const;
  [[nodiscard]] double UsualIntervalNs() const;

  trial::Timing timing_;
  bool is_numbered_;
  bool has_last_ = false;  ///< a reading that the next one's interval counts from
  std::uint64_t gaps_ = 0;
  std::int64_t last_index_ = 0;
  MonotonicNs last_ns_ = 0;
  MonotonicNs usual_sum_ns_ = 0;  ///< over usual_count_ intervals
  std::uint64_t usual_count_ = 0;
  bool in_gap_ = false;  ///< kPolled: the last interval was too long

  bool silence_open_ = false;  ///< kArrival: a silence waits for its verdict
  MonotonicNs silence_begin_ns_ = 0;
  MonotonicNs silence_ns_ = 0;
  double usual_before_ns_ = 0;    ///< the usual interval when it began
  std::uint64_t rows_since_ = 0;  ///< since it began
};

/// The reading thread's account of what came. O(1) a row, no allocation.
class Tally {
 public:
  /// `sensor` must outlive the tally; times count from `origin_ns`.
  Tally(const Sensor& sensor, MonotonicNs origin_ns);

  /// The time of a row since the beginning.
  [[nodiscard]] MonotonicNs SinceBegin(const Reading& reading) const;

  /// A reading came; whether it is recorded is not said yet.
  void See() { ++summary_.seen; }
  void Add(const Reading& reading);
  /// Rows that came and were not kept.
  void Lose(std::uint64_t rows);
  /// The device went away, and came back.
  void Leave();
  void Return();
  /// A trigger fired: what is missing before its first row is meant to be.
  void Fire();
  /// The recording ended at `since_begin_ns` by the clock, not by a row.
  void End(MonotonicNs since_begin_ns);

  [[nodiscard]] RecordingSummary Summary() const;

 private:
  void Restart();

  const Sensor& sensor_;
  trial::Timing timing_;
  double rate_hz_;
  MonotonicNs origin_ns_;
  RecordingSummary summary_;
  IntervalStatistics intervals_;
  GapCounter gaps_;
  std::uint64_t known_gaps_ = 0;  ///< beside those that the intervals show
};

}  // namespace haptometer::acquire
