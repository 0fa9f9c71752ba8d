#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

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
/// as it takes for at most 2^20 of them. Sums are of deviations from the first measurement, four
/// running ones in a cell by the row's place in it, compensated over cells (Neumaier, ZAMM 54,
/// 1974): how the rows were cut into blocks changes no bit. Memory: 8 B a cell.
class RawSummarizer {
 public:
  /// For the rows that `head` says are there.
  explicit RawSummarizer(const trial::Record& head);

  /// The next rows, in order, without a gap.
  void Feed(std::span<const double> values, std::span<const trial::SampleStatus> statuses);

  /// After the last row.
  [[nodiscard]] RawSummary Finish();

 private:
  // adds rows of the open cell
  void FeedCell(std::span<const double> values, std::span<const trial::SampleStatus> statuses);
  void FeedRow(double value, trial::SampleStatus status);
  // adds whole lanes of measured rows; false, and nothing added, where a value is none after all
  [[nodiscard]] bool FeedLanes(std::span<const double> values);
  void CloseCell();

  static constexpr std::size_t kLanes = 4;
  using Lanes = std::array<double, kLanes>;

  RawSummary summary_;
  double reference_ = 0;         // the first measurement
  double sum_ = 0;               // of deviations in closed cells
  double lost_ = 0;              // what rounding took from it
  Lanes cell_sums_{};            // of deviations in the open cell, row n in lane n mod kLanes
  std::size_t cell_count_ = 0;   // measurements in it
  std::size_t cell_filled_ = 0;  // rows in it
};

}  // namespace haptometer::dsp
