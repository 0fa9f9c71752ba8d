#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "trial/record.h"

namespace haptometer::dsp {

/// Rows that can be filtered as one: measured at one rate without a gap, small holes bridged.
struct Segment {
  std::size_t first_row = 0;
  double start_s = 0;
  double rate_hz = 0;
  double time_uncertainty_s = 0;  ///< of the stretch it comes from
  std::vector<double> values;     ///< one a row; no NaN
  std::size_t bridged = 0;        ///< how many of them are interpolated
  /// Sum over the bridged samples of the squared error that the same bridging makes at measured
  /// samples beside the hole.
  double bridged_error_square_sum = 0;
};

/// How a channel falls into segments.
struct Segments {
  std::vector<Segment> parts;  ///< in order of time
  std::size_t bridged = 0;     ///< interpolated samples in all parts
  std::size_t measured = 0;    ///< rows that hold a measurement
  std::array<std::size_t, trial::kSampleStatusCount> by_status{};  ///< rows of each status
};

inline constexpr std::size_t kLongestBridge = 3;

/// Splits `channel` of `record` where a stretch ends and at every hole that may not be bridged.
///
/// A row holds no measurement when its status says so (trial::IsMeasurement) or its value is not
/// finite. Holes of at most kLongestBridge rows are bridged by the cubic through the two measured
/// samples on each side, where the rate is at least 5 times `upper_hz` and those samples exist; the
/// error is measured by bridging known samples beside the hole in the same way, which needs six to
/// eight measured rows in a line on one side.
[[nodiscard]] Segments SplitIntoSegments(const trial::Record& record, const trial::Channel& channel,
                                         double upper_hz);

}  // namespace haptometer::dsp
