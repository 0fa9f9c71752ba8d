#include "dsp/analysis/band_signal.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/jobs.h"
#include "dsp/filter/settled.h"

namespace haptometer::dsp {
namespace {

constexpr double kLongestCellS = 1e-3;
constexpr std::size_t kMostCells = std::size_t{1} << 21U;

// a divisor of kTileSamples, so that no cell lies in two blocks
std::size_t CellSamples(std::size_t size, double rate_hz) {
  std::size_t samples = 1;
  for (std::size_t next = 2; next <= kTileSamples; ++next) {
    const bool is_short = static_cast<double>(next) <= kLongestCellS * rate_hz;
    if (kTileSamples % next == 0 && (is_short || size / samples > kMostCells)) samples = next;
  }
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

BandSignal::BandSignal(const SegmentSamples& samples, const FilterDesign& design,
                       std::optional<BelowBandModel> model)
    : samples_(samples),
      design_(design),
      model_(std::move(model)),
      blocks_(design, samples.size()),
      cell_samples_(CellSamples(samples.size(), samples.rate_hz())),
      cells_((samples.size() + cell_samples_ - 1) / cell_samples_) {
  HAPTOMETER_CHECK(blocks_.block_size() % cell_samples_ == 0, "cells of {} in blocks of {}",
                   cell_samples_, blocks_.block_size());
}

Result<BandSignal> BandSignal::Filter(const SegmentSamples& samples, const FilterDesign& design,
                                      int threads) {
  BandSignal signal(samples, design, std::nullopt);
  if (auto filtered = signal.FilterAll(threads); !filtered) {
    return std::unexpected(filtered.error());
  }
  return signal;
}

Result<BandSignal> BandSignal::FilterBeside(const SegmentSamples& samples,
                                            const FilterDesign& design, BelowBandModel model,
                                            int threads) {
  BandSignal signal(samples, design, std::move(model));
  if (auto filtered = signal.FilterAll(threads); !filtered) {
    return std::unexpected(filtered.error());
  }
  return signal;
}

Result<void> BandSignal::FilterAll(int threads) {
  HAPTOMETER_CHECK(size() >= 1, "no samples");
  const auto filtered = RunJobs(blocks_.blocks(), threads, [this] {
    return [this, scratch = ZeroPhaseBlocks::Scratch{}](std::size_t block) mutable {
      return FilterBlock(block, scratch);
    };
  });
  if (!filtered) return filtered;
  return FindSettled(threads);
}

ReadSamples BandSignal::reading() const {
  return [this](std::size_t first, std::span<double> out) -> Result<void> {
    if (auto read = samples_.Read(first, out); !read) return read;
    if (model_) model_->Subtract(first, out);
    return {};
  };
}

Result<std::span<const double>> BandSignal::Filtered(const SampleRange& range,
                                                     ZeroPhaseBlocks::Scratch& scratch) const {
  const auto filtered = blocks_.Filter(range, reading(), Continuation::kOdd, scratch);
  if (!filtered || !model_) return filtered;
  // the samples lie in `scratch`, whose they are to change
  const std::size_t offset = static_cast<std::size_t>(filtered->data() - scratch.samples.data());
  const std::span own = std::span(scratch.samples).subspan(offset, filtered->size());
  model_->AddFiltered(design_, range.first, own);
  return own;
}

Result<void> BandSignal::FilterBlock(std::size_t block, ZeroPhaseBlocks::Scratch& scratch) {
  const SampleRange range = blocks_.Range(block);
  const auto filtered = Filtered(range, scratch);
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
    const auto filtered = Filtered(block, scratch);
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
  return SquareSumOf(*found);
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
