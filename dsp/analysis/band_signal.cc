#include "dsp/analysis/band_signal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/check.h"
#include "base/jobs.h"
#include "dsp/filter/settled.h"

namespace haptometer::dsp {
namespace {

constexpr double kLongestCellS = 1e-3;
constexpr std::size_t kMostCells = std::size_t{1} << 20U;

// a divisor of kTileSamples, so that no cell lies in two blocks
std::size_t CellSamples(std::size_t size, double rate_hz) {
  std::size_t samples = 1;
  for (std::size_t next = 2; next <= kTileSamples; ++next) {
    const bool is_short = static_cast<double>(next) <= kLongestCellS * rate_hz;
    if (kTileSamples % next == 0 && (is_short || size / samples > kMostCells)) samples = next;
  }
  return samples;
}

// four running sums, so that no step waits for the one before it
BandCell CellOf(std::span<const double> samples) {
  constexpr std::size_t kLanes = 4;
  std::array<BandCell, kLanes> lanes;
  lanes.fill({0, samples.front(), samples.front()});
  const auto take = [](BandCell& cell, double sample) {
    cell.square_sum += sample * sample;
    cell.least = sample < cell.least ? sample : cell.least;
    cell.most = sample > cell.most ? sample : cell.most;
  };
  std::size_t k = 0;
  for (; k + kLanes <= samples.size(); k += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) take(lanes[lane], samples[k + lane]);
  }
  for (; k < samples.size(); ++k) take(lanes[k % kLanes], samples[k]);
  BandCell cell = lanes[0];
  cell.square_sum =
      (lanes[0].square_sum + lanes[1].square_sum) + (lanes[2].square_sum + lanes[3].square_sum);
  for (const BandCell& lane : lanes) {
    cell.least = std::min(cell.least, lane.least);
    cell.most = std::max(cell.most, lane.most);
  }
  return cell;
}

// Neumaier's compensated sum of terms that are not negative (ZAMM 54, 1974)
double SquareSumOf(std::span<const BandCell> cells) {
  double sum = 0;
  double lost = 0;
  for (const BandCell& cell : cells) {
    const double term = cell.square_sum;
    const double next = sum + term;
    lost += sum >= term ? (sum - next) + term : (term - next) + sum;
    sum = next;
  }
  return sum + lost;
}

}  // namespace

BandSignal::BandSignal(const SegmentSamples& samples, const FilterDesign& design)
    : samples_(samples),
      design_(design),
      blocks_(design, samples.size()),
      cell_samples_(CellSamples(samples.size(), samples.rate_hz())),
      cells_((samples.size() + cell_samples_ - 1) / cell_samples_) {
  HAPTOMETER_CHECK(blocks_.block_size() % cell_samples_ == 0, "cells of {} in blocks of {}",
                   cell_samples_, blocks_.block_size());
}

Result<BandSignal> BandSignal::Filter(const SegmentSamples& samples, const FilterDesign& design,
                                      int threads) {
  HAPTOMETER_CHECK(samples.size() >= 1, "no samples");
  BandSignal signal(samples, design);
  const auto filtered = RunJobs(signal.blocks_.blocks(), threads, [&signal] {
    return [&signal, scratch = ZeroPhaseBlocks::Scratch{}](std::size_t block) mutable {
      return signal.FilterBlock(block, scratch);
    };
  });
  if (!filtered) return std::unexpected(filtered.error());
  if (auto found = signal.FindSettled(threads); !found) return std::unexpected(found.error());
  return signal;
}

ReadSamples BandSignal::reading() const {
  return [this](std::size_t first, std::span<double> out) { return samples_.Read(first, out); };
}

Result<void> BandSignal::FilterBlock(std::size_t block, ZeroPhaseBlocks::Scratch& scratch) {
  const SampleRange range = blocks_.Range(block);
  const auto filtered = blocks_.Filter(range, reading(), Continuation::kOdd, scratch);
  if (!filtered) return std::unexpected(filtered.error());
  std::span<const double> left = *filtered;
  for (std::size_t k = range.first / cell_samples_; !left.empty(); ++k) {
    const std::size_t count = std::min(cell_samples_, left.size());
    cells_[k] = CellOf(left.first(count));
    left = left.subspan(count);
  }
  return {};
}

Result<void> BandSignal::FindSettled(int threads) {
  // what the continuations differ by: near both ends, or everywhere where these meet
  const std::size_t reach = blocks_.lead_in() / cell_samples_;
  std::vector<CellRange> ends{{0, reach}, {cells_.size() - reach, cells_.size()}};
  if (2 * reach >= cells_.size()) ends = {{0, cells_.size()}};
  std::vector<double> differences(cells_.size());
  const auto compared = RunJobs(ends.size(), threads, [&] {
    return [&](std::size_t job) {
      return CompareContinuations(
          ends[job],
          std::span(differences).subspan(ends[job].begin, ends[job].end - ends[job].begin));
    };
  });
  if (!compared) return compared;
  GrowSettled(differences);
  return {};
}

Result<void> BandSignal::CompareContinuations(const CellRange& cells,
                                              std::span<double> differences) const {
  const std::size_t first = cells.begin * cell_samples_;
  const SampleRange range{first, std::min(cells.end * cell_samples_, size()) - first};
  ZeroPhaseBlocks::Scratch odd_scratch;
  ZeroPhaseBlocks::Scratch constant_scratch;
  const auto odd = blocks_.Filter(range, reading(), Continuation::kOdd, odd_scratch);
  if (!odd) return std::unexpected(odd.error());
  const auto constant = blocks_.Filter(range, reading(), Continuation::kConstant, constant_scratch);
  if (!constant) return std::unexpected(constant.error());
  for (std::size_t k = 0; k < odd->size(); ++k) {
    double& greatest = differences[k / cell_samples_];
    const double difference = std::abs((*odd)[k] - (*constant)[k]);
    // one that is no number stays
    if (!(difference <= greatest)) greatest = difference;
  }
  return {};
}

void BandSignal::GrowSettled(std::span<const double> differences) {
  // the tolerance hangs on the RMS of what has settled: begin with everything and shrink
  std::size_t begin = 0;
  std::size_t end = cells_.size();
  for (std::size_t before = end + 1; begin < end && end - begin < before;) {
    before = end - begin;
    const std::size_t samples = std::min(end * cell_samples_, size()) - begin * cell_samples_;
    const double square_sum = SquareSumOf(std::span(cells_).subspan(begin, before));
    const double tolerance =
        kSettledTolerance * std::sqrt(square_sum / static_cast<double>(samples));
    begin = end = cells_.size() / 2;
    while (begin > 0 && differences[begin - 1] <= tolerance) --begin;
    while (end < cells_.size() && differences[end] <= tolerance) ++end;
  }
  settled_begin_ = begin * cell_samples_;
  settled_end_ = std::min(end * cell_samples_, size());
}

Result<void> BandSignal::Read(std::size_t first, std::span<double> out) const {
  HAPTOMETER_CHECK(first <= size() && out.size() <= size() - first, "samples {} + {} of {}", first,
                   out.size(), size());
  ZeroPhaseBlocks::Scratch scratch;
  while (!out.empty()) {
    const SampleRange block = blocks_.Range(first / blocks_.block_size());
    const auto filtered = blocks_.Filter(block, reading(), Continuation::kOdd, scratch);
    if (!filtered) return std::unexpected(filtered.error());
    const auto wanted = filtered->subspan(first - block.first);
    const std::size_t count = std::min(wanted.size(), out.size());
    std::ranges::copy(wanted.first(count), out.begin());
    first += count;
    out = out.subspan(count);
  }
  return {};
}

Result<BandCell> BandSignal::CutCell(std::size_t begin, std::size_t end) const {
  std::vector<double> samples(end - begin);
  if (auto read = Read(begin, samples); !read) return std::unexpected(read.error());
  return CellOf(samples);
}

Result<BandSignal::CutRange> BandSignal::Cut(std::size_t begin, std::size_t end) const {
  HAPTOMETER_CHECK(begin <= end && end <= size(), "samples {} to {} of {}", begin, end, size());
  // the first and one past the last of the whole cells
  const std::size_t first = (begin + cell_samples_ - 1) / cell_samples_;
  const std::size_t last = end == size() ? cells_.size() : end / cell_samples_;
  CutRange range;
  const auto take = [&](std::size_t from, std::size_t to) -> Result<void> {
    if (from >= to) return {};
    const auto cut = CutCell(from, to);
    if (!cut) return std::unexpected(cut.error());
    range.cut.push_back(*cut);
    return {};
  };
  Result<void> taken = take(begin, std::min(first * cell_samples_, end));
  if (first <= last) {
    range.whole = std::span(cells_).subspan(first, last - first);
    if (taken) taken = take(std::min(last * cell_samples_, end), end);
  }
  if (!taken) return std::unexpected(taken.error());
  return range;
}

Result<double> BandSignal::SquareSum(std::size_t begin, std::size_t end) const {
  const auto range = Cut(begin, end);
  if (!range) return std::unexpected(range.error());
  return SquareSumOf(range->whole) + SquareSumOf(range->cut);
}

Result<Extremes> BandSignal::ExtremesOf(std::size_t begin, std::size_t end) const {
  HAPTOMETER_CHECK(begin < end, "samples {} to {}", begin, end);
  const auto range = Cut(begin, end);
  if (!range) return std::unexpected(range.error());
  Extremes extremes{std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  for (const std::span<const BandCell> cells :
       {range->whole, std::span<const BandCell>(range->cut)}) {
    for (const BandCell& cell : cells) {
      extremes.least = std::min(extremes.least, cell.least);
      extremes.most = std::max(extremes.most, cell.most);
    }
  }
  return extremes;
}

}  // namespace haptometer::dsp
