#include "dsp/analysis/drive_states.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

namespace haptometer::dsp {
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
