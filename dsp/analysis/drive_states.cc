#include "dsp/analysis/drive_states.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <ranges>
#include <span>
#include <utility>

#include "base/median.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/spectrum/changing_sine.h"
#include "dsp/spectrum/ridge.h"
#include "dsp/statistics/change_points.h"

namespace haptometer::dsp {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
// thinned samples a period of the upper corner
constexpr double kRatePerUpper = 5.2;
// thinned samples that are all looked at, and those in the frames of more
constexpr std::size_t kMostValues = std::size_t{1} << 21U;
constexpr std::size_t kMostInFrames = std::size_t{1} << 20U;
constexpr std::size_t kLeastSamples = 16;

// samples from one thinned sample to the next
std::size_t StrideOf(double rate_hz, const BandPass& band) {
  return std::max<std::size_t>(1,
                               static_cast<std::size_t>(rate_hz / (kRatePerUpper * band.upper_hz)));
}

// thinned samples of a block of `block_s`
std::size_t BlockSamples(double block_s, double thinned_hz) {
  return std::max(kLeastSamples, static_cast<std::size_t>(std::lround(block_s * thinned_hz)));
}

// two blocks of `block` thinned samples in each period, so many that kMostInFrames are enough for a
// segment of `size` samples; none where that is all of it
KeptFrames FramesOf(std::size_t size, std::size_t stride, std::size_t block) {
  const std::size_t thinned = (size - 1) / stride + 1;
  const std::size_t frame = 2 * block;
  if (thinned <= kMostValues || thinned < 2 * frame) return {.stride = stride};
  const std::size_t frames = std::max<std::size_t>(1, kMostInFrames / frame);
  const std::size_t period = (thinned + frames - 1) / frames;
  return {.stride = stride, .period = period, .offset = (period - frame) / 2, .frame = frame};
}

// The thinned samples that are looked at, and the blocks they lie in: all of a segment, whose
// blocks follow each other, or a frame in the middle of each block.
struct Samples {
  double rate_hz = 0;
  std::size_t begin = 0;   // of the first block, in samples of the segment
  std::size_t block = 0;   // thinned samples of a fit
  std::size_t frame = 0;   // and of a spectrum
  std::size_t period = 0;  // and from block to block
  std::size_t blocks = 0;
  bool in_frames = false;
  std::vector<double> values{};

  // of the fit of block k
  [[nodiscard]] std::span<const double> Fitted(std::size_t k) const {
    return std::span(values).subspan(in_frames ? k * frame : k * block, block);
  }
  // behind it, of frames only
  [[nodiscard]] std::span<const double> Following(std::size_t k) const {
    return std::span(values).subspan(k * frame + block, block);
  }
  // the frame about block k; the first and the last lie within the samples
  [[nodiscard]] std::span<const double> Frame(std::size_t k) const {
    if (in_frames) return std::span(values).subspan(k * frame, frame);
    const std::size_t middle = k * block + block / 2;
    const std::size_t first = std::min(middle - std::min(middle, frame / 2), values.size() - frame);
    return std::span(values).subspan(first, frame);
  }
};

// the frames of all periods that are free of transients
Result<Samples> ReadFrames(const BandSignal& signal, const BandPass& band, const KeptFrames& frames,
                           std::span<const SteadyLine> lines) {
  const std::size_t period = frames.period * frames.stride;
  const std::size_t first = (signal.settled_begin() + period - 1) / period;
  const std::size_t last = std::max(first, signal.settled_end() / period);
  Samples samples{.rate_hz = signal.rate_hz() / static_cast<double>(frames.stride),
                  .begin = first * period,
                  .block = frames.frame / 2,
                  .frame = frames.frame,
                  .period = frames.period,
                  .blocks = last - first,
                  .in_frames = true};
  samples.values.reserve(samples.blocks * frames.frame);
  for (std::size_t k = first; k < last; ++k) {
    const std::size_t begin = k * period + frames.offset * frames.stride;
    const std::size_t end = begin + (frames.frame - 1) * frames.stride + 1;
    HAPTOMETER_LET(const auto frame, ReadForStates(signal, band, lines, begin, end));
    samples.values.insert(samples.values.end(), frame.begin(), frame.end());
  }
  return samples;
}

// all samples that are free of transients, in blocks of `block` thinned ones
Result<Samples> ReadBlocks(const BandSignal& signal, const BandPass& band, std::size_t block,
                           std::span<const SteadyLine> lines) {
  const std::size_t stride = StrideOf(signal.rate_hz(), band);
  Samples samples{.rate_hz = signal.rate_hz() / static_cast<double>(stride),
                  .begin = signal.settled_begin()};
  // kept samples are multiples of the stride
  if (!signal.is_kept()) samples.begin = (samples.begin + stride - 1) / stride * stride;
  HAPTOMETER_LET(samples.values,
                 ReadForStates(signal, band, lines, samples.begin, signal.settled_end()));
  samples.block = samples.period = std::min(block, samples.values.size());
  samples.frame = std::min(2 * samples.block, samples.values.size());
  samples.blocks = samples.values.size() / samples.block;
  return samples;
}

// the fit of a block; `degrees` are the independent values in it, of which there are fewer than
// samples
DriveBlock FitBlock(std::span<const double> values, double rate_hz, double frequency_hz,
                    double degrees) {
  const auto n = static_cast<double>(values.size());
  const ChangingSine fit = FitChangingSine(values, kTwoPi * frequency_hz / rate_hz);
  DriveBlock block;
  block.amplitude_m = fit.amplitude;
  // d(phase)/dt = Im(z' / z), u advances by 2 rate / n a second
  const double moved = std::abs(fit.amplitude) > 0 ? std::imag(fit.slope / fit.amplitude) : 0;
  block.frequency_hz = frequency_hz + moved * 2 * rate_hz / n / kTwoPi;
  block.mean_square = fit.square_sum / n;
  // four parameters are taken from the independent values
  block.residual = fit.residual_sum / n * degrees / std::max(1.0, degrees - 4);
  return block;
}

// frequency of the strongest blocks: the median of those above half of the largest level
double FrequencyOfStrong(const std::vector<DriveBlock>& blocks) {
  double top = 0;
  for (const DriveBlock& block : blocks) top = std::max(top, block.level_m());
  std::vector<double> frequencies;
  for (const DriveBlock& block : blocks) {
    if (block.level_m() >= kMajority * top) frequencies.push_back(block.frequency_hz);
  }
  return UpperMedian(std::move(frequencies));
}

// mean square of samples [begin, end) by the cells that lie in them as a whole
double MeanSquareOfCells(const BandSignal& signal, std::size_t begin, std::size_t end) {
  const std::size_t size = signal.cell_samples();
  const std::size_t first = (begin + size - 1) / size;
  const std::size_t last = std::max(first + 1, end / size);
  double sum = 0;
  for (const BandCell& cell : signal.cells().subspan(first, last - first)) sum += cell.square_sum;
  return sum / static_cast<double>((last - first) * size);
}

// the whole of block `k`, which is fitted in a part, by its mean square without that of hum
void TakeWhole(const BlockCourse& course, double mean_square, std::size_t k, DriveBlock& block) {
  const DriveBlock& following = course.following[k];
  const double in_frame = 0.5 * (block.mean_square + following.mean_square);
  const double residual = 0.5 * (block.residual + following.residual);
  const double level_square =
      0.5 * (std::norm(block.amplitude_m) + std::norm(following.amplitude_m));
  // of a mean square of A cos + noise r over two fits: 2 (A^2 + r) r / degrees of freedom
  const double deviation =
      std::sqrt(2 * (level_square + residual) * residual / (2 * course.degrees_of_freedom()));
  // a mean square changes by twice the part of the amplitude
  const double same = 2 * kNoticeable * in_frame + kClearUncertainties * deviation;
  block.residual += std::max(0.0, std::abs(mean_square - in_frame) - same);
  block.mean_square = mean_square;
}

// Blocks that are fitted in a part take what the cells tell of all of them, the last one with what
// is left behind it.
void TakeCells(const BandSignal& signal, const Samples& samples, std::span<const SteadyLine> lines,
               BlockCourse& course) {
  double of_lines = 0;
  for (const SteadyLine& line : lines) of_lines += 0.5 * std::pow(line.amplitude_m(), 2);
  const double block = course.block_s * signal.rate_hz();
  const auto at = [&](std::size_t k) {
    return samples.begin + static_cast<std::size_t>(std::lround(static_cast<double>(k) * block));
  };
  for (std::size_t k = 0; k < course.blocks.size(); ++k) {
    const std::size_t end = k + 1 < course.blocks.size() ? at(k + 1) : signal.settled_end();
    const double mean_square = MeanSquareOfCells(signal, at(k), end) - of_lines;
    TakeWhole(course, std::max(0.0, mean_square), k, course.blocks[k]);
  }
}

// Whether the frames of a course stand for what lies between them: one drive, or none, throughout.
// They do not where the levels of a few blocks are off the median, or these differ from their
// fitted part.
bool IsUniform(const BlockCourse& course) {
  const auto of_blocks = course.blocks | std::views::transform(&DriveBlock::level_m);
  const double median = UpperMedian(std::vector<double>(of_blocks.begin(), of_blocks.end()));
  const auto others = std::ranges::count_if(course.blocks, [&](const DriveBlock& block) {
    const auto k = static_cast<std::size_t>(&block - course.blocks.data());
    const double noise = course.following[k].residual;
    const double off = 0.5 * kSteadyWithin * median +
                       kClearUncertainties * std::sqrt(2 * noise / course.degrees_of_freedom());
    return std::abs(block.level_m() - median) > off ||
           block.residual > 4 * noise + kNoticeable * median * median;
  });
  return 2 * static_cast<std::size_t>(others) <= kFewest;
}

Result<BlockCourse> MeasureIn(const BandSignal& signal, const BandPass& band, double block_s,
                              std::span<const SteadyLine> lines, bool may_skip) {
  const std::size_t stride = StrideOf(signal.rate_hz(), band);
  const std::size_t block = BlockSamples(block_s, signal.rate_hz() / static_cast<double>(stride));
  const KeptFrames frames = may_skip ? FramesOf(signal.size(), stride, block) : KeptFrames{};
  HAPTOMETER_LET(const Samples samples, frames.frame > 0 ? ReadFrames(signal, band, frames, lines)
                                                         : ReadBlocks(signal, band, block, lines));
  const auto period = static_cast<double>(samples.period);
  BlockCourse course{
      .start_s = signal.start_s() + static_cast<double>(samples.begin) / signal.rate_hz(),
      .block_s = period / samples.rate_hz,
      .bandwidth_hz = band.upper_hz - band.lower_hz,
      .blocks = {},
      .fitted = static_cast<double>(samples.block) / period,
      .following = {}};
  if (samples.blocks == 0) return course;
  const std::vector<double> ridge =
      FindRidge({.frame = [&samples](std::size_t k) { return samples.Frame(k); },
                 .count = samples.blocks,
                 .rate_hz = samples.rate_hz},
                band.lower_hz, band.upper_hz, kRidgeBinCost);
  const auto fit = [&](std::span<const double> values, std::size_t k) {
    return FitBlock(values, samples.rate_hz, ridge[k], course.degrees_of_freedom());
  };
  course.blocks.reserve(samples.blocks);
  for (std::size_t k = 0; k < samples.blocks; ++k) {
    course.blocks.push_back(fit(samples.Fitted(k), k));
    if (samples.in_frames) course.following.push_back(fit(samples.Following(k), k));
  }
  if (samples.in_frames) TakeCells(signal, samples, lines, course);
  return course;
}

}  // namespace

KeptFrames FramesToKeep(std::size_t size, double rate_hz, const BandPass& band) {
  const std::size_t stride = StrideOf(rate_hz, band);
  const double block_s = std::max(kShortestBlockS, 1 / band.lower_hz);
  KeptFrames frames =
      FramesOf(size, stride, BlockSamples(block_s, rate_hz / static_cast<double>(stride)));
  if (frames.frame == 0) frames.frame = frames.period = (size - 1) / stride + 1;
  return frames;
}

Result<std::vector<double>> ReadForStates(const BandSignal& signal, const BandPass& band,
                                          std::span<const SteadyLine> lines, std::size_t begin,
                                          std::size_t end) {
  const std::size_t stride = StrideOf(signal.rate_hz(), band);
  std::vector<double> values((end - begin - 1) / stride + 1);
  HAPTOMETER_TRY(signal.ReadThinned(begin, stride, values));
  const auto per_sample = static_cast<double>(stride);
  SubtractLines(lines, signal.rate_hz() / per_sample, static_cast<double>(begin) / per_sample,
                values);
  return values;
}

Result<BlockCourse> MeasureBlocks(const BandSignal& signal, const BandPass& band,
                                  double least_block_s, std::span<const SteadyLine> lines) {
  auto course = MeasureIn(signal, band, least_block_s, lines, true);
  const bool in_frames = course && course->fitted < 1;
  // a record that changes is measured block by block
  const bool may_skip = in_frames && !course->blocks.empty() && IsUniform(*course);
  if (in_frames && !may_skip) course = MeasureIn(signal, band, least_block_s, lines, false);
  if (!course || course->blocks.empty()) return course;
  // a low tone needs longer blocks
  const double needed_s = kBlockPeriods / FrequencyOfStrong(course->blocks);
  if (needed_s <= 1.2 * course->fitted * course->block_s) return course;
  return MeasureIn(signal, band, needed_s, lines, may_skip);
}

namespace {

double QuantileOf(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

// what the blocks are compared by, with sums over blocks [0, k)
struct Features {
  double level_variance = 0;  // the least
  double log_variance = 0;
  std::vector<std::array<double, 5>> sums;  // x, x^2, k x, y, y^2
  std::vector<double> inverse;              // 1 / k; 0 for none

  [[nodiscard]] std::size_t size() const { return sums.size() - 1; }

  // squares that a line leaves of the levels, and a constant of the logarithms
  [[nodiscard]] std::pair<double, double> SquaresLeft(std::size_t first, std::size_t end) const {
    std::array<double, 5> s{};
    for (std::size_t k = 0; k < s.size(); ++k) s[k] = sums[end][k] - sums[first][k];
    const double middle = 0.5 * static_cast<double>(first + end - 1);
    const double cross = s[2] - middle * s[0];
    // 1 / sum of (k - middle)^2 = 12 / (m (m^2 - 1))
    const double slopes = 12 * inverse[end - first] * inverse[end - first - 1] *
                          inverse[end - first + 1] * cross * cross;
    const double level = s[1] - s[0] * s[0] * inverse[end - first] - slopes;
    const double log = s[4] - s[3] * s[3] * inverse[end - first];
    return {std::max(0.0, level), std::max(0.0, log)};
  }

  [[nodiscard]] double Cost(std::size_t first, std::size_t end) const {
    const auto m = static_cast<double>(end - first);
    const auto [level, log] = SquaresLeft(first, end);
    const auto variance_of = [&](double squares, double least) {
      return std::max(least, (squares + 2 * least) * inverse[end - first + 2]);
    };
    const double of_level = variance_of(level, level_variance);
    const double of_log = variance_of(log, log_variance);
    // one logarithm and one division for both
    const double product = of_level * of_log;
    return m * std::log(product / (level_variance * log_variance)) +
           (level * of_log + log * of_level) / product;
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
  const double deviation = std::sqrt(2 * least / course.degrees_of_freedom()) + kLevelFloor * top;
  features.level_variance = deviation * deviation;
  features.log_variance = 2 / course.degrees_of_freedom();
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
  features.inverse.resize(levels.size() + 3);
  for (std::size_t k = 1; k < features.inverse.size(); ++k) {
    features.inverse[k] = 1 / static_cast<double>(k);
  }
  return features;
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

// part of the amplitude of blocks [first, end) that continues with the phase of its frequency, in
// the next block or in what follows each fit
double CoherenceOf(const BlockCourse& course, std::size_t first, std::size_t end) {
  const bool is_apart = !course.following.empty();
  const double half_turn = std::numbers::pi * course.fitted * course.block_s;
  std::complex<double> product = 0;
  double power = 0;
  for (std::size_t k = first; k + (is_apart ? 0 : 1) < end; ++k) {
    const DriveBlock& before = course.blocks[k];
    const DriveBlock& after = is_apart ? course.following[k] : course.blocks[k + 1];
    const double turn = half_turn * (after.frequency_hz + before.frequency_hz);
    product += after.amplitude_m * std::conj(before.amplitude_m) * std::polar(1.0, -turn);
    power += 0.5 * (std::norm(after.amplitude_m) + std::norm(before.amplitude_m));
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
  interval.coherence = CoherenceOf(course, first, end);
  return interval;
}

// whether the level exceeds what the largest of all bins of noise has
bool IsOn(const StateInterval& interval, const BlockCourse& course) {
  // per quadrature: 2 r / (2 B t); the ridge takes the largest of B t independent bins
  const double quadrature = std::sqrt(2 * interval.residual / course.degrees_of_freedom());
  const double bins = std::max(2.0, 0.5 * course.degrees_of_freedom());
  const double ridge = quadrature * std::sqrt(2 * std::log(bins));
  const auto m = static_cast<double>(interval.blocks());
  return interval.level_m > ridge * (kOnLevel + kOnScatter / std::sqrt(m));
}

// whether the tone is nearly all of its blocks
bool IsExplained(const StateInterval& state) {
  return state.residual < (1 - kExplained) * 0.5 * state.level_m * state.level_m;
}

// narrow noise at the band's foot, as red noise has, scatters less than the ridge of white noise
double MostScatter(const StateInterval& state, double lower_hz) {
  return std::max(state.from_hz, state.to_hz) < kFootReach * lower_hz ? kScatterAtFoot
                                                                      : kSteadyWithin;
}

// whether a steady tone at the band's foot is a drive: fewer blocks have to be nearly one sine
bool IsDriveAtFoot(const StateInterval& state) {
  if (state.blocks() >= kFewest) return true;
  return state.blocks() >= kFewestAtFoot && state.scatter < kNoticeable &&
         std::abs(state.drift) < kNoticeable && IsExplained(state);
}

bool AreOne(const StateInterval& a, const StateInterval& b) {
  if (a.state != b.state) return false;
  if (a.state == DriveState::kOff) return true;
  // levels as a whole, and where they meet
  const auto same = [](double x, double y) {
    return std::abs(x - y) <= kNoticeable * std::max(x, y);
  };
  return same(a.level_m, b.level_m) &&
         same(a.level_m * (1 + 0.5 * a.drift), b.level_m * (1 - 0.5 * b.drift));
}

// level, scatter and phases of one amplitude
bool IsSteady(const StateInterval& state, double lower_hz) {
  return std::abs(state.drift) < kSteadyWithin && state.scatter < MostScatter(state, lower_hz) &&
         state.coherence > kMajority;
}

// whether a state may be part of a drive of `level_m` and `frequency_hz` that goes up and down
bool IsPartOf(const StateInterval& state, double level_m, double frequency_hz) {
  return state.state != DriveState::kOff && state.level_m > kMajority * level_m &&
         std::abs(0.5 * (state.from_hz + state.to_hz) - frequency_hz) < kDriveReachHz;
}

// what a state is by its drift, its phases and its place in the band
void Judge(double lower_hz, StateInterval& state) {
  // a drive that comes or goes, below the noise on average: no part of it is quiet
  const double least = std::max(kSteadyWithin, kFalseAlarmDeviations * state.drift_uncertainty);
  if (state.state == DriveState::kOff && std::abs(state.drift) > least) {
    state.state = DriveState::kTransition;
  }
  if (state.state == DriveState::kOff) return;
  const bool at_foot = std::max(state.from_hz, state.to_hz) < kFootReach * lower_hz;
  if (state.state == DriveState::kOn) state.is_steady = IsSteady(state, lower_hz);
  if (!at_foot) return;
  // tremor reaches the band's foot as a tone that is never steady
  state.is_steady = state.is_steady && IsDriveAtFoot(state);
  state.is_short_at_foot = !state.is_steady && IsExplained(state);
  if (state.state == DriveState::kOn && !state.is_steady) state.state = DriveState::kOff;
}

// the end of the neighbours of state `first` that may be parts of one drive
std::size_t EndOfDrive(const std::vector<StateInterval>& states, std::size_t first) {
  const double frequency_hz = 0.5 * (states[first].from_hz + states[first].to_hz);
  double level_m = 0;
  std::size_t end = first;
  while (end < states.size() && IsPartOf(states[end], level_m, frequency_hz)) {
    level_m = std::max(level_m, states[end].level_m);
    ++end;
  }
  return end;
}

// whether the amplitude changes within a state by more than noise does
bool IsModulated(const StateInterval& state, const BlockCourse& course) {
  if (state.Drifts() || state.state == DriveState::kTransition) return true;
  const double of_noise =
      std::sqrt(2 * state.residual / course.degrees_of_freedom()) / state.level_m;
  return state.scatter > std::max(kNoticeable, kFalseAlarmDeviations * of_noise);
}

// Whether states are one amplitude that goes up and down all the time, as in a modulation or a
// beat: most of it changes, and no state is most of it.
bool AreModulated(std::span<const StateInterval> states, const BlockCourse& course) {
  std::size_t all = 0;
  std::size_t changing = 0;
  std::size_t longest = 0;
  for (const StateInterval& state : states) {
    all += state.blocks();
    longest = std::max(longest, state.blocks());
    if (IsModulated(state, course)) changing += state.blocks();
  }
  // counted twice: more than half
  return states.size() > 2 && 2 * longest < all && 2 * changing > all;
}

// how often the level of blocks goes up and down, once at least: half of its crossings of the mean
double CyclesOf(std::span<const DriveBlock> blocks, double mean_m) {
  int crossings = 0;
  for (std::size_t k = 1; k < blocks.size(); ++k) {
    if ((blocks[k - 1].level_m() > mean_m) != (blocks[k].level_m() > mean_m)) ++crossings;
  }
  return std::max(1.0, crossings / 2.0);
}

// the states with those of a modulated drive joined
std::vector<StateInterval> Joined(const BlockCourse& course, double lower_hz,
                                  const std::vector<StateInterval>& states) {
  std::vector<StateInterval> joined;
  for (std::size_t k = 0; k < states.size();) {
    const std::size_t end = std::max(k + 1, EndOfDrive(states, k));
    const auto part = std::span(states).subspan(k, end - k);
    k = end;
    if (AreModulated(part, course)) {
      StateInterval whole = Describe(course, part.front().first, part.back().end);
      whole.state = DriveState::kOn;
      whole.is_steady = IsSteady(whole, lower_hz);
      // not a part of a sweep through a resonance
      const double moved_hz = std::abs(whole.to_hz - whole.from_hz);
      if (whole.is_steady && moved_hz < kSameWithin * whole.from_hz) {
        const auto blocks = std::span(course.blocks).subspan(whole.first, whole.blocks());
        whole.modulation = 2 * std::numbers::sqrt2 * whole.scatter / std::numbers::pi /
                           CyclesOf(blocks, whole.level_m);
        joined.push_back(whole);
        continue;
      }
    }
    joined.insert(joined.end(), part.begin(), part.end());
  }
  return joined;
}

}  // namespace

std::string_view Name(DriveState state) {
  constexpr std::array<std::string_view, 3> kNames{"on", "off", "transition"};
  return kNames[static_cast<std::size_t>(state)];
}

std::vector<StateInterval> FindStates(const BlockCourse& course, double lower_hz) {
  if (course.blocks.empty()) return {};
  const Features features = FeaturesOf(course);
  // 5 c ln(n), see the header
  const double penalty =
      5 * kChangePenalty * std::log(static_cast<double>(std::max<std::size_t>(features.size(), 2)));
  const std::vector<std::size_t> borders = CheapestPartition(
      features.size(), penalty,
      [&](std::size_t first, std::size_t end) { return features.Cost(first, end); });
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
  for (StateInterval& state : states) Judge(lower_hz, state);
  return Joined(course, lower_hz, states);
}

}  // namespace haptometer::dsp
