#include "dsp/readings/straight_lines.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "dsp/readings/digitisation.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {

namespace {

// samples in which straight lines are sought, and most of them a period of the tone
constexpr std::size_t kMostOnLines = 8192;
constexpr double kMostPerPeriod = 40;
constexpr double kLineSteps = 2.01;   // three roundings
constexpr double kSameNumber = 1e-9;  // of a number, rounding of its conversion to m
constexpr int kLeastDigits = 2;
constexpr int kMostDigits = 7;
constexpr double kSteepLine = 4;  // of that, by which a line rises over two samples
constexpr double kLeastOnLines = 0.1;
// a tone without noise that has few phases is straight where it passes its mean, and only there
constexpr double kLeastSpread = 0.2;
constexpr double kLinesPerPeriod = 2.05;  // a triangle has two
constexpr double kChanceOfGrid = 1e-6;
// share of samples beside no corner that lie on lines, and of those beside one that do not
constexpr double kStraight = 0.98;
constexpr double kBent = 0.7;
constexpr std::size_t kLeastOfEither = 20;
// of a sample, how near to a corner a line is no longer, or not yet, seen
constexpr double kBeside = 0.9;
constexpr double kOnLine = 0.999;
constexpr double kWhole = 1e-3;  // how near to a whole number of samples is one
// of what the samples span, twice the rounding of 32-bit numbers about 0
constexpr double kNumberRounding = 3e-7;

// where samples lie on the line through their neighbours
enum class Bend : std::uint8_t { kUnknown, kNone, kSome };

struct Bends {
  std::vector<Bend> at{};
  std::size_t steep = 0;  // samples on lines that rise or fall
  double spread = 0;      // of these, as a part of what all samples span
};

// least and greatest value
struct Range {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();

  void Take(double x) {
    least = std::fmin(least, x);
    most = std::fmax(most, x);
  }
};

// the last of `digits` digits of a number
double LastDigit(double x, int digits) {
  return x == 0 ? 0 : std::pow(10, std::floor(std::log10(std::abs(x))) - digits + 1);
}

// the count of digits that all numbers are rounded to (%.6g); 0 where they have more than seven
int DigitsOf(std::span<const double> samples) {
  int digits = kLeastDigits;
  for (const double x : samples) {
    const auto is_rounded = [x](int to) {
      const double unit = LastDigit(x, to);
      return !(std::abs(x - std::round(x / unit) * unit) > kSameNumber * std::abs(x));
    };
    while (digits <= kMostDigits && !is_rounded(digits)) ++digits;
  }
  return digits <= kMostDigits ? digits : 0;
}

Bends BendsOf(std::span<const double> samples) {
  Bends bends{.at = std::vector<Bend>(samples.size(), Bend::kUnknown)};
  Range all, on_lines;
  for (const double x : samples) all.Take(x);
  const double span = all.most - all.least;
  const double rounding = std::max(kLineSteps * StepOf(samples), kNumberRounding * span);
  const int digits = DigitsOf(samples);
  for (std::size_t k = 1; k + 1 < samples.size(); ++k) {
    // what the rounding of three numbers bends a line by
    double line = rounding;
    if (digits > 0) {
      const double outer =
          std::max(LastDigit(samples[k - 1], digits), LastDigit(samples[k + 1], digits));
      line = std::max(line, kLineSteps / 2 * (outer + LastDigit(samples[k], digits)));
    }
    const double before = samples[k] - samples[k - 1];
    const double after = samples[k + 1] - samples[k];
    if (std::isnan(before + after)) continue;
    bends.at[k] = std::abs(after - before) <= line ? Bend::kNone : Bend::kSome;
    if (bends.at[k] == Bend::kSome || std::abs(before + after) <= kSteepLine * line) continue;
    ++bends.steep;
    on_lines.Take(samples[k]);
  }
  bends.spread = (on_lines.most - on_lines.least) / span;
  return bends;
}

// whether the bends are those of corners every `period` samples, and only these
bool AreCorners(std::span<const Bend> bends, double period) {
  std::complex<double> sum;
  for (std::size_t k = 0; k < bends.size(); ++k) {
    const double turns = std::remainder(static_cast<double>(k) / period, 1);
    if (bends[k] == Bend::kSome) sum += std::polar(1.0, 2 * std::numbers::pi * turns);
  }
  const double first = std::arg(sum) / (2 * std::numbers::pi);
  std::size_t beside = 0, bent = 0, between = 0, straight = 0;
  for (std::size_t k = 0; k < bends.size(); ++k) {
    if (bends[k] == Bend::kUnknown) continue;
    const double turns = static_cast<double>(k) / period - first;
    const double off = period * std::abs(std::remainder(turns, 1));
    if (off < kBeside) {
      ++beside;
      bent += bends[k] == Bend::kSome ? 1 : 0;
    } else if (off > kOnLine) {
      ++between;
      straight += bends[k] == Bend::kNone ? 1 : 0;
    }
  }
  const auto part = [](std::size_t of, std::size_t all) {
    return static_cast<double>(of) / static_cast<double>(all);
  };
  return std::min(beside, between) >= kLeastOfEither && part(bent, beside) >= kBent &&
         part(straight, between) >= kStraight;
}

}  // namespace

double RowsBetweenReadings(std::span<const double> samples, double cycles_per_sample) {
  // the middle, as many samples a period as the corners need
  const auto stride =
      static_cast<std::size_t>(std::max(1.0, 1 / (kMostPerPeriod * cycles_per_sample)));
  const std::size_t size = std::min(samples.size() / stride, kMostOnLines);
  std::vector<double> middle(size);
  const std::size_t first = (samples.size() - size * stride) / 2;
  for (std::size_t k = 0; k < size; ++k) middle[k] = samples[first + k * stride];
  const Bends bends = BendsOf(middle);
  const bool any = static_cast<double>(bends.steep) > kLeastOnLines * static_cast<double>(size);
  if (!any || !(bends.spread > kLeastSpread)) return 0;
  // the bends as a series, whose strongest line may be any harmonic of the corners
  const auto bent = static_cast<double>(std::ranges::count(bends.at, Bend::kSome));
  const double mean = bent / static_cast<double>(size);
  std::vector<double> series(size);
  for (std::size_t k = 0; k < size; ++k) {
    if (bends.at[k] != Bend::kUnknown) series[k] = (bends.at[k] == Bend::kSome ? 1 : 0) - mean;
  }
  const double lowest = kLinesPerPeriod * cycles_per_sample * static_cast<double>(stride);
  const auto tone = StrongestTone(
      series, {.rate_hz = 1, .lower_hz = lowest, .upper_hz = 0.5, .false_alarm = kChanceOfGrid});
  const double line = tone ? tone->frequency_hz : 0.5;
  std::vector<double> frequencies{(1 - line) / 2, 0.5};  // the second may be an alias
  for (double order = 1; line / order >= lowest; ++order) frequencies.push_back(line / order);
  const auto found = std::ranges::find_if(frequencies, [&](double frequency) {
    return frequency >= lowest && AreCorners(bends.at, 1 / frequency);
  });
  if (found == frequencies.end()) return 0;
  const double rows = static_cast<double>(stride) / *found;
  return std::abs(rows - std::round(rows)) < kWhole ? std::round(rows) : rows;
}

}  // namespace haptometer::dsp
