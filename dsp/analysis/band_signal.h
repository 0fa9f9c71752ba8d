#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/result.h"
#include "dsp/analysis/segments.h"
#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// What a run of filtered samples comes to.
struct BandCell {
  double square_sum = 0;
  double least = 0;
  double most = 0;
};

/// The least and the greatest sample of a range.
struct Extremes {
  double least = 0;
  double most = 0;
};

/// One segment, filtered forward and backward, readable by range whatever its length.
///
/// Samples are counted from the segment's first. Every number depends on the samples alone: not on
/// the ranges that are asked for, nor on the number of threads. Threads may read at the same time.
class BandSignal {
 public:
  /// Filters with zero phase (dsp/filter/zero_phase.h) and finds what has settled
  /// (dsp/filter/settled.h). What `samples` refers to must outlive the signal. `threads` >= 1.
  /// Errors: as SegmentSamples::Read.
  [[nodiscard]] static Result<BandSignal> Filter(const SegmentSamples& samples,
                                                 const FilterDesign& design, int threads);

  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  [[nodiscard]] double rate_hz() const { return samples_.rate_hz(); }
  [[nodiscard]] std::size_t first_row() const { return samples_.segment().first_row; }
  [[nodiscard]] double start_s() const { return samples_.segment().start_s; }
  [[nodiscard]] const Segment& segment() const { return samples_.segment(); }
  [[nodiscard]] const SegmentSamples& samples() const { return samples_; }
  [[nodiscard]] const FilterDesign& design() const { return design_; }

  /// Samples [settled_begin, settled_end) do not depend on what lay beyond the segment's ends.
  [[nodiscard]] std::size_t settled_begin() const { return settled_begin_; }
  [[nodiscard]] std::size_t settled_end() const { return settled_end_; }

  /// Cell k sums up samples [k n, (k + 1) n), n = cell_samples(), the last one what is left.
  ///
  /// n is a power of two: 0.5 to 1 ms, or more where that would be over 2^21 cells.
  [[nodiscard]] std::span<const BandCell> cells() const { return cells_; }
  [[nodiscard]] std::size_t cell_samples() const { return cell_samples_; }

  /// Filtered samples [first, first + out.size()), within size(). Errors: as SegmentSamples::Read.
  [[nodiscard]] Result<void> Read(std::size_t first, std::span<double> out) const;

  /// Sum of the squares of samples [begin, end): whole cells, and the cut ones at the two ends
  /// sample by sample; compensated (Neumaier). Errors: as SegmentSamples::Read.
  [[nodiscard]] Result<double> SquareSum(std::size_t begin, std::size_t end) const;

  /// Of samples [begin, end), at least one. Errors: as SegmentSamples::Read.
  [[nodiscard]] Result<Extremes> ExtremesOf(std::size_t begin, std::size_t end) const;

 private:
  BandSignal(const SegmentSamples& samples, const FilterDesign& design)
      : samples_(samples), design_(design) {}

  // the cells that make up [begin, end), cut ones worked out anew
  [[nodiscard]] Result<std::vector<BandCell>> CellsOf(std::size_t begin, std::size_t end) const;
  [[nodiscard]] Result<BandCell> CutCell(std::size_t begin, std::size_t end) const;

  SegmentSamples samples_;
  FilterDesign design_;
  std::size_t settled_begin_ = 0;
  std::size_t settled_end_ = 0;
  std::size_t cell_samples_ = 1;
  std::vector<BandCell> cells_;
  std::vector<double> filtered_;
};

}  // namespace haptometer::dsp
