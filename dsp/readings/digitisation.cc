#include "dsp/readings/digitisation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

namespace haptometer::dsp {

namespace {

// of what the samples span: values that differ by less are one, but for the rounding of a
// calculation
constexpr double kSameValue = 1e-9;
constexpr double kMultiple = 0.01;     // of a step, that a change may lie off a multiple of it
constexpr double kMostMultiples = 10;  // and so many times that off a large one, not more
constexpr double kMostLeastSteps = 8;  // that the least change may be
// a change larger than so many steps is no rounding
constexpr double kSteepSteps = 2.5;
// share of repeated samples, and how many a change of few steps
constexpr double kLeastRepeated = 0.02;
constexpr std::size_t kOverChance = 2;
constexpr int kMostTerms = 200;
constexpr int kMostHarmonics = 20;
constexpr double kNegligible = 1e-6;

}  // namespace

double StepOf(std::span<const double> samples) {
  std::vector<double> values;
  std::ranges::copy_if(samples, std::back_inserter(values),
                       [](double x) { return !std::isnan(x); });
  std::ranges::sort(values);
  if (values.empty()) return 0;
  // differences of neighbouring values; those that are rounding are none
  const double equal = kSameValue * (values.back() - values.front());
  std::vector<double> gaps;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (values[k] - values[k - 1] > equal) gaps.push_back(values[k] - values[k - 1]);
  }
  if (gaps.empty()) return 0;
  // the greatest common divisor, by Euclid's algorithm
  const double least = std::ranges::min(gaps);
  double step = least;
  for (double gap : gaps) {
    while (gap > kMultiple * step) {
      const double steps = std::round(gap / step);
      const double rest = std::abs(gap - steps * step);
      if (rest <= kMultiple * step * std::clamp(steps, 1.0, kMostMultiples)) break;
      gap = std::exchange(step, rest);
    }
    if (step < least / kMostLeastSteps) return 0;
  }
  return step;
}

double RepeatedShare(std::span<const double> samples) {
  // most records have too few equal neighbours to be looked at
  std::size_t measured = 0, equal = 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    measured += std::isnan(samples[k]) ? 0 : 1;
    equal += samples[k] == samples[k - 1] ? 1 : 0;
  }
  const double least = kLeastRepeated * static_cast<double>(measured);
  if (equal == 0 || static_cast<double>(equal) < least) return 0;
  const double small = kSteepSteps * StepOf(samples);
  std::size_t repeated = 0, small_changes = 0;
  // the run of equal samples at hand: how many repeat its first, and the change that led to it
  std::size_t run = 0;
  double before = 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const double change = samples[k] - samples[k - 1];
    if (change == 0) {
      ++run;
      continue;
    }
    // both changes large and in one direction; a missing sample is NaN: no comparison holds
    if (change * before > 0 && std::min(std::abs(change), std::abs(before)) > small) {
      repeated += run;
    }
    if (std::abs(change) <= small) ++small_changes;
    run = 0;
    before = change;
  }
  const bool over_chance = repeated > kOverChance * small_changes;
  if (!over_chance || static_cast<double>(repeated) < least) return 0;
  return static_cast<double>(equal) / static_cast<double>(measured);
}

double QuantisationBound(double step, double amplitude, double noise_rms, int harmonics) {
  if (!(step > 0) || !(amplitude > 0)) return 0;
  const double noise = noise_rms / step;
  double first = 0;
  double square = 0;
  for (int n = 1; n <= std::clamp(harmonics, 1, kMostHarmonics); ++n) {
    double error = 0;
    for (int k = 1; k <= kMostTerms; ++k) {
      const double left = std::exp(-2 * std::pow(std::numbers::pi * k * noise, 2)) / k;
      if (left < kNegligible) break;
      const double argument = 2 * std::numbers::pi * k * amplitude / step;
      error += left * std::abs(std::cyl_bessel_j(static_cast<double>(n), argument));
    }
    // |J_n(x)| <= sqrt(2 / (pi x)) beyond the terms: a sum of k^-1.5, ended by noise
    const double tail = std::exp(-2 * std::pow(std::numbers::pi * kMostTerms * noise, 2));
    error += tail * 2 / (std::numbers::pi * std::sqrt(kMostTerms * amplitude / step));
    error *= 2 * step / std::numbers::pi;
    if (n == 1) first = error;
    if (n > 1) square += 0.5 * error * error;
  }
  const double rms = amplitude / std::numbers::sqrt2;
  return first / std::numbers::sqrt2 + std::min(std::sqrt(square), square / (2 * rms));
}

double CommensurateBound(double step, double amplitude, double noise_rms, double cycles_per_sample,
                         std::size_t samples) {
  if (!(step > 0) || !(amplitude > 0) || samples == 0) return 0;
  const auto count = static_cast<double>(samples);
  const double steps_per_cycle = 2 * std::numbers::pi * amplitude / step;
  double phases = count;
  // no more phases than samples, and none fewer than the samples until they come round
  for (double p = 1; p < phases; ++p) {
    const double lacking = std::abs(std::remainder(p * cycles_per_sample, 1));
    phases = std::min(phases, p + count * lacking * steps_per_cycle);
  }
  const double left = std::exp(-2 * std::pow(std::numbers::pi * noise_rms / step, 2));
  return left * step / (2 * std::sqrt(phases));
}

}  // namespace haptometer::dsp
