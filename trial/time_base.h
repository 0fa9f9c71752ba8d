#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "trial/record.h"

namespace haptometer::trial {

/// Rows that are missing directly before row `row`; how many, where that is known.
struct MissingRows {
  std::size_t row = 0;
  std::optional<std::uint64_t> count{};
};

/// The place of each row on its source's grid: its number, and what is known to be missing before.
[[nodiscard]] std::vector<double> PlacesOf(std::size_t rows, std::span<const MissingRows> missing);

/// The straight lines behind the arrival times of a free-running source.
///
/// Model: row i of a stretch left the source at start_s + i / rate_hz and arrived d_i >= 0 later.
/// USB and operating system delay lines in bursts, never advance them, so a mean or a least-squares
/// line is biased; the lower envelope is not. Each stretch gets the line below all its arrival
/// times with the least sum of delays, which is the edge of the lower convex hull over the mean row
/// (Moon, Skelly, Towsley: "Estimation and removal of clock skew from network delay measurements",
/// INFOCOM 1999, sect. 3).
///
/// A new stretch begins where lines were lost: there the envelope rises and stays up. It is looked
/// for in the minima over windows of 0.1 s or a little more (at least 16 rows), with the slope of
/// the longest stretch taken off; a rise counts if the ten windows that follow stay up (at the end:
/// all, but at least two) and it exceeds half a period and three times the scatter of the minima. A
/// pause of more than 0.25 s that is not made up for counts wherever it is. A stall of the host,
/// however long, after which all that waited arrives, is no gap: lines that come much faster than
/// the source sends are late and show no rate and no rise, and stalls may hold most of the rows.
/// Where within a burst the lines are missing cannot be seen; the largest interval before the first
/// line that is on time again is taken, and no line is fitted to the first window behind it. Pieces
/// too short for a rate of their own take that of all, weighted by the cube of their rows.
///
/// Lines may come in blocks (WiFi, a converter from serial to TCP): all that a cycle brought at
/// once, the last one in time. The same model holds, with the period from one block's end to the
/// next; no silence is a gap that the lines behind it make up for at that period. Where the
/// silences last more than 0.25 s, the source may have paused or lines may be missing in each block
/// alike: times are then uncertain by a silence, of which a rise exceeds a quarter. So they are
/// where blocks are drawn out, and whether their lines were collected or the source pauses
/// regularly cannot be known; it is taken to pause.
///
/// `time_ns`: one a row, nanoseconds, in the order of arrival. `nominal_rate_hz`: as the source
/// promises; used where the longest stretch is too short for a rate (fewer than 32 rows, or arrived
/// at one moment). `missing`: where rows are known to be missing, in any order; where their number
/// is known, the stretches on both sides lie on one line. `is_numbered`: the source numbers its
/// rows, so that `missing` holds every loss; only a pause of more than 0.25 s that it does not
/// explain is one more.
/// time_uncertainty_s is the scatter of the window minima about the line (one standard deviation),
/// and at least the silence between long blocks; the least delay itself cannot be seen. Returns no
/// stretch for no row. Cost: O(rows).
[[nodiscard]] std::vector<Stretch> FitArrivalTimes(std::span<const std::int64_t> time_ns,
                                                   std::optional<double> nominal_rate_hz,
                                                   std::span<const MissingRows> missing = {},
                                                   bool is_numbered = false);

/// The straight lines behind a polled sensor's times: midpoint of request and reply against row, by
/// least squares; a new stretch begins at `breaks` and after an interval longer than eight times
/// the median one. Stretches of fewer than three rows have the median interval,
/// or where that is 0 the nominal rate.
///
/// time_uncertainty_s = sqrt(s^2 + mean((reply - request)^2) / 12): scatter about the line, and the
/// reading being taken anywhere between request and reply (uniform distribution).
[[nodiscard]] std::vector<Stretch> FitPolledTimes(std::span<const std::int64_t> request_ns,
                                                  std::span<const std::int64_t> reply_ns,
                                                  std::optional<double> nominal_rate_hz,
                                                  std::span<const std::size_t> breaks = {});

/// The stretches of a clocked source: rows follow each other on a grid, and a new stretch begins
/// where places on it are missing.
class UniformGrid {
 public:
  explicit UniformGrid(double rate_hz) : rate_hz_(rate_hz) {}

  /// The next `rows` rows; the first lies at `first_index` on the grid, at first_index / rate.
  void Append(std::int64_t first_index, std::size_t rows);

  [[nodiscard]] const std::vector<Stretch>& stretches() const { return stretches_; }

 private:
  double rate_hz_;
  std::size_t rows_ = 0;
  std::int64_t next_index_ = 0;
  std::vector<Stretch> stretches_;
};

}  // namespace haptometer::trial
