#include "dsp/spectrum/welch.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "dsp/spectrum/fft.h"
#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

struct WelchOptions;

/// Cuts overlapping segments out of a signal, detrends, windows and transforms them: what Welch's
/// spectra and spectrograms share. One plan, one buffer; one thread at a time.
class SegmentTransform {
 public:
  /// `options` as WelchSpectrum accepts them.
  explicit SegmentTransform(const WelchOptions& options);

  /// Segments that fit into `samples`.
  [[nodiscard]] std::size_t Count(std::size_t samples) const;

  /// The transform of segment `index` of `signal`, until the next call.
  [[nodiscard]] std::span<const std::complex<double>> Of(std::span<const double> signal,
                                                         std::size_t index);

  /// What turns |bin k|^2 into a one-sided density: c_k / (rate sum w^2), see WelchSpectrum.
  [[nodiscard]] double DensityScale(std::size_t bin) const;

  [[nodiscard]] std::size_t size() const { return window_.size(); }
  [[nodiscard]] std::size_t step() const { return step_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] const std::vector<double>& window() const { return window_; }

 private:
  double rate_hz_ = 0;
  Detrend detrend_;
  std::vector<double> window_;
  double window_square_sum_ = 0;
  std::size_t step_ = 1;
  RealFft fft_;
  std::vector<double> samples_;
  std::vector<std::complex<double>> bins_;
};

namespace {

using Cosines = std::array<double, 5>;  // of w[n] = sum over k of c_k cos(2 pi k n / size)

// coefficients of Heinzel, Ruediger and Schilling, appendices C and D
Cosines CosinesOf(WindowShape shape) {
  switch (shape) {
    case WindowShape::kRectangular:
      return {1, 0, 0, 0, 0};
    case WindowShape::kHann:
      return {0.5, -0.5, 0, 0, 0};
    case WindowShape::kHamming:
      return {0.54, -0.46, 0, 0, 0};
    case WindowShape::kBlackmanHarris:
      return {0.35875, -0.48829, 0.14128, -0.01168, 0};
    case WindowShape::kFlatTop:
      return {1, -1.942604, 1.340318, -0.440811, 0.043097};
  }
  HAPTOMETER_CHECK(false, "shape = {}", static_cast<int>(shape));
  return {};
}

}  // namespace

std::vector<double> WindowValues(WindowShape shape, std::size_t size) {
  HAPTOMETER_CHECK(size >= 1, "size = {}", size);
  const Cosines c = CosinesOf(shape);
  std::vector<double> values(size);
  for (std::size_t n = 0; n < size; ++n) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(n) / static_cast<double>(size);
    // from the highest cosine down: the smallest terms first
    double sum = 0;
    for (std::size_t k = c.size(); k-- > 0;) sum += c[k] * std::cos(static_cast<double>(k) * angle);
    values[n] = sum;
  }
  return values;
}

double NoiseBandwidthBins(const std::vector<double>& window) {
  // N sum(w^2) / (sum w)^2 = mean square over squared mean
  const double rms = Rms(window);
  const double mean = Mean(window);
  return rms * rms / (mean * mean);
}

namespace {

using Complex = std::complex<double>;

// Sums vectors in pairs: partial sums of 1, 2, 4 ... terms, merged like the digits of a counter.
template <typename T>
class PairwiseVectorSum {
 public:
  void Add(std::vector<T> term) {
    std::size_t level = 0;
    for (; level < partial_.size() && !partial_[level].empty(); ++level) {
      AddTo(partial_[level], term);
      partial_[level].clear();
    }
    if (level == partial_.size()) partial_.emplace_back();
    partial_[level] = std::move(term);
  }

  [[nodiscard]] std::vector<T> Total() const {
    std::vector<T> total;
    for (const std::vector<T>& partial : partial_) {
      if (partial.empty()) continue;
      if (total.empty()) {
        total = partial;
      } else {
        AddTo(partial, total);
      }
    }
    return total;
  }

 private:
  static void AddTo(const std::vector<T>& from, std::vector<T>& to) {
    for (std::size_t k = 0; k < to.size(); ++k) to[k] += from[k];
  }

  std::vector<std::vector<T>> partial_;
};

// correlation of the powers of segments `lag` samples apart: (sum w[n] w[n + lag] / sum w^2)^2
double SegmentCorrelation(const std::vector<double>& window, std::size_t lag) {
  double both = 0;
  for (std::size_t n = 0; n + lag < window.size(); ++n) both += window[n] * window[n + lag];
  const double rms = Rms(window);
  const double ratio = both / (rms * rms * static_cast<double>(window.size()));
  return ratio * ratio;
}

// resolution, bandwidth and degrees of freedom; segments that overlap share information
SpectrumGrid GridOf(const SegmentTransform& transform, std::size_t segments) {
  const auto k = static_cast<double>(segments);
  // sum over m of (1 - m/K) r_m; segments without common samples are independent
  double shared = 0;
  for (std::size_t m = 1; m < segments && m * transform.step() < transform.size(); ++m) {
    const double weight = 1 - static_cast<double>(m) / k;
    shared += weight * SegmentCorrelation(transform.window(), m * transform.step());
  }
  SpectrumGrid grid;
  grid.resolution_hz = transform.rate_hz() / static_cast<double>(transform.size());
  grid.noise_bandwidth_hz = NoiseBandwidthBins(transform.window()) * grid.resolution_hz;
  grid.segments = segments;
  // 2 K / (1 + 2 shared), then a 95 % interval of the chi-squared
  grid.degrees_of_freedom = 2 * k / (1 + 2 * shared);
  const double v = grid.degrees_of_freedom;
  grid.lower_factor = v / ChiSquareQuantile(0.975, v);
  grid.upper_factor = v / ChiSquareQuantile(0.025, v);
  return grid;
}

// sums over segments to one-sided densities
template <typename T>
void ScaleToDensity(const SegmentTransform& transform, std::size_t segments, std::vector<T>& sums) {
  for (std::size_t k = 0; k < sums.size(); ++k) {
    sums[k] *= transform.DensityScale(k) / static_cast<double>(segments);
  }
}

std::optional<Error> Refusal(std::span<const double> signal, const WelchOptions& options) {
  HAPTOMETER_CHECK(options.rate_hz > 0, "rate_hz = {}", options.rate_hz);
  const auto usage = [](std::string what, std::string remedy) {
    return Usage("spectrum", std::move(what), std::move(remedy)).error();
  };
  if (options.segment_size < 2 || options.segment_size > kLongestTransform) {
    return usage(fmt::format("a segment of {} samples", options.segment_size),
                 "choose 2 to 2^30 samples");
  }
  if (options.segment_size > signal.size()) {
    return usage(fmt::format("a segment of {} samples is longer than the signal's {}",
                             options.segment_size, signal.size()),
                 "choose a coarser resolution, or record longer");
  }
  if (!(options.overlap >= 0 && options.overlap < 1)) {
    return usage(fmt::format("an overlap of {}", options.overlap), "choose 0 to below 1");
  }
  if (!std::ranges::all_of(signal, [](double x) { return std::isfinite(x); })) {
    return usage("holds values that are not finite", "split the record there");
  }
  return std::nullopt;
}

}  // namespace

Result<PowerSpectrum> WelchSpectrum(std::span<const double> signal, const WelchOptions& options) {
  if (auto refusal = Refusal(signal, options)) return std::unexpected(std::move(*refusal));
  SegmentTransform transform(options);
  // sums in pairs: rounding grows with the logarithm of the number of segments
  PairwiseVectorSum<double> sum;
  const std::size_t segments = transform.Count(signal.size());
  for (std::size_t m = 0; m < segments; ++m) {
    const std::span<const Complex> bins = transform.Of(signal, m);
    std::vector<double> power(bins.size());
    for (std::size_t k = 0; k < bins.size(); ++k) power[k] = std::norm(bins[k]);
    sum.Add(std::move(power));
  }
  PowerSpectrum spectrum{GridOf(transform, segments), sum.Total()};
  ScaleToDensity(transform, segments, spectrum.density);
  return spectrum;
}

Result<CrossSpectrum> WelchCrossSpectrum(std::span<const double> from, std::span<const double> to,
                                         const WelchOptions& options) {
  HAPTOMETER_CHECK(from.size() == to.size(), "{} and {} samples", from.size(), to.size());
  if (auto refusal = Refusal(from, options)) return std::unexpected(std::move(*refusal));
  if (auto refusal = Refusal(to, options)) return std::unexpected(std::move(*refusal));
  SegmentTransform first(options);
  // each signal needs its own buffer: both transforms of a segment are in use at once
  SegmentTransform second(options);
  PairwiseVectorSum<Complex> cross_sum;
  PairwiseVectorSum<double> from_sum;
  PairwiseVectorSum<double> to_sum;
  const std::size_t segments = first.Count(from.size());
  for (std::size_t m = 0; m < segments; ++m) {
    const std::span<const Complex> x = first.Of(from, m);
    const std::span<const Complex> y = second.Of(to, m);
    std::vector<Complex> cross(x.size());
    std::vector<double> from_power(x.size());
    std::vector<double> to_power(x.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      // conj(X) Y: its phase is that of the second signal relative to the first
      cross[k] = std::conj(x[k]) * y[k];
      from_power[k] = std::norm(x[k]);
      to_power[k] = std::norm(y[k]);
    }
    cross_sum.Add(std::move(cross));
    from_sum.Add(std::move(from_power));
    to_sum.Add(std::move(to_power));
  }
  CrossSpectrum spectrum{GridOf(first, segments), from_sum.Total(), to_sum.Total(),
                         cross_sum.Total()};
  ScaleToDensity(first, segments, spectrum.from_density);
  ScaleToDensity(first, segments, spectrum.to_density);
  ScaleToDensity(first, segments, spectrum.cross);
  return spectrum;
}

std::vector<double> Coherence(const CrossSpectrum& spectrum) {
  std::vector<double> coherence(spectrum.cross.size());
  for (std::size_t k = 0; k < coherence.size(); ++k) {
    // without power in one signal the coherence is not defined: NaN
    const double both = spectrum.from_density[k] * spectrum.to_density[k];
    coherence[k] =
        both > 0 ? std::norm(spectrum.cross[k]) / both : std::numeric_limits<double>::quiet_NaN();
  }
  return coherence;
}

std::vector<double> AmplitudeSpectrum(const PowerSpectrum& spectrum) {
  std::vector<double> amplitude(spectrum.density.size());
  for (std::size_t k = 0; k < amplitude.size(); ++k) {
    // mean square of a tone: density times the equivalent noise bandwidth; amplitude = sqrt(2) RMS
    const double mean_square = spectrum.density[k] * spectrum.grid.noise_bandwidth_hz;
    amplitude[k] = std::sqrt(k == 0 ? mean_square : 2 * mean_square);
  }
  return amplitude;
}

double RmsWithin(const PowerSpectrum& spectrum, double lower_hz, double upper_hz) {
  std::vector<double> inside(spectrum.density.size());
  for (std::size_t k = 0; k < inside.size(); ++k) {
    // bin k covers a resolution's width about its frequency
    const double lower = lower_hz / spectrum.grid.resolution_hz - static_cast<double>(k);
    const double upper = upper_hz / spectrum.grid.resolution_hz - static_cast<double>(k);
    // share of bin k within the band, at the ends a fraction
    inside[k] = std::max(0.0, std::min(0.5, upper) - std::max(-0.5, lower)) * spectrum.density[k];
  }
  const auto bins = static_cast<double>(inside.size());
  return std::sqrt(Mean(inside) * bins * spectrum.grid.resolution_hz);
}

Result<Spectrogram> MakeSpectrogram(std::span<const double> signal, const WelchOptions& options) {
  // errors are those of the averaged spectrum, whose grid is used too
  HAPTOMETER_LET(const auto mean, WelchSpectrum(signal, options));
  SegmentTransform transform(options);
  Spectrogram result;
  result.resolution_hz = mean.grid.resolution_hz;
  result.noise_bandwidth_hz = mean.grid.noise_bandwidth_hz;
  result.start_s = 0.5 * static_cast<double>(transform.size() - 1) / options.rate_hz;
  result.step_s = static_cast<double>(transform.step()) / options.rate_hz;
  result.density.reserve(mean.grid.segments);
  for (std::size_t m = 0; m < mean.grid.segments; ++m) {
    const std::span<const std::complex<double>> bins = transform.Of(signal, m);
    std::vector<double> density(bins.size());
    for (std::size_t k = 0; k < bins.size(); ++k) {
      density[k] = std::norm(bins[k]) * transform.DensityScale(k);
    }
    result.density.push_back(std::move(density));
  }
  return result;
}

namespace {

// samples between the begins of two segments, at least 1
std::size_t StepOf(const WelchOptions& options) {
  const auto size = static_cast<double>(options.segment_size);
  const double step = std::round(size * (1 - options.overlap));
  return std::max<std::size_t>(1, static_cast<std::size_t>(step));
}

}  // namespace

SegmentTransform::SegmentTransform(const WelchOptions& options)
    : rate_hz_(options.rate_hz),
      detrend_(options.detrend),
      window_(WindowValues(options.window, options.segment_size)),
      step_(StepOf(options)),
      fft_(options.segment_size),
      samples_(options.segment_size),
      bins_(fft_.bins()) {
  const double rms = Rms(window_);
  window_square_sum_ = rms * rms * static_cast<double>(window_.size());
}

double SegmentTransform::DensityScale(std::size_t bin) const {
  // at 0 and half the rate there is no negative frequency whose power is added
  const bool alone = bin == 0 || 2 * bin == size();
  return (alone ? 1 : 2) / (rate_hz_ * window_square_sum_);
}

std::size_t SegmentTransform::Count(std::size_t samples) const {
  return samples < size() ? 0 : (samples - size()) / step_ + 1;
}

std::span<const std::complex<double>> SegmentTransform::Of(std::span<const double> signal,
                                                           std::size_t index) {
  const std::span<const double> segment = signal.subspan(index * step_, size());
  // the mean is removed before the window, which would spread an offset over the low bins
  const double mean = detrend_ == Detrend::kMean ? Mean(segment) : 0;
  for (std::size_t k = 0; k < segment.size(); ++k) samples_[k] = (segment[k] - mean) * window_[k];
  fft_.Forward(samples_, bins_);
  return bins_;
}

}  // namespace haptometer::dsp
