#include "dsp/analysis/band_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/median.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/spectrum/fft.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

double NoisePower::degrees_of_freedom() const {
  if (!(variance > 0)) return std::numeric_limits<double>::infinity();
  return 2 * mean_square * mean_square / variance;
}

double BandNoise::DensityNear(double frequency_hz, double lower_hz, double upper_hz,
                              std::ptrdiff_t left_out) const {
  // 24 bins on either side, those next to the line excluded: 48 bins, 96 degrees of freedom
  constexpr std::ptrdiff_t kBinsOnASide = 24;
  const auto center = static_cast<std::ptrdiff_t>(std::lround(frequency_hz / bin_hz));
  const auto least = static_cast<std::ptrdiff_t>(std::ceil(lower_hz / bin_hz));
  // within the band only
  const auto most = std::min(static_cast<std::ptrdiff_t>(std::floor(upper_hz / bin_hz)),
                             static_cast<std::ptrdiff_t>(bins.size()) - 1);
  double sum = 0;
  std::size_t count = 0;
  for (std::ptrdiff_t away = left_out + 1; away <= kBinsOnASide + left_out; ++away) {
    for (const std::ptrdiff_t bin : {center - away, center + away}) {
      if (bin < least || bin > most) continue;
      sum += bins[static_cast<std::size_t>(bin)];
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<double>(count) / bin_hz : 0;
}

// p[k] = 2 |X[k]|^2 / n^2 and variance = sum of p[k]^2 / 2 (Bendat and Piersol, section 8.2)
BandNoise MeasureNoise(std::span<const double> samples, double rate_hz, double upper_hz) {
  HAPTOMETER_CHECK(samples.size() >= 2 && rate_hz > 0, "{} samples at {} Hz", samples.size(),
                   rate_hz);
  const std::span<const double> seen = samples.first(FastTransformSize(samples.size()));
  const auto n = static_cast<double>(seen.size());
  const double rms = Rms(samples);
  BandNoise noise{.power = {rms * rms, 0}, .bin_hz = rate_hz / n, .bins = {}};
  const auto spectrum = RealSpectrum(seen);
  const auto wanted = static_cast<std::size_t>(std::min(upper_hz / noise.bin_hz + 1, n / 2));
  noise.bins.resize(std::min(spectrum.size(), wanted + 1));
  for (std::size_t k = 1; k < noise.bins.size(); ++k) {
    noise.bins[k] = 2 * std::norm(spectrum[k]) / (n * n);
    noise.power.variance += 0.5 * noise.bins[k] * noise.bins[k];
  }
  noise.power.variance *= n / static_cast<double>(samples.size());  // of all samples
  return noise;
}

namespace {

// a part: so many bins, and twice as wide as a drive's sidebands, or up to this ratio; a density
// that falls as 1 / f^2 is underestimated by 4 % of itself over the ratio
constexpr double kBinsOfPart = 128;
constexpr double kPartRatio = 1.5;
constexpr double kFootFrom = 0.4;  // of the lower corner: order 6 leaves 1e-9 there
// bins of Blackman and Harris's window that noise correlates over
constexpr double kCorrelatedBins = 2.0;

// mean square of the window: 0.35875^2 + (0.48829^2 + 0.14128^2 + 0.01168^2) / 2
constexpr double kTaperPower = 0.2579635;

// both passes
double PowerGain(const FilterDesign& design, double frequency_hz) {
  return std::pow(std::norm(Response(design, frequency_hz)), 2);
}

bool LiesIn(std::span<const FrequencyRange> ranges, double at_hz) {
  return std::ranges::any_of(ranges, [at_hz](const FrequencyRange& range) {
    return at_hz >= range.from_hz && at_hz <= range.to_hz;
  });
}

// bins of noise: density behind the filter, and the filter's gain for power in both passes
struct Bin {
  double density = 0;
  double gain = 0;
};

// the bins in [from, to) that are not excluded
std::vector<Bin> BinsWithin(std::span<const std::complex<double>> spectrum, double bin_hz,
                            double to_density, const FilterDesign& design,
                            const FrequencyRange& part, std::span<const FrequencyRange> excluded) {
  std::vector<Bin> bins;
  const auto end =
      std::min(spectrum.size(), static_cast<std::size_t>(std::ceil(part.to_hz / bin_hz)));
  for (auto k = static_cast<std::size_t>(std::ceil(part.from_hz / bin_hz)); k < end; ++k) {
    const double at_hz = static_cast<double>(k) * bin_hz;
    if (!LiesIn(excluded, at_hz)) {
      bins.push_back({to_density * std::norm(spectrum[k]), PowerGain(design, at_hz)});
    }
  }
  return bins;
}

// integral of the filter's gain for power over a range, Hz
double PassedWidth(const FilterDesign& design, const FrequencyRange& range) {
  constexpr int kSteps = 16;
  const double step_hz = (range.to_hz - range.from_hz) / kSteps;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) sum += PowerGain(design, range.from_hz + (k + 0.5) * step_hz);
  return sum * step_hz;
}

// The density of exponential bins by their median, which for n of them is on average
// ln 2 + c / (2 n), and 1 / n more for the upper of the two in the middle; before the filter.
double MedianDensity(const std::vector<Bin>& of) {
  if (of.empty()) return 0;
  std::vector<double> bins;
  bins.reserve(of.size());
  for (const Bin& bin : of) bins.push_back(bin.density / bin.gain);
  const double upper = bins.size() % 2 == 0 ? 1 : 0;
  const double mean =
      std::numbers::ln2 + (0.5 * kCorrelatedBins + upper) / static_cast<double>(bins.size());
  return UpperMedian(std::move(bins)) / mean;
}

// NoiseBeside::upper_density of parts with so many bins
double UpperDensity(const NoiseBeside& noise, std::span<const std::size_t> counts,
                    const BandPass& band) {
  std::vector<double> densities;
  double bins = 0;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (2 * noise.parts[k].to_hz <= band.lower_hz + band.upper_hz) continue;
    densities.push_back(noise.densities[k]);
    bins += static_cast<double>(counts[k]);
  }
  if (!(bins > 0)) return 0;
  // a median scatters by sqrt(pi / 2) more than the mean
  const double relative = std::sqrt(0.5 * std::numbers::pi * 2.08 * kCorrelatedBins / bins);
  return Median(std::move(densities)) * std::max(0.0, 1 - relative);
}

}  // namespace

std::vector<double> BlackmanHarris(std::size_t count) {
  constexpr std::array<double, 4> kTerms{0.35875, -0.48829, 0.14128, -0.01168};
  std::vector<double> weights(count, 0.0);
  const double step = 2 * std::numbers::pi / static_cast<double>(count);
  for (std::size_t k = 0; k < kTerms.size(); ++k) {
    SubtractSine(static_cast<double>(k) * step, -kTerms[k], 0, 0.5, weights);
  }
  return weights;
}

double NoiseBeside::DensityAt(double frequency_hz) const {
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (frequency_hz < parts[k].to_hz) return densities[k];
  }
  return densities.empty() ? 0 : densities.back();
}

NoiseBeside MeasureNoiseBeside(std::span<const double> samples, double rate_hz,
                               const FilterDesign& design, const BandPass& band,
                               std::span<const FrequencyRange> excluded) {
  const auto n = static_cast<double>(samples.size());
  std::vector<double> tapered = BlackmanHarris(samples.size());
  for (std::size_t k = 0; k < tapered.size(); ++k) tapered[k] *= samples[k];
  const auto spectrum = RealSpectrum(tapered);
  const double bin_hz = rate_hz / n;
  const double to_density = 2 / (rate_hz * n * kTaperPower);  // 2 |X|^2 / (rate sum of w^2)
  NoiseBeside noise;
  std::vector<std::size_t> counts;
  double from_hz = band.lower_hz;
  while (from_hz < band.upper_hz * 0.999) {
    const double wide_hz = std::max(kBinsOfPart * bin_hz, 2 * kDriveReachHz);
    const FrequencyRange part{from_hz,
                              std::min({from_hz * kPartRatio, from_hz + wide_hz, band.upper_hz})};
    from_hz = part.to_hz;
    const std::vector<Bin> bins = BinsWithin(spectrum, bin_hz, to_density, design, part, excluded);
    noise.parts.push_back(part);
    counts.push_back(bins.size());
    noise.densities.push_back(MedianDensity(bins));
  }
  // a part that is excluded takes the density of the nearest one that is not
  const auto usable = [&](std::size_t k) { return counts[k] >= kFewest; };
  noise.is_known = std::ranges::max(counts) >= kFewest;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    if (usable(k)) continue;
    for (std::size_t away = 1; away < counts.size(); ++away) {
      const bool above = k + away < counts.size() && usable(k + away);
      const bool below = away <= k && usable(k - away);
      if (!above && !below) continue;
      noise.densities[k] = noise.densities[above ? k + away : k - away];
      counts[k] = counts[above ? k + away : k - away];
      break;
    }
  }
  // the quietest part, as dense as it may be
  noise.least_density = noise.is_known ? std::numeric_limits<double>::infinity() : 0;
  for (std::size_t k = 0; k < counts.size() && noise.is_known; ++k) {
    const double relative = std::sqrt(2.08 * kCorrelatedBins / static_cast<double>(counts[k]));
    noise.least_density =
        std::min(noise.least_density, noise.densities[k] * (1 + kFalseAlarmDeviations * relative));
  }
  noise.upper_density = UpperDensity(noise, counts, band);
  // beyond noise: motion below the corner, and what lies above it in the first part
  const FrequencyRange below{kFootFrom * band.lower_hz, band.lower_hz};
  const auto beyond_in = [&](const FrequencyRange& range) {
    double sum = 0;
    for (const Bin& bin : BinsWithin(spectrum, bin_hz, to_density, design, range, excluded)) {
      sum += (bin.density - noise.densities.front() * bin.gain) * bin_hz;
    }
    return std::max(0.0, sum);
  };
  noise.below_mean_square = beyond_in(below);
  noise.foot_mean_square = beyond_in(noise.parts.front());
  noise.power.mean_square = noise.below_mean_square;
  for (std::size_t k = 0; k < counts.size(); ++k) {
    // with the filter's skirts
    FrequencyRange passed = noise.parts[k];
    if (k == 0) passed.from_hz = below.from_hz;
    if (k + 1 == counts.size()) passed.to_hz = std::min(NoiseReachHz(band), rate_hz / 2);
    const double width_hz = PassedWidth(design, passed);
    const double power = noise.densities[k] * width_hz;
    noise.flat_mean_square += noise.least_density * width_hz;
    const auto bins = static_cast<double>(std::max<std::size_t>(counts[k], 1));
    const double relative = kCorrelatedBins / bins;
    noise.power.mean_square += power;
    noise.power.variance += 2.08 * relative * power * power;
    noise.variance_of_rest += (2.08 * relative - 1 / bins) * power * power;
  }
  return noise;
}

NoisePower BeyondNoise(const BandNoise& rest, const NoiseBeside& beside, const FilterDesign& design,
                       const BandPass& band, std::span<const FrequencyRange> drive) {
  NoisePower beyond;
  for (std::size_t k = 1; k + 1 < rest.bins.size(); ++k) {
    const double at_hz = static_cast<double>(k) * rest.bin_hz;
    if (at_hz < band.lower_hz || at_hz > band.upper_hz) continue;
    const double noise = beside.DensityAt(at_hz) * PowerGain(design, at_hz) * rest.bin_hz;
    // of a line, a^2 / 2 and what lies beside it: u^2 is the noise
    const double most = std::max({rest.bins[k - 1], rest.bins[k], rest.bins[k + 1]});
    const bool is_line = most > 0.5 * kClearUncertainties * kClearUncertainties * noise;
    if (!is_line && !LiesIn(drive, at_hz)) continue;
    beyond.mean_square += rest.bins[k] - noise;
    beyond.variance += noise * noise;
  }
  const double width = (drive.front().to_hz - drive.front().from_hz) / rest.bin_hz;
  beyond.variance *= 1 + 2.08 * kCorrelatedBins * width / kBinsOfPart;
  return beyond;
}

// weights are durations: mean = sum T m / sum T, variance = sum T^2 v / (sum T)^2
NoisePower Pooled(std::span<const WeightedPower> windows) {
  NoisePower pooled;
  double duration_s = 0;
  for (const WeightedPower& window : windows) {
    pooled.mean_square += window.duration_s * window.power.mean_square;
    pooled.variance += window.duration_s * window.duration_s * window.power.variance;
    duration_s += window.duration_s;
  }
  if (duration_s > 0) {
    pooled.mean_square /= duration_s;
    pooled.variance /= duration_s * duration_s;
  }
  return pooled;
}

ThinnedSamples Thinned(std::vector<double> filtered, double rate_hz, const FilterDesign& design,
                       const BandPass& band) {
  constexpr double kFolded = 1e-9;
  constexpr std::size_t kLeastSamples = std::size_t{1} << 12U;
  constexpr double kRatePerUpper = 5;
  std::size_t every = 1;
  const auto rate_of = [&](std::size_t n) { return rate_hz / static_cast<double>(n); };
  while (filtered.size() / (2 * every) >= kLeastSamples &&
         rate_of(2 * every) >= kRatePerUpper * band.upper_hz &&
         std::norm(Response(design, rate_of(2 * every) - NoiseReachHz(band))) <= kFolded) {
    every *= 2;
  }
  const std::size_t kept = FastTransformSize((filtered.size() + every - 1) / every);
  for (std::size_t k = 0; k < kept; ++k) filtered[k] = filtered[k * every];
  filtered.resize(kept);
  return {std::move(filtered), rate_of(every)};
}

namespace {

// the tone and its harmonics that exceed the noise; the tone alone where they cannot be fitted
std::vector<Harmonic> LinesOf(const ThinnedSamples& samples, const SineFit& tone,
                              const BandPass& band) {
  const Harmonics lines =
      FitHarmonics(samples.values_m, {samples.rate_hz, band.upper_hz - band.lower_hz, 0},
                   tone.frequency_hz, band.upper_hz);
  std::vector<Harmonic> taken;
  if (lines.converged) taken = lines.harmonics;
  std::erase_if(taken, [](const Harmonic& line) { return line.order > 1 && !line.stands_out; });
  if (taken.empty()) {
    taken.push_back({1, tone.frequency_hz, tone.amplitude, tone.amplitude_uncertainty,
                     tone.phase_rad, tone.phase_uncertainty_rad, true});
  }
  return taken;
}

}  // namespace

TonePower SplitTone(const ThinnedSamples& samples, const SineFit& tone, const BandPass& band,
                    double window_s) {
  const std::vector<Harmonic> lines = LinesOf(samples, tone, band);
  std::vector<double> rest = samples.values_m;
  for (const Harmonic& line : lines) {
    SubtractSine(2 * std::numbers::pi * line.frequency_hz / samples.rate_hz,
                 line.amplitude * std::cos(line.phase_rad),
                 -line.amplitude * std::sin(line.phase_rad), 0, rest);
  }
  TonePower split{.rest = MeasureNoise(rest, samples.rate_hz, NoiseReachHz(band))};
  // Sidebands of a modulation are no noise: they are what the window holds. They reach over an
  // eighth of the band on either side at most, and over the bin that a fit takes its share from.
  constexpr std::ptrdiff_t kLeftOut = 1;
  const double reach_hz = std::min(std::max(kDriveReachHz, kReachBins / samples.duration_s()),
                                   (band.upper_hz - band.lower_hz) / static_cast<double>(kFewest));
  const auto bins = static_cast<std::ptrdiff_t>(reach_hz / split.rest.bin_hz);
  split.density = split.rest.DensityNear(tone.frequency_hz, band.lower_hz, band.upper_hz,
                                         std::max(bins, kLeftOut));
  for (const Harmonic& line : lines) {
    // S / T: the noise's mean square in a line of width 1 / T
    const double square =
        split.rest.DensityNear(line.frequency_hz, band.lower_hz, band.upper_hz) / window_s;
    // mean square a^2 / 2 less that of the noise; Var(a^2 / 2) = a^2 u^2, u^2 = S / T
    split.mean_square += 0.5 * line.amplitude * line.amplitude - square;
    split.variance += line.amplitude * line.amplitude * square;
  }
  return split;
}

}  // namespace haptometer::dsp
