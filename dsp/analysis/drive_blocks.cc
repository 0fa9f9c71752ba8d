#include "dsp/analysis/drive_blocks.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "dsp/spectrum/fft.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// thinned samples a period of the upper corner
constexpr double kRatePerUpper = 5.2;
constexpr std::size_t kTile = std::size_t{1} << 16U;
// periods of the tone in a block
constexpr double kPeriods = 4;
constexpr std::size_t kLeastSamples = 16;
// moves of the ridge: bins a block, and what a bin and a jump cost of the largest magnitude
constexpr std::ptrdiff_t kMostBins = 2;
constexpr double kBinCost = 0.02;
constexpr double kJumpCost = 1;
constexpr std::size_t kPadding = 4;

// the spectra of frames of two blocks, between the band's corners
class Frames {
 public:
  Frames(ThinnedSignal& samples, std::size_t block, const BandPass& band)
      : samples_(&samples),
        block_(block),
        frame_(std::min(2 * block, samples.size())),
        fft_(std::bit_ceil(kPadding * frame_)),
        padded_(fft_.size()),
        spectrum_(fft_.bins()),
        window_(frame_) {
    for (std::size_t n = 0; n < frame_; ++n) {
      const double turn = kTwoPi * (static_cast<double>(n) + 0.5) / static_cast<double>(frame_);
      window_[n] = 0.5 - 0.5 * std::cos(turn);
    }
    bin_hz_ = samples.rate_hz() / static_cast<double>(fft_.size());
    first_ = static_cast<std::size_t>(std::ceil(band.lower_hz / bin_hz_));
    const auto last = static_cast<std::size_t>(band.upper_hz / bin_hz_);
    count_ = std::min(last, fft_.bins() - 2) + 1 - first_;
  }

  [[nodiscard]] std::size_t bins() const { return count_; }
  [[nodiscard]] double FrequencyOf(double bin) const {
    return (static_cast<double>(first_) + bin) * bin_hz_;
  }

  // magnitudes of the frame about block `k`; the first and the last lie within the samples
  Result<void> Magnitudes(std::size_t k, std::span<double> magnitudes) {
    const std::size_t middle = k * block_ + block_ / 2;
    const std::size_t begin =
        std::min(middle - std::min(middle, frame_ / 2), samples_->size() - frame_);
    const auto values = samples_->At(begin, frame_);
    if (!values) return std::unexpected(values.error());
    std::ranges::fill(padded_, 0);
    for (std::size_t n = 0; n < frame_; ++n) padded_[n] = window_[n] * (*values)[n];
    fft_.Forward(padded_, spectrum_);
    for (std::size_t bin = 0; bin < count_; ++bin)
      magnitudes[bin] = std::abs(spectrum_[first_ + bin]);
    return {};
  }

 private:
  ThinnedSignal* samples_;
  std::size_t block_;
  std::size_t frame_;
  RealFft fft_;
  std::vector<double> padded_;
  std::vector<std::complex<double>> spectrum_;
  std::vector<double> window_;
  double bin_hz_ = 0;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

// best score of each bin after one block more, and the bin that it came from
void Advance(std::span<const double> magnitudes, double largest, std::vector<double>& score,
             std::span<std::uint16_t> from) {
  const auto count = static_cast<std::ptrdiff_t>(score.size());
  const std::ptrdiff_t top = std::ranges::max_element(score) - score.begin();
  std::vector<double> next(score.size());
  for (std::ptrdiff_t bin = 0; bin < count; ++bin) {
    double best = score[static_cast<std::size_t>(top)] - kJumpCost * largest;
    std::ptrdiff_t origin = top;
    for (std::ptrdiff_t step = -kMostBins; step <= kMostBins; ++step) {
      const std::ptrdiff_t at = bin + step;
      if (at < 0 || at >= count) continue;
      const double cost = kBinCost * largest * static_cast<double>(std::abs(step));
      if (score[static_cast<std::size_t>(at)] - cost <= best) continue;
      best = score[static_cast<std::size_t>(at)] - cost;
      origin = at;
    }
    next[static_cast<std::size_t>(bin)] = best + magnitudes[static_cast<std::size_t>(bin)];
    from[static_cast<std::size_t>(bin)] = static_cast<std::uint16_t>(origin);
  }
  score = std::move(next);
}

// bin between the neighbours at which a parabola through three logarithms is highest
double Interpolated(std::span<const double> magnitudes, std::size_t bin) {
  const auto middle = static_cast<double>(bin);
  if (bin == 0 || bin + 1 >= magnitudes.size()) return middle;
  const double tiny = std::numeric_limits<double>::min();
  const double left = std::log(magnitudes[bin - 1] + tiny);
  const double top = std::log(magnitudes[bin] + tiny);
  const double right = std::log(magnitudes[bin + 1] + tiny);
  const double bend = left - 2 * top + right;
  if (!(bend < 0)) return middle;
  return middle + std::clamp(0.5 * (left - right) / bend, -0.5, 0.5);
}

// frequencies of the ridge, a block each
Result<std::vector<double>> FindRidge(Frames& frames, std::size_t blocks) {
  const std::size_t bins = frames.bins();
  std::vector<double> magnitudes(bins);
  std::vector<double> score(bins, 0.0);
  std::vector<std::uint16_t> from(bins * blocks);
  // the largest magnitude decides what moves cost
  double largest = 0;
  for (std::size_t k = 0; k < blocks; ++k) {
    if (auto read = frames.Magnitudes(k, magnitudes); !read) return std::unexpected(read.error());
    largest = std::max(largest, *std::ranges::max_element(magnitudes));
  }
  for (std::size_t k = 0; k < blocks; ++k) {
    if (auto read = frames.Magnitudes(k, magnitudes); !read) return std::unexpected(read.error());
    Advance(magnitudes, largest, score, std::span(from).subspan(k * bins, bins));
  }
  // the path back from the best end
  std::vector<std::size_t> path(blocks);
  auto bin = static_cast<std::size_t>(std::ranges::max_element(score) - score.begin());
  for (std::size_t k = blocks; k-- > 0;) {
    path[k] = bin;
    bin = from[k * bins + bin];
  }
  std::vector<double> ridge(blocks);
  for (std::size_t k = 0; k < blocks; ++k) {
    if (auto read = frames.Magnitudes(k, magnitudes); !read) return std::unexpected(read.error());
    ridge[k] = frames.FrequencyOf(Interpolated(magnitudes, path[k]));
  }
  return ridge;
}

// least squares of (a + a' u) cos + (b + b' u) sin, u from -1 to 1 over the block
DriveBlock FitBlock(std::span<const double> values, double rate_hz, double frequency_hz,
                    double degrees) {
  const auto n = static_cast<double>(values.size());
  const double middle = 0.5 * (n - 1);
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double square = 0;
  const double step = kTwoPi * frequency_hz / rate_hz;
  std::complex<double> turn = std::polar(1.0, -step * middle);
  const std::complex<double> advance = std::polar(1.0, step);
  for (std::size_t k = 0; k < values.size(); ++k, turn *= advance) {
    const double u = (static_cast<double>(k) - middle) / (0.5 * n);
    const Eigen::Vector4d row(turn.real(), turn.imag(), u * turn.real(), u * turn.imag());
    normal.noalias() += row * row.transpose();
    right += values[k] * row;
    square += values[k] * values[k];
  }
  const Eigen::Vector4d fit = normal.ldlt().solve(right);
  DriveBlock block;
  block.amplitude_m = {fit[0], -fit[1]};
  // d(phase)/dt = Im(z' / z), u advances by 2 rate / n a second
  const std::complex<double> slope(fit[2], -fit[3]);
  const double moved = std::abs(block.amplitude_m) > 0 ? std::imag(slope / block.amplitude_m) : 0;
  block.frequency_hz = frequency_hz + moved * 2 * rate_hz / n / kTwoPi;
  block.mean_square = square / n;
  // four parameters are taken from the independent values, of which there are fewer than n
  block.residual =
      std::max(0.0, square - fit.dot(right)) / n * degrees / std::max(1.0, degrees - 4);
  return block;
}

// frequency of the strongest blocks: the median of those above half of the largest level
double FrequencyOfStrong(const std::vector<DriveBlock>& blocks) {
  double top = 0;
  for (const DriveBlock& block : blocks) top = std::max(top, block.level_m());
  std::vector<double> frequencies;
  for (const DriveBlock& block : blocks) {
    if (block.level_m() >= 0.5 * top) frequencies.push_back(block.frequency_hz);
  }
  std::ranges::nth_element(
      frequencies, frequencies.begin() + static_cast<std::ptrdiff_t>(frequencies.size() / 2));
  return frequencies[frequencies.size() / 2];
}

Result<BlockCourse> MeasureIn(ThinnedSignal& samples, const BandSignal& signal,
                              const BandPass& band, double block_s) {
  const auto wanted = static_cast<std::size_t>(std::lround(block_s * samples.rate_hz()));
  const std::size_t block = std::min(std::max(kLeastSamples, wanted), samples.size());
  const double begin_s = static_cast<double>(signal.settled_begin()) / signal.rate_hz();
  BlockCourse course{.start_s = signal.start_s() + begin_s,
                     .block_s = static_cast<double>(block) / samples.rate_hz(),
                     .bandwidth_hz = band.upper_hz - band.lower_hz,
                     .blocks = {}};
  const std::size_t blocks = samples.size() / block;
  Frames frames(samples, block, band);
  const auto ridge = FindRidge(frames, blocks);
  if (!ridge) return std::unexpected(ridge.error());
  course.blocks.reserve(blocks);
  for (std::size_t k = 0; k < blocks; ++k) {
    const auto values = samples.At(k * block, block);
    if (!values) return std::unexpected(values.error());
    course.blocks.push_back(
        FitBlock(*values, samples.rate_hz(), (*ridge)[k], course.degrees_of_freedom()));
  }
  return course;
}

}  // namespace

ThinnedSignal::ThinnedSignal(const BandSignal& signal, const BandPass& band,
                             std::span<const SteadyLine> lines, std::size_t begin, std::size_t end)
    : signal_(&signal),
      lines_(lines),
      begin_(begin),
      stride_(std::max<std::size_t>(
          1, static_cast<std::size_t>(signal.rate_hz() / (kRatePerUpper * band.upper_hz)))),
      size_((end - begin - 1) / stride_ + 1),
      rate_hz_(signal.rate_hz() / static_cast<double>(stride_)) {}

Result<std::span<const double>> ThinnedSignal::At(std::size_t first, std::size_t count) {
  if (first >= first_ && first + count <= first_ + tile_.size()) {
    return std::span(tile_).subspan(first - first_, count);
  }
  // a tile from here on, filtered again
  first_ = first;
  tile_.resize(std::min(std::max(count, kTile), size_ - first));
  raw_.resize((tile_.size() - 1) * stride_ + 1);
  if (auto read = signal_->Read(begin_ + first * stride_, raw_); !read)
    return std::unexpected(read.error());
  for (std::size_t n = 0; n < tile_.size(); ++n) tile_[n] = raw_[n * stride_];
  if (!lines_.empty()) {
    for (std::size_t n = 0; n < tile_.size(); ++n) {
      const auto sample = static_cast<double>(begin_ + (first_ + n) * stride_);
      tile_[n] -= ValueOf(lines_, sample / signal_->rate_hz());
    }
  }
  return std::span(std::as_const(tile_)).first(count);
}

Result<BlockCourse> MeasureBlocks(const BandSignal& signal, const BandPass& band,
                                  double least_block_s, std::span<const SteadyLine> lines) {
  ThinnedSignal samples(signal, band, lines, signal.settled_begin(), signal.settled_end());
  auto course = MeasureIn(samples, signal, band, least_block_s);
  if (!course) return course;
  // a low tone needs longer blocks
  const double needed_s = kPeriods / FrequencyOfStrong(course->blocks);
  if (needed_s <= 1.2 * course->block_s) return course;
  return MeasureIn(samples, signal, band, needed_s);
}

}  // namespace haptometer::dsp
