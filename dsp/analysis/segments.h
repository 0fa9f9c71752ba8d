#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "base/error.h"
#include "base/jobs.h"
#include "dsp/analysis/row_block.h"
#include "trial/record.h"
#include "trial/row_source.h"

namespace haptometer::dsp {

/// A sample that was interpolated.
struct Bridge {
  std::size_t sample = 0;  ///< counted from the segment's first
  double value = 0;
};

/// Rows that can be filtered as one: measured at one rate without a gap, small holes bridged.
struct Segment {
  std::size_t first_row = 0;
  std::size_t size = 0;  ///< rows
  double start_s = 0;
  double rate_hz = 0;
  double time_uncertainty_s = 0;  ///< of the stretch it comes from
  std::vector<Bridge> bridges;    ///< in the order of samples
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

/// Rows of a channel that are looked at in one go: a multiple of kFaultBlockRows.
inline constexpr std::size_t kPassRows = std::size_t{1} << 16U;

/// Sees a block of a channel, on any thread; what it returns is called block by block, in order.
using RowVisitor = std::function<Finish(const RowBlock& block)>;

/// Splits channel number `channel` where a stretch ends and at every hole that may not be bridged;
/// `visit`, where given, sees every row on the way.
///
/// A row holds no measurement when its status says so (trial::IsMeasurement) or its value is not
/// finite. Holes of at most kLongestBridge rows are bridged by the cubic through the two measured
/// samples on each side, where the rate is at least 5 times `upper_hz` and those samples exist; the
/// error is measured by bridging known samples beside the hole in the same way, which needs six to
/// eight measured rows in a line on one side.
/// `threads` blocks are read and looked at at a time; they change nothing.
/// Errors: as RowSource::Read. Cost: one pass; memory of a block a thread and of what is returned.
[[nodiscard]] Result<Segments> SplitIntoSegments(const trial::RowSource& source,
                                                 std::size_t channel, double upper_hz,
                                                 const RowVisitor& visit = {}, int threads = 1);

/// The samples of a segment by range, the bridged ones in their places.
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

 private:
  const trial::RowSource* source_;
  std::size_t channel_;
  const Segment* segment_;
};

}  // namespace haptometer::dsp
