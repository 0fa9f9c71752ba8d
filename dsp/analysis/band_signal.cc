#include "dsp/analysis/band_signal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "base/error.h"
#include "base/jobs.h"
#include "dsp/filter/transient.h"
#include "dsp/readings/row_kernel.h"

namespace haptometer::dsp {
namespace {

// samples of a segment that are kept in memory rather than filtered again
constexpr std::size_t kMostKept = std::size_t{1} << 18U;
// samples that are filtered at a time to be thinned: 8 pieces
constexpr std::size_t kThinnedAtOnce = 8 * ZeroPhaseBlocks::kPieceSamples;

// a cell is at most 1 ms, unless the record then has more than kMostCells
constexpr double kLongestCellS = 1e-3;
constexpr std::size_t kMostCells = std::size_t{1} << 20U;

// samples of a cell: a divisor of kTileSamples, so that no cell lies in two pieces
std::size_t CellSamples(std::size_t size, double rate_hz) {
  std::size_t samples = 1;
  for (std::size_t next = 2; next <= kTileSamples; ++next) {
    const bool is_short = static_cast<double>(next) <= kLongestCellS * rate_hz;
    if (kTileSamples % next == 0 && (is_short || size / samples > kMostCells)) samples = next;
  }
  return samples;
}

BandCell CellOf(std::span<const double> samples) {
  const RowSum squares = WidestRowKernel().sum_squares(samples.data(), samples.size());
  return {squares.sum, squares.least, squares.most};
}

// how many values the frames of a segment hold; the last one may be cut
std::size_t ValuesOf(const KeptFrames& frames, std::size_t size) {
  if (frames.frame == 0) return 0;
  const std::size_t thinned = (size - 1) / frames.stride + 1;
  const std::size_t over = thinned % frames.period;
  const std::size_t cut = std::min(frames.frame, over - std::min(over, frames.offset));
  return thinned / frames.period * frames.frame + cut;
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

// the greatest magnitude in each cell; the first sample is number `offset` of its cell
std::vector<double> GreatestInCells(std::span<const double> samples, std::size_t offset,
                                    std::size_t cell_samples) {
  if (samples.empty()) return {};
  std::vector<double> greatest((offset + samples.size() + cell_samples - 1) / cell_samples);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    // cells keep the greatest magnitude; NaN, for which the comparison is false, is kept too
    double& cell = greatest[(offset + k) / cell_samples];
    // one that is no number stays
    if (!(std::abs(samples[k]) <= cell)) cell = std::abs(samples[k]);
  }
  return greatest;
}

}  // namespace

BandSignal::BandSignal(const SegmentSamples& samples, const FilterDesign& design,
                       std::optional<BelowBandModel> model, const KeptFrames& frames)
    : samples_(samples),
      design_(design),
      model_(std::move(model)),
      blocks_(design, samples.size()),
      cell_samples_(CellSamples(samples.size(), samples.rate_hz())),
      cells_((samples.size() + cell_samples_ - 1) / cell_samples_),
      kept_(samples.size() <= kMostKept ? samples.size() : 0),
      frames_(kept_.empty() ? frames : KeptFrames{}),
      in_frames_(ValuesOf(frames_, samples.size())),
      states_(blocks_.pieces()) {
  HAPTOMETER_CHECK(ZeroPhaseBlocks::kPieceSamples % cell_samples_ == 0, "cells of {} in pieces",
                   cell_samples_);
}

Result<BandSignal> BandSignal::Filter(const SegmentSamples& samples, const FilterDesign& design,
                                      int threads, const KeptFrames& frames,
                                      std::optional<BelowBandModel> model) {
  HAPTOMETER_CHECK(samples.size() >= 1, "no samples");
  BandSignal signal(samples, design, std::move(model), frames);
  HAPTOMETER_TRY(signal.FilterAll(threads));
  return signal;
}

Result<void> BandSignal::FilterAll(int threads) {
  // job 0 measures the dependence on the ends, the others filter a block each
  EndDependence dependence;
  const auto filtered = RunJobs(1 + blocks_.blocks(), threads, [&] {
    // a worker may be copied, its buffers not
    const auto scratch = std::make_shared<ZeroPhaseBlocks::Scratch>();
    return [&, scratch](std::size_t job) -> Result<void> {
      if (job > 0) return FilterBlock(job - 1, *scratch);
      HAPTOMETER_LET(dependence, MeasureEndDependence(blocks_, reading(), *scratch));
      return {};
    };
  });
  if (filtered) FindSettled(dependence);
  return filtered;
}

// samples before the filter, less the model of the motion below the band
ReadSamples BandSignal::reading() const {
  return [this](std::size_t first, std::span<double> out) -> Result<void> {
    HAPTOMETER_TRY(samples_.Read(first, out));
    if (model_) model_->Subtract(first, out);
    return {};
  };
}

Result<void> BandSignal::FilterBlock(std::size_t block, ZeroPhaseBlocks::Scratch& scratch) {
  // the filtered model is added, so that the result is that of the whole signal
  return blocks_.FilterPieces(
      block, reading(),
      [this](std::size_t first, std::span<double> samples) {
        if (model_) model_->AddFiltered(design_, first, samples);
        TakeCells(first, samples);
        TakeFrames(first, samples);
        if (!kept_.empty()) {
          std::ranges::copy(samples, kept_.begin() + static_cast<std::ptrdiff_t>(first));
        }
      },
      states_, scratch);
}

// of samples from `first` on, where a cell begins
void BandSignal::TakeCells(std::size_t first, std::span<const double> samples) {
  for (std::size_t k = first / cell_samples_; !samples.empty(); ++k) {
    const std::size_t count = std::min(cell_samples_, samples.size());
    cells_[k] = CellOf(samples.first(count));
    samples = samples.subspan(count);
  }
}

// what lies in frames of samples from `first` on; a frame may lie in two pieces
void BandSignal::TakeFrames(std::size_t first, std::span<const double> samples) {
  if (in_frames_.empty()) return;
  const std::size_t stride = frames_.stride;
  const std::size_t end = (first + samples.size() + stride - 1) / stride;
  std::size_t n = (first + stride - 1) / stride;
  while (n < end) {
    // from the frame's begin, or within it, to its end
    const std::size_t number = n / frames_.period;
    const std::size_t begin = number * frames_.period + frames_.offset;
    const std::size_t last = std::min(begin + frames_.frame, end);
    double* out = in_frames_.data() + number * frames_.frame;
    for (n = std::max(n, begin); n < last; ++n) out[n - begin] = samples[n * stride - first];
    n = (number + 1) * frames_.period;
  }
}

// samples that lie in one frame; nothing where they do not
std::span<const double> BandSignal::InFrames(std::size_t first, std::size_t stride,
                                             std::size_t count) const {
  if (in_frames_.empty() || stride != frames_.stride || first % stride != 0) return {};
  const std::size_t n = first / stride;
  if (frames_.frame == frames_.period) return std::span(in_frames_).subspan(n, count);
  const std::size_t number = n / frames_.period;
  const std::size_t begin = number * frames_.period + frames_.offset;
  if (n < begin || n + count > begin + frames_.frame) return {};
  return std::span(in_frames_).subspan(number * frames_.frame + n - begin, count);
}

// in cells: the greatest dependence in each, the RMS over whole ones
void BandSignal::FindSettled(const EndDependence& dependence) {
  EndDependence of_cells{
      .first = GreatestInCells(dependence.first, 0, cell_samples_),
      .last = GreatestInCells(dependence.last, (size() - dependence.last.size()) % cell_samples_,
                              cell_samples_)};
  const SampleRange settled = SettledRange(
      cells_.size(), of_cells,
      [this](const SampleRange& cells) {
        const std::size_t samples =
            std::min(cells.end() * cell_samples_, size()) - cells.first * cell_samples_;
        const double square_sum = SquareSumOf(std::span(cells_).subspan(cells.first, cells.count));
        return std::sqrt(square_sum / static_cast<double>(samples));
      },
      LeastRmsSamples(design_) / cell_samples_);
  settled_begin_ = std::min(settled.first * cell_samples_, size());
  settled_end_ = std::min(settled.end() * cell_samples_, size());
}

Result<void> BandSignal::Read(std::size_t first, std::span<double> out) const {
  HAPTOMETER_CHECK(first <= size() && out.size() <= size() - first, "samples {} + {} of {}", first,
                   out.size(), size());
  if (!kept_.empty()) {
    std::ranges::copy(std::span(kept_).subspan(first, out.size()), out.begin());
    return {};
  }
  ZeroPhaseBlocks::Scratch scratch;
  std::vector<double> filtered;
  while (!out.empty()) {
    // pieces are filtered again from their kept states: the same bytes, without a lead-in
    const std::size_t piece = first / ZeroPhaseBlocks::kPieceSamples;
    const SampleRange range = blocks_.PieceRange(piece);
    filtered.resize(range.count);
    HAPTOMETER_TRY(blocks_.FilterPiece(piece, states_[piece], reading(), filtered, scratch));
    if (model_) model_->AddFiltered(design_, range.first, filtered);
    const auto wanted = std::span(filtered).subspan(first - range.first);
    const std::size_t count = std::min(wanted.size(), out.size());
    std::ranges::copy(wanted.first(count), out.begin());
    first += count;
    out = out.subspan(count);
  }
  return {};
}

Result<void> BandSignal::ReadThinned(std::size_t first, std::size_t stride,
                                     std::span<double> out) const {
  if (out.empty()) return {};
  if (!kept_.empty()) {
    for (std::size_t n = 0; n < out.size(); ++n) out[n] = kept_[first + n * stride];
    return {};
  }
  if (const auto kept = InFrames(first, stride, out.size()); !kept.empty()) {
    std::ranges::copy(kept, out.begin());
    return {};
  }
  // filtered again, some pieces at a time
  const std::size_t at_once = std::max<std::size_t>(1, kThinnedAtOnce / stride);
  std::vector<double> raw;
  while (!out.empty()) {
    const auto part = out.first(std::min(at_once, out.size()));
    raw.resize((part.size() - 1) * stride + 1);
    HAPTOMETER_TRY(Read(first, raw));
    for (std::size_t n = 0; n < part.size(); ++n) part[n] = raw[n * stride];
    first += part.size() * stride;
    out = out.subspan(part.size());
  }
  return {};
}

Result<BandCell> BandSignal::CutCell(std::size_t begin, std::size_t end) const {
  std::vector<double> samples(end - begin);
  HAPTOMETER_TRY(Read(begin, samples));
  return CellOf(samples);
}

// whole cells from their sums, cut cells at both ends from their samples
Result<BandSignal::CutRange> BandSignal::Cut(std::size_t begin, std::size_t end) const {
  HAPTOMETER_CHECK(begin <= end && end <= size(), "samples {} to {} of {}", begin, end, size());
  // the first and one past the last of the whole cells
  const std::size_t first = (begin + cell_samples_ - 1) / cell_samples_;
  const std::size_t last = end == size() ? cells_.size() : end / cell_samples_;
  CutRange range;
  const auto take = [&](std::size_t from, std::size_t to) -> Result<void> {
    if (from >= to) return {};
    HAPTOMETER_LET(const auto cut, CutCell(from, to));
    range.cut.push_back(cut);
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
  HAPTOMETER_LET(const auto range, Cut(begin, end));
  return SquareSumOf(range.whole) + SquareSumOf(range.cut);
}

Result<Extremes> BandSignal::ExtremesOf(std::size_t begin, std::size_t end) const {
  HAPTOMETER_CHECK(begin < end, "samples {} to {}", begin, end);
  HAPTOMETER_LET(const auto range, Cut(begin, end));
  Extremes extremes{std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  for (const std::span<const BandCell> cells :
       {range.whole, std::span<const BandCell>(range.cut)}) {
    for (const BandCell& cell : cells) {
      extremes.least = std::min(extremes.least, cell.least);
      extremes.most = std::max(extremes.most, cell.most);
    }
  }
  return extremes;
}

double WholeRms(std::span<const BandSignal> signals) {
  double square_sum = 0;
  double count = 0;
  for (const BandSignal& signal : signals) {
    for (const BandCell& cell : signal.cells()) square_sum += cell.square_sum;
    count += static_cast<double>(signal.size());
  }
  return std::sqrt(square_sum / count);
}

}  // namespace haptometer::dsp
