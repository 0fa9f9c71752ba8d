#include "dsp/analysis/band_signal.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "dsp/filter/settled.h"

namespace haptometer::dsp {
namespace {

constexpr double kCellsPerS = 1000;
constexpr std::size_t kMostCells = std::size_t{1} << 21U;

std::size_t CellSamples(std::size_t size, double rate_hz) {
  std::size_t samples = 1;
  while (2 * static_cast<double>(samples) <= rate_hz / kCellsPerS) samples *= 2;
  while (size / samples > kMostCells) samples *= 2;
  return samples;
}

BandCell CellOf(std::span<const double> samples) {
  BandCell cell{0, samples.front(), samples.front()};
  for (const double sample : samples) {
    cell.square_sum += sample * sample;
    cell.least = std::min(cell.least, sample);
    cell.most = std::max(cell.most, sample);
  }
  return cell;
}

std::vector<BandCell> CellsIn(std::span<const double> samples, std::size_t cell_samples) {
  std::vector<BandCell> cells;
  cells.reserve((samples.size() + cell_samples - 1) / cell_samples);
  while (!samples.empty()) {
    const std::size_t count = std::min(cell_samples, samples.size());
    cells.push_back(CellOf(samples.first(count)));
    samples = samples.subspan(count);
  }
  return cells;
}

}  // namespace

Result<BandSignal> BandSignal::Filter(const SegmentSamples& samples, const FilterDesign& design,
                                      int threads) {
  HAPTOMETER_CHECK(threads >= 1 && samples.size() >= 1, "{} threads, {} samples", threads,
                   samples.size());
  std::vector<double> values(samples.size());
  if (auto read = samples.Read(0, values); !read) return std::unexpected(read.error());
  SettledSignal settled = FilterSettled(design, values);
  BandSignal signal(samples, design);
  signal.settled_begin_ = settled.begin;
  signal.settled_end_ = settled.end;
  signal.filtered_ = std::move(settled.filtered);
  signal.cell_samples_ = CellSamples(samples.size(), samples.rate_hz());
  signal.cells_ = CellsIn(signal.filtered_, signal.cell_samples_);
  return signal;
}

Result<void> BandSignal::Read(std::size_t first, std::span<double> out) const {
  HAPTOMETER_CHECK(first <= size() && out.size() <= size() - first, "samples {} + {} of {}", first,
                   out.size(), size());
  std::ranges::copy(std::span(filtered_).subspan(first, out.size()), out.begin());
  return {};
}

Result<BandCell> BandSignal::CutCell(std::size_t begin, std::size_t end) const {
  std::vector<double> samples(end - begin);
  if (auto read = Read(begin, samples); !read) return std::unexpected(read.error());
  return CellOf(samples);
}

Result<std::vector<BandCell>> BandSignal::CellsOf(std::size_t begin, std::size_t end) const {
  HAPTOMETER_CHECK(begin <= end && end <= size(), "samples {} to {} of {}", begin, end, size());
  std::vector<BandCell> found;
  found.reserve((end - begin) / cell_samples_ + 2);
  for (std::size_t at = begin; at < end;) {
    const std::size_t k = at / cell_samples_;
    const std::size_t cell_end = std::min((k + 1) * cell_samples_, size());
    const std::size_t stop = std::min(cell_end, end);
    if (at == k * cell_samples_ && stop == cell_end) {
      found.push_back(cells_[k]);
    } else {
      const auto cut = CutCell(at, stop);
      if (!cut) return std::unexpected(cut.error());
      found.push_back(*cut);
    }
    at = stop;
  }
  return found;
}

Result<double> BandSignal::SquareSum(std::size_t begin, std::size_t end) const {
  const auto found = CellsOf(begin, end);
  if (!found) return std::unexpected(found.error());
  double sum = 0;
  double lost = 0;  // what rounding took from it; no term is negative
  for (const BandCell& cell : *found) {
    const double term = cell.square_sum;
    const double next = sum + term;
    lost += sum >= term ? (sum - next) + term : (term - next) + sum;
    sum = next;
  }
  return sum + lost;
}

Result<Extremes> BandSignal::ExtremesOf(std::size_t begin, std::size_t end) const {
  HAPTOMETER_CHECK(begin < end, "samples {} to {}", begin, end);
  const auto found = CellsOf(begin, end);
  if (!found) return std::unexpected(found.error());
  Extremes extremes{found->front().least, found->front().most};
  for (const BandCell& cell : *found) {
    extremes.least = std::min(extremes.least, cell.least);
    extremes.most = std::max(extremes.most, cell.most);
  }
  return extremes;
}

}  // namespace haptometer::dsp
