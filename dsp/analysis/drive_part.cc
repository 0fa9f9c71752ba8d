#include "dsp/analysis/drive_part.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

// partitioning costs blocks^2 / 2; longer records have longer blocks
constexpr std::size_t kMostBlocks = 2048;
// in power: a top below this many times the quiet level is no drive
constexpr double kLeastLevelRatio = 1.3;
// blocks that a level lasts at least to count as quiet, on or top
constexpr std::size_t kLeastQuietBlocks = 2;
constexpr std::size_t kLeastOnBlocks = 2;
constexpr std::size_t kLeastTopBlocks = 4;
// in power: levels up to this many times the quiet one are quiet
constexpr double kQuietSlack = 1.25;
// a tone below this part of its top amplitude pauses
constexpr double kPause = 0.3;
// squared amplitude of a level over the variance of its noise; e^-15 of noise alone is above
constexpr double kLeastTonePower = 15;
// the filter rings beside a drive; quiet parts keep this distance from it
constexpr double kQuietGuardBlocks = 2.5;
// steady: blocks within these deviations and part of the median power, and this change of amplitude
constexpr double kDeviations = 4;
constexpr double kPowerSlack = 0.01;
constexpr double kLeastDrift = 0.05;
// a median absolute deviation in standard deviations of a normal distribution
constexpr double kMadToDeviation = 1.4826;

// the course in blocks that the levels are read from
struct Blocks {
  std::vector<double> mean_square;
  double start_s = 0;
  double block_s = 0;

  [[nodiscard]] double Time(std::size_t block) const {
    return start_s + static_cast<double>(block) * block_s;
  }
};

// means of whole cells; a rest at the end that fills no block is not used
Blocks BlocksOf(const PowerCourse& course, double block_s) {
  const auto cells = static_cast<std::size_t>(std::max(1.0, std::round(block_s / course.cell_s)));
  Blocks blocks;
  blocks.start_s = course.start_s;
  blocks.block_s = static_cast<double>(cells) * course.cell_s;
  blocks.mean_square.reserve(course.mean_square.size() / cells);
  for (std::size_t begin = 0; begin + cells <= course.mean_square.size(); begin += cells) {
    double sum = 0;
    for (const double x : course.mean_square.subspan(begin, cells)) sum += x;
    blocks.mean_square.push_back(sum / static_cast<double>(cells));
  }
  return blocks;
}

// one period of the lower corner, or longer where that would be more than kMostBlocks
double BlockLength(const PowerCourse& course, const DriveSearch& search) {
  const double duration_s = static_cast<double>(course.mean_square.size()) * course.cell_s;
  return std::max(1 / search.lower_hz, duration_s / static_cast<double>(kMostBlocks));
}

// blocks [begin, end) at one level
struct Level {
  std::size_t begin = 0;
  std::size_t end = 0;
  double mean_square = 0;
  bool is_noise = false;  // a tone's that noise alone may give

  [[nodiscard]] std::size_t size() const { return end - begin; }
};

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Optimal partitioning of n blocks: the pieces [begin, end) whose sum of cost(begin, end) and one
// penalty each is least.
template <typename Cost>
std::vector<std::pair<std::size_t, std::size_t>> Partition(std::size_t n, const Cost& cost) {
  const double penalty = 6 + 3 * std::log(static_cast<double>(n));
  std::vector<double> best(n + 1, 0);
  std::vector<std::size_t> from(n + 1, 0);
  for (std::size_t end = 1; end <= n; ++end) {
    best[end] = std::numeric_limits<double>::infinity();
    for (std::size_t begin = 0; begin < end; ++begin) {
      // best[end]: least cost of blocks [0, end); the last piece of it is [begin, end)
      const double total = best[begin] + penalty + cost(begin, end);
      if (total < best[end]) {
        best[end] = total;
        from[end] = begin;
      }
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> pieces;
  pieces.reserve(n);
  for (std::size_t end = n; end > 0; end = from[end]) pieces.emplace_back(from[end], end);
  std::ranges::reverse(pieces);
  return pieces;
}

// levels of gamma-distributed powers
std::vector<Level> LevelsOf(const std::vector<double>& power, double degrees) {
  const std::size_t n = power.size();
  std::vector<double> sums(n + 1, 0);
  for (std::size_t k = 0; k < n; ++k) sums[k + 1] = sums[k] + power[k];
  if (sums[n] == 0) return {{0, n, 0}};
  const double least = 1e-9 * sums[n] / static_cast<double>(n);  // a drive that is exactly 0 is off
  const auto mean = [&](std::size_t begin, std::size_t end) {
    return (sums[end] - sums[begin]) / static_cast<double>(end - begin);
  };
  std::vector<Level> levels;
  // cost (nu/2) n ln(mean): the negative log likelihood of gamma-distributed powers
  const auto pieces = Partition(n, [&](std::size_t begin, std::size_t end) {
    return 0.5 * degrees * static_cast<double>(end - begin) * std::log(mean(begin, end) + least);
  });
  levels.reserve(pieces.size());
  for (const auto& [begin, end] : pieces) levels.push_back({begin, end, mean(begin, end)});
  return levels;
}

// levels of a tone's complex amplitude in Gaussian noise, as mean squares
std::vector<Level> LevelsOf(std::span<const std::complex<double>> tone) {
  const std::size_t n = tone.size();
  std::vector<std::complex<double>> sums(n + 1, 0);
  std::vector<double> squares(n + 1, 0);
  std::vector<double> changes(n - 1);
  for (std::size_t k = 0; k < n; ++k) {
    sums[k + 1] = sums[k] + tone[k];
    squares[k + 1] = squares[k] + std::norm(tone[k]);
    if (k > 0) changes[k - 1] = std::norm(tone[k] - tone[k - 1]);
  }
  // |change|^2 is exponential with a mean of 4 variances, its median ln 2 of that; changes of a
  // hundredth of the amplitude count as noise
  const double variance =
      MedianOf(changes) / (4 * std::numbers::ln2) + 1e-4 * squares[n] / static_cast<double>(n);
  if (variance == 0) return {{0, n, 0}};
  // cost sum |c - mean|^2 / (2 variance): the negative log likelihood in Gaussian noise
  const auto pieces = Partition(n, [&](std::size_t begin, std::size_t end) {
    const auto size = static_cast<double>(end - begin);
    return 0.5 / variance *
           (squares[end] - squares[begin] - std::norm(sums[end] - sums[begin]) / size);
  });
  std::vector<Level> levels;
  levels.reserve(pieces.size());
  for (const auto& [begin, end] : pieces) {
    const std::complex<double> mean = (sums[end] - sums[begin]) / static_cast<double>(end - begin);
    // |mean|^2 n / (2 variance) is exponential with mean 1 for noise alone
    const bool is_noise =
        0.5 * std::norm(mean) * static_cast<double>(end - begin) < kLeastTonePower * variance;
    levels.push_back({begin, end, 0.5 * std::norm(mean), is_noise});
  }
  return levels;
}

// mean square of the lowest level that lasts kLeastQuietBlocks
std::optional<double> QuietLevel(const std::vector<Level>& levels) {
  std::optional<double> quiet;
  for (const Level& level : levels) {
    if (level.size() < kLeastQuietBlocks) continue;
    quiet = std::min(quiet.value_or(level.mean_square), level.mean_square);
  }
  return quiet;
}

// mean square of the highest level that lasts kLeastTopBlocks and is not noise
double TopLevel(const std::vector<Level>& levels) {
  double top = 0;
  for (const Level& level : levels) {
    if (level.size() >= kLeastTopBlocks && !level.is_noise) top = std::max(top, level.mean_square);
  }
  return top;
}

// runs of levels above `threshold`
std::vector<Level> RunsAbove(const std::vector<Level>& levels, double threshold) {
  std::vector<Level> runs;
  for (const Level& level : levels) {
    if (level.mean_square <= threshold) continue;
    if (!runs.empty() && runs.back().end == level.begin) {
      runs.back().end = level.end;
    } else {
      runs.push_back(level);
    }
  }
  std::erase_if(runs, [](const Level& run) { return run.size() < kLeastOnBlocks; });
  return runs;
}

// narrows `run` to the blocks whose power is near the median of the run
Level Steadied(const std::vector<double>& power, Level run) {
  // the first and the last block hold the edges of the drive
  if (run.size() > 2) {
    ++run.begin;
    --run.end;
  }
  const std::vector<double> inside(power.begin() + static_cast<std::ptrdiff_t>(run.begin),
                                   power.begin() + static_cast<std::ptrdiff_t>(run.end));
  const double median = MedianOf(inside);
  std::vector<double> off(inside.size());
  std::ranges::transform(inside, off.begin(), [&](double p) { return std::abs(p - median); });
  // 4 robust deviations, and 1 % of the power where there is almost no noise
  const double limit = kDeviations * kMadToDeviation * MedianOf(off) + kPowerSlack * median;
  const auto lies_off = [&](std::size_t k) { return std::abs(power[k] - median) > limit; };
  const std::size_t most = run.size() / 4;  // what is trimmed from either end
  for (std::size_t k = 0; k < most && lies_off(run.begin); ++k) ++run.begin;
  for (std::size_t k = 0; k < most && lies_off(run.end - 1); ++k) --run.end;
  return run;
}

double MeanOf(const std::vector<double>& power, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t k = begin; k < end; ++k) sum += power[k];
  return sum / static_cast<double>(end - begin);
}

// the amplitude's change over the part, and whether it is below 5 % or within the noise
void MeasureDrift(const std::vector<double>& power, const Level& steady, OnPart& part) {
  part.is_steady = true;
  const std::size_t third = steady.size() / 3;
  if (third < 1) return;
  const double first = MeanOf(power, steady.begin, steady.begin + third);
  const double last = MeanOf(power, steady.end - third, steady.end);
  // powers are squares: sqrt of their ratio is that of amplitudes
  part.drift = std::sqrt(last / first) - 1;
  double square_sum = 0;  // of the differences of neighbours: noise, but no trend
  for (std::size_t k = steady.begin + 1; k < steady.end; ++k) {
    square_sum += (power[k] - power[k - 1]) * (power[k] - power[k - 1]);
  }
  // Var(difference of neighbours) = 2 Var(block); a mean over a third has Var(block) / third
  const double block_variance = 0.5 * square_sum / static_cast<double>(steady.size() - 1);
  const double noise = std::sqrt(2 * block_variance / static_cast<double>(third));
  part.is_steady = std::abs(part.drift) < kLeastDrift || std::abs(last - first) < 3 * noise;
}

// power in the middle third over that in the outer two: above 1 for the ringing of a filter
double BulgeOf(const std::vector<double>& power, const Level& run) {
  const std::size_t third = run.size() / 3;
  if (third < 1) return 1;
  const double outer =
      (MeanOf(power, run.begin, run.begin + third) + MeanOf(power, run.end - third, run.end)) / 2;
  return outer > 0 ? MeanOf(power, run.begin + third, run.end - third) / outer : 1;
}

OnPart PartOf(const Blocks& blocks, const std::vector<double>& response, const Level& run) {
  OnPart part;
  part.whole = {blocks.Time(run.begin), blocks.Time(run.end)};
  const Level steady = Steadied(response, run);
  part.steady = {blocks.Time(steady.begin), blocks.Time(steady.end)};
  part.mean_square = MeanOf(response, steady.begin, steady.end);
  MeasureDrift(response, steady, part);
  part.bulge = BulgeOf(response, run);
  return part;
}

// parts of the lowest level, kQuietGuardBlocks from the parts that are on
std::vector<TimeWindow> QuietParts(const Blocks& blocks, const std::vector<Level>& levels,
                                   double quiet_level) {
  std::vector<TimeWindow> parts;
  const double guard_s = kQuietGuardBlocks * blocks.block_s;
  for (const Level& level : levels) {
    if (level.mean_square > kQuietSlack * quiet_level) continue;
    TimeWindow part{blocks.Time(level.begin), blocks.Time(level.end)};
    if (level.begin > 0) part.begin_s += guard_s;
    if (level.end < blocks.mean_square.size()) part.end_s -= guard_s;
    if (part.duration_s() >= blocks.block_s) parts.push_back(part);
  }
  return parts;
}

// what counts as on and as quiet
struct Limits {
  double quiet = 0;      // mean square of the quiet level
  double threshold = 0;  // above is on
  double ratio = 0;      // of the top to the quiet level, in RMS
};

DriveParts Unchanging(Finding why) {
  return {.course = DriveCourse::kUnchanging, .on = {}, .quiet = {}, .why = std::move(why)};
}

// parts from levels; `response` decides what is steady
DriveParts PartsOf(const Blocks& blocks, const std::vector<double>& response,
                   const std::vector<Level>& levels, const Limits& limits, std::string_view what) {
  DriveParts parts;
  for (const Level& run : RunsAbove(levels, limits.threshold)) {
    parts.on.push_back(PartOf(blocks, response, run));
  }
  parts.quiet = QuietParts(blocks, levels, limits.quiet);
  if (parts.on.empty()) {
    parts.why = {.kind = FindingKind::kNothingStandsOut, .numbers = {{"of", std::string(what)}}};
    return parts;
  }
  parts.course = DriveCourse::kGated;
  const TimeWindow longest = parts.Longest()->whole;
  Finding why{.kind = FindingKind::kStandsOut,
              .numbers = {{"of", std::string(what)},
                          {"ratio", limits.ratio},
                          {"from_s", longest.begin_s},
                          {"to_s", longest.end_s}}};
  if (parts.on.size() > 1) why.numbers.emplace_back("parts", parts.on.size());
  parts.why = std::move(why);
  return parts;
}

// by power
// threshold: geometric mean of quiet and top level
DriveParts PowerParts(const Blocks& blocks, const std::vector<double>& response, double degrees,
                      std::string_view what) {
  const std::vector<Level> levels = LevelsOf(blocks.mean_square, degrees);
  const std::optional<double> quiet = QuietLevel(levels);
  const double top = TopLevel(levels);
  if (!quiet || !(top > kLeastLevelRatio * *quiet)) {
    return Unchanging({.kind = FindingKind::kOneLevel, .numbers = {{"of", std::string(what)}}});
  }
  // lower limits of the quiet level keep threshold and ratio finite for a drive that is exactly 0
  const Limits limits{std::max(*quiet, 1e-9 * top), std::sqrt(std::max(*quiet, 1e-4 * top) * top),
                      std::sqrt(top / std::max(*quiet, 1e-12 * top))};
  return PartsOf(blocks, response, levels, limits, what);
}

}  // namespace

const OnPart* DriveParts::Longest() const {
  if (on.empty()) return nullptr;
  return &*std::ranges::max_element(on, {},
                                    [](const OnPart& part) { return part.steady.duration_s(); });
}

DriveParts FindDriveParts(const PowerCourse& course, const DriveSearch& search) {
  HAPTOMETER_CHECK(course.cell_s > 0 && search.lower_hz > 0, "cells of {} s, lower corner {} Hz",
                   course.cell_s, search.lower_hz);
  const Blocks blocks = BlocksOf(course, BlockLength(course, search));
  const double degrees = std::max(1.0, 2 * search.bandwidth_hz * blocks.block_s);
  if (blocks.mean_square.size() < kLeastTopBlocks + kLeastQuietBlocks) {
    return Unchanging({.kind = FindingKind::kTooShortForParts});
  }
  return PowerParts(blocks, blocks.mean_square, degrees, "vibration");
}

DriveParts FindDriveParts(const PowerCourse& drive, const PowerCourse& response,
                          const DriveSearch& search) {
  HAPTOMETER_CHECK(drive.cell_s == response.cell_s && drive.start_s == response.start_s &&
                       drive.mean_square.size() == response.mean_square.size(),
                   "{} cells of {} s and {} of {} s", drive.mean_square.size(), drive.cell_s,
                   response.mean_square.size(), response.cell_s);
  HAPTOMETER_CHECK(drive.cell_s > 0 && search.lower_hz > 0, "cells of {} s, lower corner {} Hz",
                   drive.cell_s, search.lower_hz);
  // blocks, levels and threshold from the drive; steady parts from the response in the same blocks
  const double block_s = BlockLength(drive, search);
  const Blocks blocks = BlocksOf(drive, block_s);
  if (blocks.mean_square.size() < kLeastTopBlocks + kLeastQuietBlocks) {
    return Unchanging({.kind = FindingKind::kTooShortForParts});
  }
  const double degrees = std::max(1.0, 2 * search.bandwidth_hz * blocks.block_s);
  return PowerParts(blocks, BlocksOf(response, block_s).mean_square, degrees, "drive");
}

double DriveBlockSeconds(const PowerCourse& course, const DriveSearch& search) {
  const double cells = std::max(1.0, std::round(BlockLength(course, search) / course.cell_s));
  return cells * course.cell_s;
}

DriveParts FindDriveParts(std::span<const std::complex<double>> tone, const PowerCourse& response,
                          const DriveSearch& search) {
  HAPTOMETER_CHECK(response.cell_s > 0 && search.lower_hz > 0, "cells of {} s, lower corner {} Hz",
                   response.cell_s, search.lower_hz);
  const Blocks blocks = BlocksOf(response, BlockLength(response, search));
  HAPTOMETER_CHECK(blocks.mean_square.size() == tone.size(), "{} blocks and {} amplitudes",
                   blocks.mean_square.size(), tone.size());
  if (tone.size() < kLeastTopBlocks + kLeastQuietBlocks) {
    return Unchanging({.kind = FindingKind::kTooShortForParts});
  }
  const std::vector<Level> levels = LevelsOf(tone);
  const double top = TopLevel(levels);
  const std::optional<double> quiet = QuietLevel(levels);
  // the tone pauses where its amplitude is below 0.3 of the top: in power 0.09
  if (!quiet || !(*quiet < kPause * kPause * top)) {
    return Unchanging({.kind = FindingKind::kToneNeverPauses});
  }
  // on above half of the top amplitude, 0.25 in power
  const Limits limits{kPause * kPause * top / kQuietSlack, 0.25 * top,
                      std::sqrt(top / std::max(*quiet, 1e-12 * top))};
  return PartsOf(blocks, blocks.mean_square, levels, limits, "tone");
}

}  // namespace haptometer::dsp
