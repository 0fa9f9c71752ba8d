#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/readings/row_block.h"
#include "trial/record.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// A sample that was interpolated.
struct Bridge {
  std::size_t sample = 0;  ///< counted from the segment's first
  double value = 0;
  double error_square = 0;    ///< as Interpolated states them
  double covariance_sum = 0;  ///< of the errors of the samples interpolated with it
};

/// Rows that can be filtered as one: measured at one rate, short holes interpolated.
struct Segment {
  std::size_t first_row = 0;
  std::size_t size = 0;  ///< rows
  double start_s = 0;
  double rate_hz = 0;
  double time_uncertainty_s = 0;  ///< of the stretch it comes from
  std::vector<Bridge> bridges;    ///< in the order of samples
};

/// How a channel falls into segments.
struct Segments {
  std::vector<Segment> parts;  ///< in order of time
  std::size_t bridged = 0;     ///< interpolated samples in all parts
  std::size_t measured = 0;    ///< rows that hold a measurement
  std::array<std::size_t, trial::kSampleStatusCount> by_status{};  ///< rows of each status
};

/// The longest hole that is interpolated, where 256 rows (four times the model's order) are not
/// less: about what a tone of 225 Hz with noise of 10 % is known over to 10 %.
inline constexpr double kLongestHoleS = 0.02;

/// The same in rows, one at least.
[[nodiscard]] std::size_t LongestHole(double rate_hz);

/// The segments of channel number `channel`, and their interpolated samples: it ends where a
/// stretch ends and at every hole that may not be interpolated. `holes`: all rows without a
/// measurement, in order.
///
/// A hole of at most LongestHole rows with a measurement on either side is interpolated
/// (dsp/readings/interpolation.h) from what lies within kInterpolationReach of it, where the
/// expected square of its error is below twice the variance there; holes closer to each other than
/// that share a model. Counts of rows are left to the caller.
/// Errors: as RowSource::Read. Cost: linear in the number of holes; rows near none are not read.
[[nodiscard]] Result<Segments> SplitAtHoles(const trial::RowSource& source, std::size_t channel,
                                            std::span<const RowRange> holes);

/// The samples of a segment by range, the interpolated ones in their places.
///
/// `source` and `segment` must outlive it. Threads may read at the same time.
class SegmentSamples {
 public:
  SegmentSamples(const trial::RowSource& source, std::size_t channel, const Segment& segment)
      : source_(&source), channel_(channel), segment_(&segment) {}

  [[nodiscard]] std::size_t size() const { return segment_->size; }
  [[nodiscard]] double rate_hz() const { return segment_->rate_hz; }
  [[nodiscard]] const Segment& segment() const { return *segment_; }

  /// Samples [first, first + out.size()), within size(). Errors: as RowSource::Read.
  [[nodiscard]] Result<void> Read(std::size_t first, std::span<double> out) const;
  /// The same with NaN in place of the interpolated samples.
  [[nodiscard]] Result<void> ReadMeasured(std::size_t first, std::span<double> out) const;

  /// The interpolated ones of samples [first, first + size).
  [[nodiscard]] std::span<const Bridge> BridgesWithin(std::size_t first, std::size_t size) const;

 private:
  const trial::RowSource* source_;
  std::size_t channel_;
  const Segment* segment_;
};

}  // namespace haptometer::dsp
