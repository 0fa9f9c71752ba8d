#include "dsp/readings/clipping.h"

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

#include "base/median.h"
#include "dsp/readings/digitisation.h"

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
constexpr int kHighestOfAny = 9;  // harmonic that flattens a motion without a limit
constexpr Eigen::Index kDriftTerms = 5;
// of a whole period of 10 Hz in a block, a hundred times the tone, 1e-4 is left
constexpr Eigen::Index kTremorTerms = 9;
// harmonics are taken where what is left without them is twice as large (in a deviation)
constexpr double kHarmonicsNeeded = 2;
// reciprocal condition of the normal equations below which phases are not told apart
constexpr double kToldApart = 1e-10;
// steps of rounding that the fit lies beyond the rail, on average
constexpr double kLeastSteps = 2;
// of what the samples span: rounding of a fit, and how far beyond the rail it lies at least
constexpr double kRounding = 1e-9;
constexpr double kLeastBeyond = 5e-6;
// blocks, and samples of each, in which a limit below noise is sought
constexpr std::size_t kMostSpread = 24;
constexpr std::size_t kMostOfBlock = 1024;
// standard deviations of noise, or steps, inwards of a limit that samples are railed
constexpr double kNoiseReach = 4;
constexpr double kStepReach = 1.5;
// of half of what the samples span, that a limited tone goes beyond on average at most
constexpr double kMostBeyond = 0.9;
// of what the samples span, that a tone limited for most of its time goes beyond at most
constexpr double kMostOfRests = 2;
constexpr int kLimitPasses = 3;
constexpr int kRefits = 2;
constexpr std::size_t kDensest = 32;  // a mode is sought in a 32nd of the values
// standard deviations of the logarithm of likelihoods by which a limit explains samples better
constexpr double kBetter = 8;
constexpr Eigen::Index kModulation = 2;  // degree of the change of a tone over a block

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

// samples of a block
std::size_t BlockOf(double rate_hz) {
  return std::max(kLeastBlock,
                  static_cast<std::size_t>(std::max(1.0, std::round(kBlockS * rate_hz))));
}

// what fits of all blocks leave, and where they lie beyond the rails
struct Rest {
  double square_sum = 0;
  double railed_square_sum = 0;  // what the limited fits leave of railed samples
  double freedom = 0;
  double terms = 0;   // of all blocks
  double beyond = 0;  // sum over railed samples
  double variance =
      0;  // sum of what the fit's variance is there, in units of the samples' variance
  double railed = 0;
  double blocks = 0;  // that have railed samples
  bool is_determined = true;
  std::vector<double> fitted{};  // at the samples of all blocks; NaN where there is no fit

  [[nodiscard]] double Deviation() const { return std::sqrt(square_sum / std::max(freedom, 1.0)); }
};

class Fitter {
 public:
  Fitter(std::span<const double> samples, double rate_hz, double tone_hz, int highest,
         Eigen::Index drift_terms = kDriftTerms, Eigen::Index modulation = 0)
      : samples_(samples),
        size_(BlockOf(rate_hz)),
        highest_(highest),
        first_(drift_terms + 2 * modulation) {
    // drift, tone, harmonics: the same in each block
    terms_.resize(static_cast<Eigen::Index>(size_), TermsOf(highest_));
    for (Eigen::Index k = 0; k < terms_.rows(); ++k) {
      const double place = 2 * static_cast<double>(k) / static_cast<double>(size_) - 1;
      terms_(k, 0) = 1;
      for (Eigen::Index d = 1; d < drift_terms; ++d) terms_(k, d) = terms_(k, d - 1) * place;
      for (int h = 1; h <= highest_; ++h) {
        const double angle = 2 * std::numbers::pi * h * tone_hz * static_cast<double>(k) / rate_hz;
        terms_(k, TermsOf(h) - 2) = std::cos(angle);
        terms_(k, TermsOf(h) - 1) = std::sin(angle);
      }
      // the tone's amplitude and phase times powers of the time
      for (Eigen::Index d = drift_terms; d < first_; ++d) {
        const bool is_new = d < drift_terms + 2;
        terms_(k, d) = place * terms_(k, is_new ? TermsOf(1) - 2 + d - drift_terms : d - 2);
      }
    }
  }

  // fits a tone with harmonics up to `highest`, block by block, until the deviation of all blocks
  // is known to exceed `enough`
  [[nodiscard]] Rest Fit(const Rails& rails, int highest, bool with_rails,
                         double enough = std::numeric_limits<double>::infinity()) const {
    const double most = enough * enough * static_cast<double>(samples_.size());
    Rest rest;
    for (std::size_t begin = 0; begin + size_ <= samples_.size() && rest.square_sum <= most;
         begin += size_) {
      FitBlock(rails, begin, TermsOf(std::min(highest, highest_)), with_rails, rest);
    }
    return rest;
  }

 private:
  // columns of a drift and of harmonics up to `highest`, a cosine and a sine each
  [[nodiscard]] Eigen::Index TermsOf(Eigen::Index highest) const { return first_ + 2 * highest; }

  void FitBlock(const Rails& rails, std::size_t begin, Eigen::Index columns, bool with_rails,
                Rest& rest) const {
    rest.fitted.resize(begin + size_, std::numeric_limits<double>::quiet_NaN());
    Eigen::MatrixXd matrix(terms_.rows(), columns);
    Eigen::VectorXd right(matrix.rows());
    std::vector<std::size_t> railed;
    Eigen::Index rows = 0;
    for (std::size_t k = 0; k < size_; ++k) {
      const Place place = rails.places[begin + k];
      if (place == Place::kMissing) continue;
      if (place != Place::kFree && !with_rails) {
        railed.push_back(k);
        continue;
      }
      matrix.row(rows) = terms_.row(static_cast<Eigen::Index>(k)).head(columns);
      right[rows++] = samples_[begin + k] - rails.low;
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
    Eigen::VectorXd::Map(rest.fitted.data() + begin, terms_.rows()) =
        (terms_.leftCols(columns) * fit).array() + rails.low;
    rest.freedom += static_cast<double>(rows - columns);
    rest.terms += static_cast<double>(columns);
    rest.blocks += railed.empty() ? 0 : 1;
    for (const std::size_t k : railed) {
      const Eigen::VectorXd terms = terms_.row(static_cast<Eigen::Index>(k)).head(columns);
      const double value = rails.low + terms.dot(fit);
      const bool is_high = rails.places[begin + k] == Place::kHigh;
      rest.beyond += is_high ? value - rails.high : rails.low - value;
      const double limited = is_high ? std::min(value, rails.high) : std::max(value, rails.low);
      rest.railed_square_sum += std::pow(samples_[begin + k] - limited, 2);
      // t' (A'A)^-1 t
      const Eigen::VectorXd scaled = scale.cwiseProduct(terms);
      rest.variance += scaled.dot(normal.solve(scaled));
      ++rest.railed;
    }
  }

  std::span<const double> samples_;
  std::size_t size_;  // of a block
  int highest_;
  Eigen::Index first_;     // columns ahead of the tone's
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

// samples at a rate
struct Spread {
  std::vector<double> samples{};
  double rate_hz = 0;
};

// of evenly spread blocks, at most kMostOfBlock of the samples of each
Spread SpreadBlocks(std::span<const double> samples, double rate_hz) {
  const std::size_t size = BlockOf(rate_hz);
  const std::size_t stride = (size + kMostOfBlock - 1) / kMostOfBlock;
  const std::size_t blocks = samples.size() / size;
  const std::size_t used = std::min(blocks, kMostSpread);
  Spread spread{.rate_hz = rate_hz / static_cast<double>(stride)};
  for (std::size_t block = 0; block < used; ++block) {
    const std::size_t first = block * blocks / used * size;
    for (std::size_t k = 0; k < BlockOf(spread.rate_hz); ++k) {
      if (first + k * stride >= samples.size()) break;
      spread.samples.push_back(samples[first + k * stride]);
    }
  }
  return spread;
}

// the middle of the densest of sorted values, by halves (half-sample mode: Bickel and Fruehwirth,
// Comput. Stat. Data Anal. 50, 2006)
double ModeOf(std::span<const double> sorted) {
  const std::size_t enough = std::max<std::size_t>(sorted.size() / kDensest, 2);
  while (sorted.size() > enough) {
    const std::size_t half = (sorted.size() + 1) / 2;
    std::size_t densest = 0;
    for (std::size_t k = 1; k + half <= sorted.size(); ++k) {
      const double width = sorted[k + half - 1] - sorted[k];
      if (width < sorted[densest + half - 1] - sorted[densest]) densest = k;
    }
    sorted = sorted.subspan(densest, half);
  }
  return sorted[sorted.size() / 2];
}

// from which value on samples belong to an upper limit: where the upper half of sorted values is
// densest, less what noise about it and rounding reach;
// the mode is moved to the median of what lies above that, whose upper half is noise
double RailedFrom(std::span<const double> sorted, double step) {
  double mode = ModeOf(sorted.subspan(sorted.size() / 2));
  double limit = mode;
  for (int pass = 0; pass < kLimitPasses; ++pass) {
    const auto above =
        static_cast<std::size_t>(std::ranges::upper_bound(sorted, mode) - sorted.begin());
    const double off = above < sorted.size() ? sorted[(above + sorted.size()) / 2] - mode : 0;
    limit = mode - std::max(kNoiseReach * kDeviationsPerMedian * off, kStepReach * step);
    const auto railed =
        static_cast<std::size_t>(std::ranges::upper_bound(sorted, limit) - sorted.begin());
    if (railed == sorted.size()) break;  // values without noise or rounding end at their mode
    mode = sorted[(railed + sorted.size()) / 2];
  }
  return limit;
}

// samples beyond either limit are railed; a rail is the median of these
Rails RailsByValue(std::span<const double> samples, std::span<const double> sorted, double least,
                   double most) {
  Rails rails{.low = sorted.front(), .high = sorted.back(), .measured = sorted.size()};
  for (const double x : samples) {
    rails.places.push_back(std::isnan(x) ? Place::kMissing
                           : x > most    ? Place::kHigh
                           : x < least   ? Place::kLow
                                         : Place::kFree);
    rails.at_low += x < least ? 1 : 0;
    rails.at_high += x > most ? 1 : 0;
  }
  // the rare one of the noise that lies further inwards, which would bend a fit to the others
  for (std::size_t k = 1; k + 1 < samples.size(); ++k) {
    const Place before = rails.places[k - 1];
    const bool is_between = before != Place::kMissing && before == rails.places[k + 1];
    if (rails.places[k] == Place::kFree && is_between) rails.places[k] = before;
  }
  if (rails.at_low > 0) rails.low = sorted[rails.at_low / 2];
  if (rails.at_high > 0) rails.high = sorted[sorted.size() - 1 - rails.at_high / 2];
  return rails;
}

// samples are railed where a fit lies beyond the rails, which their noise does not move; the new
// rails are their means
Rails RailsByFit(std::span<const double> samples, std::span<const double> fitted,
                 const Rails& before) {
  Rails rails = before;
  rails.at_low = rails.at_high = 0;
  double low = 0, high = 0;
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    if (std::isnan(samples[k])) continue;
    rails.places[k] = Place::kFree;
    if (before.at_high > 0 && fitted[k] > before.high) {
      rails.places[k] = Place::kHigh;
      high += (samples[k] - high) / static_cast<double>(++rails.at_high);
    } else if (before.at_low > 0 && fitted[k] < before.low) {
      rails.places[k] = Place::kLow;
      low += (samples[k] - low) / static_cast<double>(++rails.at_low);
    }
  }
  if (rails.at_low > 0) rails.low = low;
  if (rails.at_high > 0) rails.high = high;
  return rails;
}

Clipping ClippingAt(const Rails& rails, ClippingVerdict verdict) {
  Clipping clipping{.verdict = verdict};
  const auto railed = static_cast<double>(rails.at_low + rails.at_high);
  clipping.share = railed / static_cast<double>(rails.measured);
  if (rails.at_low > 0) clipping.low_rail = rails.low;
  if (rails.at_high > 0) clipping.high_rail = rails.high;
  return clipping;
}

// by how many deviations a limited tone explains all samples better than one of `any` harmonics:
// half the samples times the logarithm of the variances, in the deviation that the difference of
// terms gives it where both are right; rounding leaves variances of `least`
double BetterBy(const Rest& limited, const Rest& any, double least) {
  const double railed = std::max(limited.railed_square_sum, limited.railed * least);
  const double left = (limited.square_sum + railed) / (limited.freedom + limited.railed);
  const double ratio = std::max(any.square_sum / any.freedom, least) / std::max(left, least);
  const double samples = any.freedom + any.terms;
  return samples / 2 * std::log(ratio) / std::sqrt((any.terms - limited.terms) / 2);
}

// variance that steps and the rounding of numbers leave
double RoundingVariance(double step, double span) {
  return std::max(step * step / 12, std::pow(kRounding * span, 2));
}

// Whether samples of which many are at a rail were clipped there. `only_there`: they are ten times
// as many as those of any other value, which neither noise nor rounding gives.
ClippingVerdict JudgeRails(const Fitter& fitter, const Rails& rails, int highest, double step,
                           bool only_there) {
  const double span = rails.high - rails.low;
  const double floor = kRounding * span;
  // one sine for all samples: no rail changed any
  const Rest sine = fitter.Fit(rails, 1, true, floor);
  if (sine.is_determined && sine.Deviation() <= floor) return ClippingVerdict::kNone;
  const Rest tone = fitter.Fit(rails, 1, false);
  if (!tone.is_determined) {
    return only_there ? ClippingVerdict::kClipped : ClippingVerdict::kUndecided;
  }
  // the tone with harmonics where they explain the samples off the rails better
  const Rest harmonics = fitter.Fit(rails, highest, false);
  const bool needs_harmonics =
      harmonics.is_determined &&
      tone.Deviation() > kHarmonicsNeeded * std::max(harmonics.Deviation(), floor);
  const Rest& limited = needs_harmonics ? harmonics : tone;
  if (!only_there && !IsBeyond(limited, span, step)) return ClippingVerdict::kNone;
  if (!only_there && !harmonics.is_determined) return ClippingVerdict::kUndecided;
  // the tone with harmonics of its own, and by how much a limit explains all samples better
  const Rest any = fitter.Fit(rails, kHighestOfAny, true);
  const double better =
      any.is_determined ? BetterBy(limited, any, RoundingVariance(step, span)) : 0;
  const bool has_shape = any.Deviation() <= step && better < -kBetter;
  // a motion at one extreme for most of its time rests there, unless a limited tone explains it
  const bool is_limited = IsBeyond(limited, span, step) && better > 0 &&
                          limited.beyond <= kMostOfRests * span * limited.railed;
  const bool rests = 2 * std::max(rails.at_low, rails.at_high) > rails.measured && !is_limited;
  return has_shape || rests ? ClippingVerdict::kUndecided : ClippingVerdict::kClipped;
}

// whether a fit to the samples off the limits goes beyond them, and not as far as from one level of
// a square wave to the other, or from the rest of a pulse
bool MayBeLimited(const Rest& rest, const Rails& rails, double span, double step) {
  const bool both = rails.at_low > 0 && rails.at_high > 0;
  // noise of a step and more averages the rounding out
  const double rounding = rest.Deviation() > step ? 0 : step;
  return IsBeyond(rest, span, rounding) &&
         rest.beyond <= kMostBeyond * (both ? span / 2 : span) * rest.railed;
}

// limits at the densest values of either half, of both or of one, on which there is noise
Clipping FindBelowNoise(std::span<const double> all, double all_rate_hz, double tone_hz) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const auto [samples, rate_hz] = SpreadBlocks(all, all_rate_hz);
  std::vector<double> sorted;
  std::ranges::copy_if(samples, std::back_inserter(sorted),
                       [](double x) { return !std::isnan(x); });
  std::ranges::sort(sorted);
  if (sorted.empty() || !(sorted.back() > sorted.front())) return {};
  const double span = sorted.back() - sorted.front();
  const double step = StepOf(samples);
  const double most = RailedFrom(sorted, step);
  std::vector<double> negative(sorted.rbegin(), sorted.rend());
  for (double& x : negative) x = -x;
  const double least = -RailedFrom(negative, step);
  const Fitter fitter(samples, rate_hz, tone_hz, kHighestOfAny, kTremorTerms, kModulation);
  std::optional<Rest> any;  // what the tone with its own harmonics leaves of all samples
  Clipping found;
  double best = kBetter;
  // fits to the samples off the limits; each but the first is off those of the one before
  for (const auto& [low, high] : {std::pair(least, most), {-kNever, most}, {least, kNever}}) {
    for (const int highest : {1, kHighestHarmonic}) {
      Rails rails = RailsByValue(samples, sorted, low, high);
      for (int pass = 0; pass <= kRefits; ++pass) {
        const Rest rest = fitter.Fit(rails, highest, false);
        if (!MayBeLimited(rest, rails, span, step)) break;
        if (!any) {
          any = fitter.Fit(RailsByValue(samples, sorted, -kNever, kNever), kHighestOfAny, true);
        }
        if (!any->is_determined || !(any->freedom > 0)) break;
        const double better = BetterBy(rest, *any, RoundingVariance(step, span));
        if (better > best) {
          best = better;
          found = ClippingAt(rails, ClippingVerdict::kBelowNoise);
          found.beyond = rest.beyond / rest.railed;
        }
        rails = RailsByFit(samples, rest.fitted, rails);
      }
    }
  }
  return found;
}

}  // namespace

Clipping FindClipping(std::span<const double> samples, double rate_hz, double tone_hz) {
  const Rails rails = FindRails(samples);
  const std::size_t railed = rails.at_low + rails.at_high;
  if (railed > 0 && rails.high > rails.low) {
    int highest = kHighestHarmonic;
    while (highest > 1 && 2 * highest * tone_hz >= rate_hz) --highest;
    // neither noise nor rounding gives an extreme ten times as often as any other value
    const bool only_there = railed > kTimesAsOften * MostEqual(samples, rails);
    const ClippingVerdict verdict = JudgeRails(Fitter(samples, rate_hz, tone_hz, kHighestOfAny),
                                               rails, highest, StepOf(samples), only_there);
    if (verdict != ClippingVerdict::kNone) return ClippingAt(rails, verdict);
  }
  return FindBelowNoise(samples, rate_hz, tone_hz);
}

}  // namespace haptometer::dsp
