#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "dsp/filter/transient.h"
#include "dsp/filter/zero_phase.h"
#include "dsp/readings/segments.h"
#include "dsp/spectrum/below_band_model.h"

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

/// Which filtered samples of a long segment stay in memory: of every `stride`-th one, counted from
/// the segment's first, `frame` in each `period`, from the `offset`-th on.
struct KeptFrames {
  std::size_t stride = 1;
  std::size_t period = 0;
  std::size_t offset = 0;
  std::size_t frame = 0;  ///< 0: none; period: all
};

/// One segment, filtered forward and backward, readable by range whatever its length.
///
/// Only the cells stay in memory (24 B each), 384 B for each 32 256 samples, and the frames that
/// are asked for; other samples are filtered again when they are read, but those of a segment of
/// 2^18 at most (2 MB) are kept. They are counted from the segment's first. Every number depends on
/// the samples alone: not on the ranges that are asked for, nor on the number of threads. Threads
/// may read at the same time.
class BandSignal {
 public:
  /// Filters with zero phase, `threads` >= 1 blocks at a time (dsp/filter/zero_phase.h), and
  /// finds what has settled. What `samples` refers to must outlive the signal.
  ///
  /// Settled cells are found as settled samples are (SettledRange), by what each depends on the
  /// ends at most.
  /// Motion below the band, if `model` (the segment's) is given, is taken from the samples before
  /// the filter, and what a filter makes of it for ever is added behind it.
  /// Errors: as SegmentSamples::Read. Memory: the blocks at hand, then the cells and `frames`.
  [[nodiscard]] static Result<BandSignal> Filter(const SegmentSamples& samples,
                                                 const FilterDesign& design, int threads,
                                                 const KeptFrames& frames = {},
                                                 std::optional<BelowBandModel> model = {});

  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  [[nodiscard]] double rate_hz() const { return samples_.rate_hz(); }
  [[nodiscard]] std::size_t first_row() const { return samples_.segment().first_row; }
  [[nodiscard]] double start_s() const { return samples_.segment().start_s; }
  [[nodiscard]] const Segment& segment() const { return samples_.segment(); }
  [[nodiscard]] const SegmentSamples& samples() const { return samples_; }
  [[nodiscard]] const FilterDesign& design() const { return design_; }
  /// What was taken from the samples.
  [[nodiscard]] const std::optional<BelowBandModel>& model() const { return model_; }

  /// Samples [settled_begin, settled_end) do not depend on what lay beyond the segment's ends;
  /// whole cells.
  [[nodiscard]] std::size_t settled_begin() const { return settled_begin_; }
  [[nodiscard]] std::size_t settled_end() const { return settled_end_; }

  /// Cell k sums up samples [k n, (k + 1) n), n = cell_samples(), the last one what is left.
  ///
  /// n is the greatest divisor of kTileSamples that lasts 1 ms at most, or the least one that gives
  /// at most 2^20 cells.
  [[nodiscard]] std::span<const BandCell> cells() const { return cells_; }
  [[nodiscard]] std::size_t cell_samples() const { return cell_samples_; }

  /// Filtered samples [first, first + out.size()), within size().
  /// Errors: as SegmentSamples::Read. Cost: every piece of 32 256 samples that the range touches is
  /// filtered.
  [[nodiscard]] Result<void> Read(std::size_t first, std::span<double> out) const;

  /// Whether every filtered sample is in memory.
  [[nodiscard]] bool is_kept() const { return !kept_.empty(); }

  /// Every `stride`-th filtered sample from `first` on, the last one within size().
  /// Errors, cost: as Read; without filtering where they are in a frame that was kept.
  [[nodiscard]] Result<void> ReadThinned(std::size_t first, std::size_t stride,
                                         std::span<double> out) const;

  /// Sum of the squares of samples [begin, end): whole cells, and the cut ones at the two ends
  /// sample by sample; compensated (Neumaier). Errors: as SegmentSamples::Read.
  [[nodiscard]] Result<double> SquareSum(std::size_t begin, std::size_t end) const;

  /// Of samples [begin, end), at least one. Errors: as SegmentSamples::Read.
  [[nodiscard]] Result<Extremes> ExtremesOf(std::size_t begin, std::size_t end) const;

 private:
  BandSignal(const SegmentSamples& samples, const FilterDesign& design,
             std::optional<BelowBandModel> model, const KeptFrames& frames);

  // what the segment's samples are asked for by
  [[nodiscard]] ReadSamples reading() const;
  [[nodiscard]] Result<void> FilterAll(int threads);
  [[nodiscard]] Result<void> FilterBlock(std::size_t block, ZeroPhaseBlocks::Scratch& scratch);
  void TakeCells(std::size_t first, std::span<const double> samples);
  void TakeFrames(std::size_t first, std::span<const double> samples);
  [[nodiscard]] std::span<const double> InFrames(std::size_t first, std::size_t stride,
                                                 std::size_t count) const;
  void FindSettled(const EndDependence& dependence);

  // what a range falls into: whole cells and the samples of the cut ones at its ends
  struct CutRange {
    std::vector<BandCell> cut;  // at most two
    std::span<const BandCell> whole;
  };
  [[nodiscard]] Result<CutRange> Cut(std::size_t begin, std::size_t end) const;
  [[nodiscard]] Result<BandCell> CutCell(std::size_t begin, std::size_t end) const;

  SegmentSamples samples_;
  FilterDesign design_;
  std::optional<BelowBandModel> model_;
  ZeroPhaseBlocks blocks_;
  std::size_t settled_begin_ = 0;
  std::size_t settled_end_ = 0;
  std::size_t cell_samples_ = 1;
  std::vector<BandCell> cells_;
  std::vector<double> kept_;  // all filtered samples of a short segment, or none
  KeptFrames frames_;
  std::vector<double> in_frames_;                     // one frame after the other
  std::vector<ZeroPhaseBlocks::PieceStates> states_;  // from which each piece can be read again
};

/// RMS of every sample of all `signals` (one at least), unsettled ends and pauses included.
[[nodiscard]] double WholeRms(std::span<const BandSignal> signals);

}  // namespace haptometer::dsp
