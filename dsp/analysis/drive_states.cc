#include "dsp/analysis/drive_states.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

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
    for (std::size_t bin = 0; bin < count_; ++bin) {
      magnitudes[bin] = std::sqrt(std::norm(spectrum_[first_ + bin]));
    }
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
  // the path back from the best end, then forward: samples are read in that order
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
  SubtractLines(
      lines_, rate_hz_,
      static_cast<double>(begin_) / static_cast<double>(stride_) + static_cast<double>(first_),
      tile_);
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

namespace {

// penalty 5 c ln(n) of a change, see the header
constexpr double kPenalty = 5 * 1.5;
constexpr std::size_t kMostAtOnce = 2048;
// a level is known no better than to this part of the largest ones
constexpr double kLevelFloor = 2e-3;
constexpr double kLogFloor = 0.05;
// levels of neighbours that are one state
constexpr double kSameLevel = 0.03;
// a state is steady if it changes and scatters by less than this part
constexpr double kMostDrift = 0.5;
constexpr double kMostScatter = 0.6;
constexpr double kFoot = 2;  // times the lower corner
constexpr double kMostScatterAtFoot = 0.15;
constexpr std::size_t kLeastAtFoot = 6;  // blocks
constexpr double kLeastCoherence = 0.5;
// a state that is off and changes by more than itself, clear of its scatter, is a transition
constexpr double kLeastChange = 1;
constexpr double kChangeUncertainties = 3;

double QuantileOf(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

// what the blocks are compared by, with sums over blocks [0, k)
struct Features {
  double level_deviation = 0;
  double log_deviation = 0;
  std::vector<std::array<double, 5>> sums;  // x, x^2, k x, y, y^2

  [[nodiscard]] std::size_t size() const { return sums.size() - 1; }

  // squares that a line leaves of the levels, and a constant of the logarithms
  [[nodiscard]] std::pair<double, double> SquaresLeft(std::size_t first, std::size_t end) const {
    const auto m = static_cast<double>(end - first);
    std::array<double, 5> s{};
    for (std::size_t k = 0; k < s.size(); ++k) s[k] = sums[end][k] - sums[first][k];
    const double middle = 0.5 * static_cast<double>(first + end - 1);
    const double cross = s[2] - middle * s[0];
    const double spread = m * (m * m - 1) / 12;
    double level = s[1] - s[0] * s[0] / m;
    if (spread > 0) level -= cross * cross / spread;
    return {std::max(0.0, level), std::max(0.0, s[4] - s[3] * s[3] / m)};
  }

  [[nodiscard]] double Cost(std::size_t first, std::size_t end) const {
    const auto m = static_cast<double>(end - first);
    const auto [level, log] = SquaresLeft(first, end);
    const auto term = [m](double squares, double deviation) {
      const double least = deviation * deviation;
      const double variance = std::max(least, (squares + 2 * least) / (m + 2));
      return m * std::log(variance / least) + squares / variance;
    };
    return term(level, level_deviation) + term(log, log_deviation);
  }
};

Features FeaturesOf(const BlockCourse& course) {
  std::vector<double> residuals;
  std::vector<double> levels;
  residuals.reserve(course.blocks.size());
  levels.reserve(course.blocks.size());
  for (const DriveBlock& block : course.blocks) {
    residuals.push_back(block.residual);
    levels.push_back(block.level_m());
  }
  const double top = QuantileOf(levels, 0.95);
  const double least = std::max(QuantileOf(residuals, 0.25), 1e-12 * top * top);
  Features features;
  // u(|z|)^2 = 2 r / (2 B t), beside what the fit itself is off by
  features.level_deviation = std::sqrt(2 * least / course.degrees_of_freedom()) + kLevelFloor * top;
  features.log_deviation = std::hypot(std::sqrt(2 / course.degrees_of_freedom()), kLogFloor);
  // residuals far below what a tone's own imperfection leaves say nothing
  const double lowest = std::max(1e-300, kLevelFloor * kLevelFloor * top * top);
  features.sums.resize(levels.size() + 1);
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const double x = levels[k];
    const double y = std::log(residuals[k] + lowest);
    const std::array<double, 5> add{x, x * x, static_cast<double>(k) * x, y, y * y};
    for (std::size_t j = 0; j < add.size(); ++j)
      features.sums[k + 1][j] = features.sums[k][j] + add[j];
  }
  return features;
}

// borders of the cheapest partition of blocks [first, end), first and end included
std::vector<std::size_t> Partition(const Features& features, std::size_t first, std::size_t end,
                                   double penalty) {
  const std::size_t n = end - first;
  std::vector<double> cost(n + 1, 0.0);
  std::vector<std::size_t> from(n + 1, 0);
  cost[0] = -penalty;
  std::vector<std::size_t> candidates{0};
  std::vector<double> with;
  for (std::size_t k = 1; k <= n; ++k) {
    cost[k] = std::numeric_limits<double>::infinity();
    with.resize(candidates.size());
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      with[j] = cost[candidates[j]] + features.Cost(first + candidates[j], first + k);
      if (with[j] + penalty >= cost[k]) continue;
      cost[k] = with[j] + penalty;
      from[k] = candidates[j];
    }
    // a candidate that lost by more than a penalty never wins again
    std::size_t kept = 0;
    for (std::size_t j = 0; j < candidates.size(); ++j) {
      if (with[j] <= cost[k] + penalty) candidates[kept++] = candidates[j];
    }
    candidates.resize(kept);
    candidates.push_back(k);
  }
  std::vector<std::size_t> borders{end};
  for (std::size_t k = n; k > 0; k = from[k]) borders.push_back(first + from[k]);
  std::ranges::reverse(borders);
  return borders;
}

// of all blocks: in pieces, whose borders stay only where they pay
std::vector<std::size_t> PartitionAll(const Features& features) {
  const std::size_t n = features.size();
  const double penalty = kPenalty * std::log(static_cast<double>(std::max<std::size_t>(n, 2)));
  std::vector<std::size_t> borders{0};
  for (std::size_t first = 0; first < n; first += kMostAtOnce) {
    const auto piece = Partition(features, first, std::min(n, first + kMostAtOnce), penalty);
    borders.insert(borders.end(), piece.begin() + 1, piece.end());
  }
  for (std::size_t piece = kMostAtOnce; piece < n; piece += kMostAtOnce) {
    const auto at = std::ranges::lower_bound(borders, piece);
    if (at == borders.end() || *at != piece) continue;
    const std::size_t before = *(at - 1);
    const std::size_t after = *(at + 1);
    const double apart = features.Cost(before, piece) + features.Cost(piece, after) + penalty;
    if (features.Cost(before, after) <= apart) borders.erase(at);
  }
  return borders;
}

// value at the begin and at the end of a line through y(k), k = 0 .. n - 1
struct Line {
  double begin = 0;
  double end = 0;
  double deviation = 0;  // of the values about it
};

template <typename Values>
Line LineThrough(std::size_t n, const Values& y) {
  double mean = 0;
  for (std::size_t k = 0; k < n; ++k) mean += y(k) / static_cast<double>(n);
  const double middle = 0.5 * static_cast<double>(n - 1);
  double cross = 0;
  double spread = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double t = static_cast<double>(k) - middle;
    cross += t * (y(k) - mean);
    spread += t * t;
  }
  const double slope = spread > 0 ? cross / spread : 0;
  double squares = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double off = y(k) - mean - slope * (static_cast<double>(k) - middle);
    squares += off * off;
  }
  const double reach = slope * 0.5 * static_cast<double>(n);
  return {mean - reach, mean + reach, n > 2 ? std::sqrt(squares / static_cast<double>(n - 2)) : 0};
}

// part of the amplitude that continues from block to block with the phase of its frequency
double CoherenceOf(std::span<const DriveBlock> blocks, double block_s) {
  std::complex<double> product = 0;
  double power = 0;
  for (std::size_t k = 1; k < blocks.size(); ++k) {
    const double turn =
        std::numbers::pi * block_s * (blocks[k].frequency_hz + blocks[k - 1].frequency_hz);
    product +=
        blocks[k].amplitude_m * std::conj(blocks[k - 1].amplitude_m) * std::polar(1.0, -turn);
    power += 0.5 * (std::norm(blocks[k].amplitude_m) + std::norm(blocks[k - 1].amplitude_m));
  }
  return power > 0 ? product.real() / power : 0;
}

StateInterval Describe(const BlockCourse& course, std::size_t first, std::size_t end) {
  StateInterval interval{.first = first, .end = end, .time = course.Window(first, end)};
  const auto blocks = std::span(course.blocks).subspan(first, end - first);
  const auto m = static_cast<double>(blocks.size());
  double square = 0;
  for (const DriveBlock& block : blocks) {
    interval.residual += block.residual / m;
    square += block.mean_square / m;
  }
  interval.rms_m = std::sqrt(square);
  const Line level = LineThrough(blocks.size(), [&](std::size_t k) { return blocks[k].level_m(); });
  interval.level_m = 0.5 * (level.begin + level.end);
  if (interval.level_m > 0) {
    interval.drift = (level.end - level.begin) / interval.level_m;
    interval.scatter = level.deviation / interval.level_m;
    // of a slope through m values, times their length
    interval.drift_uncertainty = interval.scatter * std::sqrt(12 / m);
  }
  const Line frequency =
      LineThrough(blocks.size(), [&](std::size_t k) { return blocks[k].frequency_hz; });
  interval.from_hz = frequency.begin;
  interval.to_hz = frequency.end;
  interval.coherence = CoherenceOf(blocks, course.block_s);
  return interval;
}

// whether the level exceeds what the largest of all bins of noise has
bool IsOn(const StateInterval& interval, const BlockCourse& course) {
  // per quadrature: 2 r / (2 B t); the ridge takes the largest of B t independent bins
  const double quadrature = std::sqrt(2 * interval.residual / course.degrees_of_freedom());
  const double bins = std::max(2.0, 0.5 * course.degrees_of_freedom());
  const double ridge = quadrature * std::sqrt(2 * std::log(bins));
  const auto m = static_cast<double>(interval.blocks());
  return interval.level_m > ridge * (1.25 + 2 / std::sqrt(m));
}

// narrow noise at the band's foot, as red noise has, scatters less than the ridge of white noise
double MostScatter(const StateInterval& state, double lower_hz) {
  return std::max(state.from_hz, state.to_hz) < kFoot * lower_hz ? kMostScatterAtFoot
                                                                 : kMostScatter;
}

bool AreOne(const StateInterval& a, const StateInterval& b) {
  if (a.state != b.state) return false;
  if (a.state == DriveState::kOff) return true;
  // levels as a whole, and where they meet
  const auto same = [](double x, double y) {
    return std::abs(x - y) <= kSameLevel * std::max(x, y);
  };
  return same(a.level_m, b.level_m) &&
         same(a.level_m * (1 + 0.5 * a.drift), b.level_m * (1 - 0.5 * b.drift));
}

}  // namespace

std::string_view Name(DriveState state) {
  constexpr std::array<std::string_view, 4> kNames{"on", "off", "transition", "artifact"};
  return kNames[static_cast<std::size_t>(state)];
}

std::vector<StateInterval> FindStates(const BlockCourse& course, double lower_hz) {
  if (course.blocks.empty()) return {};
  const Features features = FeaturesOf(course);
  const std::vector<std::size_t> borders = PartitionAll(features);
  std::vector<StateInterval> states;
  for (std::size_t k = 0; k + 1 < borders.size(); ++k) {
    StateInterval next = Describe(course, borders[k], borders[k + 1]);
    next.state = IsOn(next, course) ? DriveState::kOn : DriveState::kOff;
    // a single block between two states is their border
    const bool inside = k > 0 && k + 2 < borders.size();
    if (inside && next.blocks() == 1) next.state = DriveState::kTransition;
    if (!states.empty() && AreOne(states.back(), next)) {
      const DriveState state = next.state;
      next = Describe(course, states.back().first, next.end);
      next.state = state;
      states.pop_back();
    }
    states.push_back(next);
  }
  for (StateInterval& state : states) {
    // a drive that comes or goes, below the noise on average: no part of it is quiet
    const double least = std::max(kLeastChange, kChangeUncertainties * state.drift_uncertainty);
    if (state.state == DriveState::kOff && std::abs(state.drift) > least) {
      state.state = DriveState::kTransition;
    }
    if (state.state != DriveState::kOn) continue;
    state.is_steady = std::abs(state.drift) < kMostDrift &&
                      state.scatter < MostScatter(state, lower_hz) &&
                      state.coherence > kLeastCoherence;
    // tremor reaches the band's foot as a tone that is never steady
    const bool at_foot = std::max(state.from_hz, state.to_hz) < kFoot * lower_hz;
    if (at_foot && state.blocks() < kLeastAtFoot) state.is_steady = false;
    if (at_foot && !state.is_steady) state.state = DriveState::kOff;
  }
  return states;
}

}  // namespace haptometer::dsp
