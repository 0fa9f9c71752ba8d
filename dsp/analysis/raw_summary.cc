#include "dsp/analysis/raw_summary.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "dsp/analysis/measured.h"

namespace haptometer::dsp {
namespace {

constexpr double kCellsPerS = 250;
constexpr std::size_t kMostCells = std::size_t{1} << 20U;

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
    if (cell_filled_ == summary_.cell_rows) CloseCell();
    values = values.subspan(count);
    statuses = statuses.subspan(count);
  }
}

void RawSummarizer::FeedCell(std::span<const double> values,
                             std::span<const trial::SampleStatus> statuses) {
  std::size_t k = 0;
  const auto feed_rows = [&](std::size_t end) {
    for (; k < end; ++k) FeedRow(values[k], statuses[k]);
  };
  // the first of all rows gives the reference
  const bool is_first = summary_.measured == 0 && cell_count_ == 0;
  if (!is_first && AllOk(statuses)) {
    feed_rows(std::min(values.size(), (kLanes - cell_filled_ % kLanes) % kLanes));
    const auto lanes = values.subspan(k, (values.size() - k) / kLanes * kLanes);
    if (FeedLanes(lanes)) k += lanes.size();
  }
  feed_rows(values.size());
}

void RawSummarizer::FeedRow(double value, trial::SampleStatus status) {
  const std::size_t lane = cell_filled_++ % kLanes;
  if (!IsMeasured(value, status)) return;
  if (summary_.measured == 0 && cell_count_ == 0) {
    reference_ = summary_.least = summary_.most = value;
  }
  cell_sums_[lane] += value - reference_;
  summary_.least = std::min(summary_.least, value);
  summary_.most = std::max(summary_.most, value);
  ++cell_count_;
}

bool RawSummarizer::FeedLanes(std::span<const double> values) {
  Lanes sums = cell_sums_;
  Lanes least;
  Lanes most;
  least.fill(summary_.least);
  most.fill(summary_.most);
  const double reference = reference_;
  for (std::size_t k = 0; k < values.size(); k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double value = values[k + lane];
      sums[lane] += value - reference;
      least[lane] = value < least[lane] ? value : least[lane];
      most[lane] = value > most[lane] ? value : most[lane];
    }
  }
  // a value that is infinite or none makes its sum so
  if (!AllFinite(sums)) return false;
  cell_sums_ = sums;
  summary_.least = std::ranges::min(least);
  summary_.most = std::ranges::max(most);
  cell_count_ += values.size();
  cell_filled_ += values.size();
  return true;
}

void RawSummarizer::CloseCell() {
  const double cell_sum = (cell_sums_[0] + cell_sums_[1]) + (cell_sums_[2] + cell_sums_[3]);
  const double mean = cell_count_ > 0 ? reference_ + cell_sum / static_cast<double>(cell_count_)
                                      : std::numeric_limits<double>::quiet_NaN();
  summary_.cell_means.push_back(mean);
  const double sum = sum_ + cell_sum;
  lost_ += std::abs(sum_) >= std::abs(cell_sum) ? (sum_ - sum) + cell_sum : (cell_sum - sum) + sum_;
  sum_ = sum;
  summary_.measured += cell_count_;
  cell_sums_ = {};
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
