#include "dsp/analysis/raw_summary.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"

namespace haptometer::dsp {
namespace {

constexpr double kCellsPerS = 250;
constexpr std::size_t kMostCells = std::size_t{1} << 21U;

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

void RawSummarizer::Feed(std::span<const double> values,
                         std::span<const trial::SampleStatus> statuses) {
  HAPTOMETER_CHECK(values.size() == statuses.size(), "{} values, {} statuses", values.size(),
                   statuses.size());
  while (!values.empty()) {
    const std::size_t count = std::min(values.size(), summary_.cell_rows - cell_filled_);
    FeedCell(values.first(count), statuses.first(count));
    cell_filled_ += count;
    if (cell_filled_ == summary_.cell_rows) CloseCell();
    values = values.subspan(count);
    statuses = statuses.subspan(count);
  }
}

void RawSummarizer::FeedCell(std::span<const double> values,
                             std::span<const trial::SampleStatus> statuses) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double value = values[k];
    if (!trial::IsMeasurement(statuses[k]) || !std::isfinite(value)) continue;
    if (summary_.measured == 0 && cell_count_ == 0) {
      reference_ = summary_.least = summary_.most = value;
    }
    cell_sum_ += value - reference_;
    summary_.least = std::min(summary_.least, value);
    summary_.most = std::max(summary_.most, value);
    ++cell_count_;
  }
}

void RawSummarizer::CloseCell() {
  const double mean = cell_count_ > 0 ? reference_ + cell_sum_ / static_cast<double>(cell_count_)
                                      : std::numeric_limits<double>::quiet_NaN();
  summary_.cell_means.push_back(mean);
  const double sum = sum_ + cell_sum_;
  lost_ +=
      std::abs(sum_) >= std::abs(cell_sum_) ? (sum_ - sum) + cell_sum_ : (cell_sum_ - sum) + sum_;
  sum_ = sum;
  summary_.measured += cell_count_;
  cell_sum_ = 0;
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
