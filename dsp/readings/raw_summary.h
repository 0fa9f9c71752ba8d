#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "dsp/readings/row_block.h"
#include "dsp/readings/row_kernel.h"
#include "trial/record.h"

namespace haptometer::dsp {

/// What the readings of a channel say without any filter.
struct RawSummary {
  std::size_t measured = 0;  ///< rows with a measurement; 0: the next three are NaN
  double mean = std::numeric_limits<double>::quiet_NaN();
  double least = std::numeric_limits<double>::quiet_NaN();
  double most = std::numeric_limits<double>::quiet_NaN();
  /// Cell k holds rows [k cell_rows, (k + 1) cell_rows), the last one what is left.
  std::size_t cell_rows = 1;
  std::vector<double> cell_means;  ///< of the measured rows; NaN where there is none
};

/// Sums up a channel block by block, for a pass that somebody else makes (RowVisitor).
///
/// Cells are 4 ms long (drift and tremor, up to 20 Hz, lie far below 250 cells a second) or as long
/// as it takes for at most 2^20 of them. Sums are of deviations from a cell's first measurement,
/// eight running ones by the row's place in it, compensated over cells (Neumaier, ZAMM 54, 1974):
/// how the rows were cut into blocks changes no bit. Memory: 8 B a cell.
class RawSummarizer {
 public:
  /// The cells that lie in a block as a whole, in order; cells of rows that are not all measured
  /// have no finite sum.
  using Look = std::vector<RowSum>;

  /// For the rows that `head` says are there.
  explicit RawSummarizer(const trial::Record& head);

  /// A look at a block; blocks in any order, on any threads.
  [[nodiscard]] Look LookAt(const RowBlock& block) const;

  /// The next rows, in order, without a gap, with the look at them.
  void Feed(const RowBlock& block, const Look& look);

  /// After the last row.
  [[nodiscard]] RawSummary Finish();

 private:
  void FeedRow(double value, trial::SampleStatus status);
  void FeedCell(double first, const RowSum& sum);
  // counts `measured` rows whose deviations from `first` add up to `sum`
  void AddCell(double first, double sum, std::size_t measured);
  void CloseCell();

  RawSummary summary_;
  std::size_t fed_ = 0;               // rows
  double reference_ = 0;              // the first measurement
  double sum_ = 0;                    // of deviations from it in closed cells
  double lost_ = 0;                   // what rounding took from it
  double cell_first_ = 0;             // the open cell's first measurement
  double cell_sums_[kRowLanes] = {};  // of deviations from it, row n in lane n mod kRowLanes
  std::size_t cell_count_ = 0;        // measurements in it
  std::size_t cell_filled_ = 0;       // rows in it
};

}  // namespace haptometer::dsp
