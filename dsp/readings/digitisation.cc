#include "dsp/readings/digitisation.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

namespace haptometer::dsp {

namespace {

// share of samples at a rail below which clipping changes an RMS by less than 0.1 %
constexpr double kLeastShare = 1e-3;
// standard deviations beyond the rail: with normal errors 6e-5 of clean records
constexpr double kDeviations = 4;
constexpr std::size_t kTimesAsOften = 10;  // as any other value: of rounded sines 4 at most
constexpr double kBlockS = 0.1;
constexpr std::size_t kLeastBlock = 64;
constexpr int kHighestHarmonic = 3;
constexpr Eigen::Index kDriftTerms = 5;
// harmonics are taken where what is left without them is twice as large (in a deviation)
constexpr double kHarmonicsNeeded = 2;
// reciprocal condition of the normal equations below which phases are not told apart
constexpr double kToldApart = 1e-10;
// steps of rounding that the fit lies beyond the rail, on average
constexpr double kLeastSteps = 2;
// of what the samples span: rounding of a fit, and how far beyond the rail it lies at least
constexpr double kRounding = 1e-9;
constexpr double kLeastBeyond = 5e-6;

enum class Place : std::uint8_t { kMissing, kFree, kLow, kHigh };

// a signal's places and rails
struct Rails {
  std::vector<Place> places{};
  double low = 0;
  double high = 0;
  std::size_t measured = 0;
  std::size_t at_low = 0;
  std::size_t at_high = 0;

  [[nodiscard]] bool Many(std::size_t rows) const {
    return static_cast<double>(rows) > kLeastShare * static_cast<double>(measured);
  }
};

Rails FindRails(std::span<const double> samples) {
  Rails rails{.low = std::numeric_limits<double>::infinity(),
              .high = -std::numeric_limits<double>::infinity()};
  for (const double x : samples) {
    if (std::isnan(x)) continue;
    rails.low = std::min(rails.low, x);
    rails.high = std::max(rails.high, x);
    ++rails.measured;
  }
  rails.at_low = static_cast<std::size_t>(std::ranges::count(samples, rails.low));
  rails.at_high = static_cast<std::size_t>(std::ranges::count(samples, rails.high));
  const bool has_low = rails.Many(rails.at_low);
  const bool has_high = rails.Many(rails.at_high);
  rails.places.reserve(samples.size());
  for (const double x : samples) {
    rails.places.push_back(std::isnan(x)                 ? Place::kMissing
                           : has_low && x == rails.low   ? Place::kLow
                           : has_high && x == rails.high ? Place::kHigh
                                                         : Place::kFree);
  }
  if (!has_low) rails.at_low = 0;
  if (!has_high) rails.at_high = 0;
  return rails;
}

// what fits of all blocks leave, and where they lie beyond the rails
struct Rest {
  double square_sum = 0;
  double freedom = 0;
  double beyond = 0;  // sum over railed samples
  double variance =
      0;  // sum of what the fit's variance is there, in units of the samples' variance
  double railed = 0;
  double blocks = 0;  // that have railed samples
  bool is_determined = true;

  [[nodiscard]] double Deviation() const { return std::sqrt(square_sum / std::max(freedom, 1.0)); }
};

class Fitter {
 public:
  Fitter(std::span<const double> samples, const Rails& rails, double rate_hz, double tone_hz)
      : samples_(samples),
        rails_(rails),
        size_(std::max(kLeastBlock,
                       static_cast<std::size_t>(std::max(1.0, std::round(kBlockS * rate_hz))))) {
    while (highest_ > 1 && 2 * highest_ * tone_hz >= rate_hz) --highest_;
    // drift, tone, harmonics below half the rate: the same in each block
    terms_.resize(static_cast<Eigen::Index>(size_), TermsOf(highest_));
    for (Eigen::Index k = 0; k < terms_.rows(); ++k) {
      const double place = 2 * static_cast<double>(k) / static_cast<double>(size_) - 1;
      terms_(k, 0) = 1;
      for (Eigen::Index d = 1; d < kDriftTerms; ++d) terms_(k, d) = terms_(k, d - 1) * place;
      for (int h = 1; h <= highest_; ++h) {
        const double angle = 2 * std::numbers::pi * h * tone_hz * static_cast<double>(k) / rate_hz;
        terms_(k, TermsOf(h) - 2) = std::cos(angle);
        terms_(k, TermsOf(h) - 1) = std::sin(angle);
      }
    }
  }

  // fits a tone with harmonics up to `highest`, block by block, until the deviation of all blocks
  // is known to exceed `enough`
  [[nodiscard]] Rest Fit(int highest, bool with_rails,
                         double enough = std::numeric_limits<double>::infinity()) const {
    const double most = enough * enough * static_cast<double>(samples_.size());
    Rest rest;
    for (std::size_t begin = 0; begin + size_ <= samples_.size() && rest.square_sum <= most;
         begin += size_) {
      FitBlock(begin, TermsOf(std::min(highest, highest_)), with_rails, rest);
    }
    return rest;
  }

 private:
  // columns of a drift and of harmonics up to `highest`, a cosine and a sine each
  [[nodiscard]] static Eigen::Index TermsOf(Eigen::Index highest) {
    return kDriftTerms + 2 * highest;
  }

  void FitBlock(std::size_t begin, Eigen::Index columns, bool with_rails, Rest& rest) const {
    Eigen::MatrixXd matrix(terms_.rows(), columns);
    Eigen::VectorXd right(matrix.rows());
    std::vector<std::size_t> railed;
    Eigen::Index rows = 0;
    for (std::size_t k = 0; k < size_; ++k) {
      const Place place = rails_.places[begin + k];
      if (place == Place::kMissing) continue;
      if (place != Place::kFree && !with_rails) {
        railed.push_back(k);
        continue;
      }
      matrix.row(rows) = terms_.row(static_cast<Eigen::Index>(k)).head(columns);
      right[rows++] = samples_[begin + k] - rails_.low;
    }
    // fewer samples than terms, or terms that the sampled phases do not tell apart
    if (rows <= columns) return void(rest.is_determined = rest.is_determined && railed.empty());
    const auto used = matrix.topRows(rows);
    // normal equations of columns of one length, of the residual once more against their rounding
    const Eigen::VectorXd scale = used.colwise().norm().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> normal(scale.asDiagonal() * (used.transpose() * used) *
                                              scale.asDiagonal());
    if (!scale.allFinite() || !(normal.rcond() > kToldApart)) {
      return void(rest.is_determined = false);
    }
    Eigen::VectorXd fit = Eigen::VectorXd::Zero(columns);
    for (int step = 0; step < 2; ++step) {
      const Eigen::VectorXd left = used.transpose() * (right.head(rows) - used * fit);
      fit += scale.cwiseProduct(normal.solve(scale.cwiseProduct(left)));
    }
    rest.square_sum += (right.head(rows) - used * fit).squaredNorm();
    rest.freedom += static_cast<double>(rows - columns);
    rest.blocks += railed.empty() ? 0 : 1;
    for (const std::size_t k : railed) {
      const Eigen::VectorXd terms = terms_.row(static_cast<Eigen::Index>(k)).head(columns);
      const double value = rails_.low + terms.dot(fit);
      const bool is_high = rails_.places[begin + k] == Place::kHigh;
      rest.beyond += is_high ? value - rails_.high : rails_.low - value;
      // t' (A'A)^-1 t
      const Eigen::VectorXd scaled = scale.cwiseProduct(terms);
      rest.variance += scaled.dot(normal.solve(scaled));
      ++rest.railed;
    }
  }

  std::span<const double> samples_;
  const Rails& rails_;
  std::size_t size_;  // of a block
  int highest_ = kHighestHarmonic;
  Eigen::MatrixXd terms_;  // a row a sample of a block
};

// whether the fit lies beyond the rails at the samples that are there
bool IsBeyond(const Rest& rest, double span, double step) {
  if (!rest.is_determined || rest.railed == 0) return false;
  const double deviation = std::max(rest.Deviation(), kRounding * span);
  // of the mean: the samples' noise, and that of each block's fit; rounding repeats from block to
  // block where no noise hides the steps
  const double leverage = std::sqrt(rest.variance / rest.railed);
  const double blocks = deviation > step ? rest.blocks : 1;
  const double of_samples = deviation / std::sqrt(rest.railed);
  const double of_fits = deviation * leverage / std::sqrt(blocks);
  const double mean = rest.beyond / rest.railed;
  return mean > kLeastSteps * step * (1 + leverage) && mean > kLeastBeyond * span &&
         mean > kDeviations * std::hypot(of_samples, of_fits);
}

// samples that hold the most frequent value off the rails, but for rounding
std::size_t MostEqual(std::span<const double> samples, const Rails& rails) {
  std::vector<double> free;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (rails.places[k] == Place::kFree) free.push_back(samples[k]);
  }
  std::ranges::sort(free);
  const double equal = kRounding * (rails.high - rails.low);
  std::size_t most = 0;
  std::size_t run = 0;
  for (std::size_t k = 0; k < free.size(); ++k) {
    run = k > 0 && free[k] - free[k - 1] <= equal ? run + 1 : 1;
    most = std::max(most, run);
  }
  return most;
}

ClippingVerdict Judge(const Fitter& fitter, double span, double step) {
  const double floor = kRounding * span;
  const Rest all = fitter.Fit(1, true, floor);
  // one sine for all samples: no rail changed any
  if (all.is_determined && all.Deviation() <= floor) return ClippingVerdict::kNone;
  const Rest tone = fitter.Fit(1, false);
  if (!tone.is_determined) return ClippingVerdict::kUndecided;
  const Rest harmonics = fitter.Fit(kHighestHarmonic, false);
  if (!harmonics.is_determined) {
    return IsBeyond(tone, span, step) ? ClippingVerdict::kUndecided : ClippingVerdict::kNone;
  }
  const bool needs_harmonics =
      tone.Deviation() > kHarmonicsNeeded * std::max(harmonics.Deviation(), floor);
  return IsBeyond(needs_harmonics ? harmonics : tone, span, step) ? ClippingVerdict::kClipped
                                                                  : ClippingVerdict::kNone;
}

}  // namespace

Clipping FindClipping(std::span<const double> samples, double rate_hz, double tone_hz) {
  const Rails rails = FindRails(samples);
  if (rails.at_low + rails.at_high == 0 || !(rails.high > rails.low)) return {};
  const Fitter fitter(samples, rails, rate_hz, tone_hz);
  // neither noise nor rounding gives an extreme ten times as often as any other value
  const std::size_t railed = rails.at_low + rails.at_high;
  const bool only_there = railed > kTimesAsOften * MostEqual(samples, rails);
  Clipping clipping{.verdict = only_there ? ClippingVerdict::kClipped
                                          : Judge(fitter, rails.high - rails.low, StepOf(samples))};
  if (clipping.verdict == ClippingVerdict::kNone) return clipping;
  clipping.share = static_cast<double>(railed) / static_cast<double>(rails.measured);
  if (rails.at_low > 0) clipping.low_rail = rails.low;
  if (rails.at_high > 0) clipping.high_rail = rails.high;
  return clipping;
}

namespace {

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
  const double equal = kRounding * (values.back() - values.front());
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
