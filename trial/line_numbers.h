#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "trial/time_base.h"

namespace haptometer::trial {

/// What is known of a source that numbers its lines; 0 where it is not known.
struct NumberedLines {
  std::uint64_t turn = 0;  ///< the numbers go from 0 to turn - 1
  double wire_ns = 0;      ///< of one line on its wire: lines do not follow each other faster
};

/// Losses by the numbers of lines, after a look at the times of arrival.
struct JudgedLosses {
  std::vector<MissingRows> missing;  ///< for FitArrivalTimes: without what is refused
  std::vector<MissingRows> refused;  ///< as claimed, in the order of rows
};

/// Whether the arrival times hold the losses that the numbers claim. A line sent twice claims a
/// turn less one, a wrong number one part of a turn before itself and the rest behind, a counter
/// that is reset any number.
///
/// Lines are late, never early. A loss of n lines that was none makes all lines behind it early by
/// n periods against the lower envelope, which is the least lateness of the last five windows (0.1
/// s or 16 lines and more) that came no faster than the source sends: whatever a burst or a stall
/// holds back is late and shows nothing. Where a line is early, the largest loss claimed since the
/// envelope was last seen is refused if that is at least half of it; what is early by less than 5
/// ms, two periods or three times the scatter of the minima is not judged, nor is what comes before
/// the first such window. Where all lines claimed would have needed more than the time on their
/// wire, and a second more, all losses are refused.
///
/// A refused loss becomes a break with an unknown number of missing lines, of refused ones that
/// follow each other the first alone; two refused ones beside one line that make up a turn are a
/// wrong number, and no break. `missing` is sorted by row. Cost: O(rows).
[[nodiscard]] JudgedLosses JudgeLosses(std::span<const std::int64_t> time_ns,
                                       std::span<const MissingRows> missing,
                                       const NumberedLines& lines);

}  // namespace haptometer::trial
