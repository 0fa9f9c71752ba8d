#pragma once

#include <cstdint>

#include "acquire/sensor/sensor.h"

namespace haptometer::acquire {

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

}  // namespace haptometer::acquire
