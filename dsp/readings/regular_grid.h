#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/findings.h"
#include "trial/record.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// The largest error of interpolation that a row may have, as a part of a tone's amplitude.
inline constexpr double kLargestInterpolationError = 1e-3;

/// A record of readings at uneven times, put on a regular grid.
struct RegularGrid {
  trial::Record record;         ///< Timing::kUniform; times are the grid's
  double rate_hz = 0;           ///< of the grid: what the times come to on average
  double jitter_s = 0;          ///< standard deviation of the times about the grid
  double largest_jitter_s = 0;  ///< the largest distance of a time from its place on the grid
  /// The largest distance from an even grid, of a clock that drifts; jitter is then that about a
  /// grid that follows the times. 0: none is that far.
  double drift_s = 0;
  std::size_t readings = 0;  ///< that the rows are of
  std::size_t dropped = 0;   ///< places on the grid without a reading
  std::size_t points = 0;    ///< readings that each value was interpolated from
  /// What interpolation adds at most to a tone at `upper_hz`, as a part of its amplitude (less to
  /// lower ones); of the worst row that is kept.
  double error_bound = 0;
  std::size_t left_out = 0;        ///< rows whose bound would be above kLargestInterpolationError
  std::optional<Finding> refusal;  ///< why there is no grid; the record is empty then
};

/// Puts the readings of `record`, whose own times are known (Record::times_are_known) but lie on no
/// grid, on a regular one, for motion up to `upper_hz`.
///
/// Dropped readings are told from jitter first: a grid of the median period follows the readings,
/// each of which takes its nearest place; where counting them without a gap leaves less jitter,
/// none was dropped. The grid is the least-squares line through the times over those places. A row
/// is a reading; places without one end a stretch. Where times lie farther than 0.45 periods from
/// that line, but not from a grid that takes a 16th of each time's distance, their clock drifts:
/// rows are then the places of an even grid of the line's period, with a reading within a period.
///
/// A value is the polynomial through the nearest `points` measured readings at their own times,
/// taken at its place on the grid (Neville), which lies beside one of them. For a tone of angular
/// frequency w and amplitude a it is wrong by at most
///   a w^m / m! |(t - t_1) (t - t_2) ... (t - t_m)|
/// (Cauchy's remainder: Stoer and Bulirsch, Introduction to Numerical Analysis, 3rd ed., 2.1.4). m
/// is the least of 4, 8, 12, 16 whose bound is below 1e-6 for nearly all rows, or the best of them.
/// Motion above `upper_hz` has no such bound. Ignored, jitter of s would add 2 pi f s of the tone
/// as noise.
///
/// Refused: fewer than four rows; a time farther than 0.45 periods from both grids, so that dropped
/// readings and jitter cannot be told apart; the bound above kLargestInterpolationError in more
/// than half of the rows; most times equal to the one before. Programmer's error: no known times.
/// Cost: O(rows points^2).
[[nodiscard]] RegularGrid OnRegularGrid(const trial::Record& record, double upper_hz);
/// The same of a source whose head has the known times. Errors: as RowSource::Read.
[[nodiscard]] Result<RegularGrid> OnRegularGrid(const trial::RowSource& source, double upper_hz);

}  // namespace haptometer::dsp
