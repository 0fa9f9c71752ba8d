#pragma once

#include <complex>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "dsp/analysis/time_window.h"
#include "dsp/findings.h"

namespace haptometer::dsp {

/// Mean squares over cells that follow each other: of the band-passed displacement, or of a drive.
struct PowerCourse {
  std::span<const double> mean_square;  ///< (cells); >= 0
  double start_s = 0;                   ///< of the first cell
  double cell_s = 0;                    ///< length of a cell, > 0
};

/// How a course is read.
struct DriveSearch {
  double lower_hz = 20;       ///< lower corner of the band: a block of time is one period of it
  double bandwidth_hz = 480;  ///< of the noise: 2 x bandwidth x time values are independent
};

/// How the power goes over a record.
enum class DriveCourse : std::uint8_t {
  kUnchanging,  ///< one level: the drive is on throughout, or never
  kGated,       ///< at least one part stands out from a quiet one
};

/// A part in which the power stands out.
struct OnPart {
  TimeWindow whole;        ///< from the first to the last block above the threshold
  TimeWindow steady;       ///< without onset and decay; empty where nothing is steady
  double mean_square = 0;  ///< over `steady`
  double drift = 0;        ///< relative change of the amplitude over `steady`, first to last third
  /// Power in the middle third of `whole` over that in the outer two: 1 for a drive, far above for
  /// the ringing of a filter that was struck; 1 below three blocks.
  double bulge = 1;
  bool is_steady = false;  ///< |drift| below 5 %, or not told from the noise
};

/// What FindDriveParts decided, and why.
struct DriveParts {
  DriveCourse course = DriveCourse::kUnchanging;
  std::vector<OnPart> on;         ///< in order of time; empty where the course is unchanging
  std::vector<TimeWindow> quiet;  ///< away from every on-part; the lowest level only
  std::optional<Finding> why;     ///< the course; nothing where it was not looked at

  /// The on-part whose steady part is longest; nullptr where there is none.
  [[nodiscard]] const OnPart* Longest() const;
};

/// Splits a record into drive-on and quiet parts by its power over time.
///
/// Blocks of one period of the lower corner (at most 2048 blocks) are split where the likelihood of
/// gamma-distributed powers gains most: the sum of n (nu/2) ln(mean), nu = 2 bandwidth x block,
/// plus a penalty of 6 + 3 ln(blocks) a change is least (optimal partitioning: Jackson et al., IEEE
/// Signal Processing Letters 12(2), 2005, p. 105). The quiet level is the lowest that lasts two
/// blocks, the top level the highest that lasts four; a top below 1.3 times quiet (in power) is no
/// drive. Above their geometric mean for two blocks or more is on; shorter is a bump. An on-part
/// loses a block at each end, then blocks that lie off its median by more than four deviations
/// (by the median absolute deviation) and 1 % of the power. Quiet parts stay two and a half blocks
/// away from what is on, because the filter rings there.
///
/// A drive whose level changes slowly looks gated here: whether the tone is gone from the quiet
/// part is for the caller to check. Cost: blocks^2 / 2 logarithms, 20 ms at most; two vectors.
[[nodiscard]] DriveParts FindDriveParts(const PowerCourse& course, const DriveSearch& search);

/// The same parts from a drive channel (voltage, current or trigger): on and off are where
/// `drive` says, steady by `response`, the displacement's own power; both on one time base.
[[nodiscard]] DriveParts FindDriveParts(const PowerCourse& drive, const PowerCourse& response,
                                        const DriveSearch& search);

/// Length of the blocks that `course` is split into: whole cells.
[[nodiscard]] double DriveBlockSeconds(const PowerCourse& course, const DriveSearch& search);

/// The same parts from a tone's complex amplitude in each block (DriveBlockSeconds; as many as
/// whole blocks in `response`, which tells what is steady): a tone far below the noise in power is
/// seen this way.
///
/// Amplitudes have Gaussian noise of one variance v (by the median change of neighbours); the sum
/// of |c - mean|^2 / (2 v) and the same penalty is least. Below 0.3 of the top amplitude the tone
/// pauses, above half of it the drive is on. The top is a level that noise alone gives with e^-15.
[[nodiscard]] DriveParts FindDriveParts(std::span<const std::complex<double>> tone,
                                        const PowerCourse& response, const DriveSearch& search);

}  // namespace haptometer::dsp
