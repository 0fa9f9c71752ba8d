#include "dsp/readings/raw_summary.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "dsp/readings/row_block.h"

namespace haptometer::dsp {
namespace {

constexpr double kCellsPerS = 250;
constexpr std::size_t kMostCells = std::size_t{1} << 20U;

// rows of a cell, from the highest rate in the record
std::size_t CellRows(const trial::Record& head) {
  double rate_hz = 0;
  for (const trial::Stretch& stretch : head.stretches) rate_hz = std::max(rate_hz, stretch.rate_hz);
  const double rows = std::min(rate_hz / kCellsPerS, static_cast<double>(head.rows));
  const std::size_t fewest = (head.rows + kMostCells - 1) / kMostCells;
  return std::max({std::size_t{1}, fewest, static_cast<std::size_t>(rows)});
}

}  // namespace

RawSummarizer::RawSummarizer(const trial::Record& head) {
  summary_.cell_rows = CellRows(head);
  summary_.cell_means.reserve((head.rows + summary_.cell_rows - 1) / summary_.cell_rows);
}

RawSummarizer::Look RawSummarizer::LookAt(const RowBlock& block) const {
  const std::size_t cell = summary_.cell_rows;
  Look look;
  look.reserve(block.rows() / cell + 1);
  std::size_t row = (block.first_row + cell - 1) / cell * cell;
  for (; row + cell <= block.end_row; row += cell) {
    const double* rows = block.held_values.data() + (row - block.held_first);
    look.push_back(block.AllOkWithin(row, row + cell)
                       ? WidestRowKernel().sum_from(rows, cell, rows[0])
                       : RowSum{.sum = std::numeric_limits<double>::quiet_NaN()});
  }
  return look;
}

// cells that are measured as a whole are added at once, all other rows one by one
void RawSummarizer::Feed(const RowBlock& block, const Look& look) {
  HAPTOMETER_CHECK(block.first_row == fed_, "row {} after {}", block.first_row, fed_);
  const std::size_t cell = summary_.cell_rows;
  const auto values = block.values();
  const auto statuses = block.statuses();
  std::size_t cells = 0;
  for (std::size_t k = 0; k < values.size();) {
    if (cell_filled_ == 0 && cells < look.size()) {
      const RowSum& sum = look[cells++];
      if (std::isfinite(sum.sum)) {
        FeedCell(values[k], sum);
        k += cell;
        continue;
      }
    }
    FeedRow(values[k], statuses[k]);
    ++k;
  }
  fed_ = block.end_row;
}

void RawSummarizer::FeedCell(double first, const RowSum& sum) {
  if (summary_.measured == 0) reference_ = summary_.least = summary_.most = first;
  summary_.least = std::min(summary_.least, sum.least);
  summary_.most = std::max(summary_.most, sum.most);
  AddCell(first, sum.sum, summary_.cell_rows);
}

// lane by lane, so that a cell fed row by row has the same bytes as one fed at once
void RawSummarizer::FeedRow(double value, trial::SampleStatus status) {
  const std::size_t lane = cell_filled_ % kRowLanes;
  if (IsMeasured(value, status)) {
    if (cell_count_ == 0) cell_first_ = value;
    if (summary_.measured == 0 && cell_count_ == 0) {
      reference_ = summary_.least = summary_.most = value;
    }
    cell_sums_[lane] += value - cell_first_;
    summary_.least = std::min(summary_.least, value);
    summary_.most = std::max(summary_.most, value);
    ++cell_count_;
  }
  if (++cell_filled_ == summary_.cell_rows) CloseCell();
}

void RawSummarizer::AddCell(double first, double sum, std::size_t measured) {
  const auto count = static_cast<double>(measured);
  summary_.cell_means.push_back(measured > 0 ? first + sum / count
                                             : std::numeric_limits<double>::quiet_NaN());
  if (measured == 0) return;
  // deviations from the first reading of the record, by Neumaier's compensated sum
  const double term = (first - reference_) * count + sum;
  const double next = sum_ + term;
  lost_ += std::abs(sum_) >= std::abs(term) ? (sum_ - next) + term : (term - next) + sum_;
  sum_ = next;
  summary_.measured += measured;
}

void RawSummarizer::CloseCell() {
  AddCell(cell_first_, SumOfLanes(cell_sums_), cell_count_);
  std::ranges::fill(cell_sums_, 0.0);
  cell_count_ = cell_filled_ = 0;
}

RawSummary RawSummarizer::Finish() {
  if (cell_filled_ > 0) CloseCell();
  if (summary_.measured > 0) {
    summary_.mean = reference_ + (sum_ + lost_) / static_cast<double>(summary_.measured);
  }
  return std::move(summary_);
}

}  // namespace haptometer::dsp
