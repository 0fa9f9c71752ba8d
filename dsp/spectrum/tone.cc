#include "dsp/spectrum/tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "dsp/spectrum/fft.h"
#include "dsp/spectrum/phasor_blocks.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

constexpr std::size_t kMainLobeBins = 3;  // bins on either side that a Hann peak itself fills
constexpr std::size_t kNeighbours = 64;   // bins on one side that tell the noise there
constexpr std::size_t kLeastNeighbours = 16;
// independent values behind the median of n neighbours: n / 2.08 for exponential ones. Hann's
// correlation would halve that, the noisier of two sides more than makes up for it (tests).
constexpr double kNeighboursPerValue = 2;

// squared magnitudes of the transform of `signal`, without its mean and under a Hann window
std::vector<double> HannPower(std::span<const double> signal) {
  const std::size_t n = signal.size();
  const double mean = Mean(signal);
  std::vector<double> windowed(n);
  const PhasorBlocks phasors(2 * std::numbers::pi / static_cast<double>(n));
  std::array<double, PhasorBlocks::kBlock> cosines;
  std::array<double, PhasorBlocks::kBlock> sines;
  for (std::size_t begin = 0; begin < n; begin += PhasorBlocks::kBlock) {
    const std::size_t count = std::min(PhasorBlocks::kBlock, n - begin);
    phasors.Fill(static_cast<double>(begin), std::span(cosines).first(count),
                 std::span(sines).first(count));
    for (std::size_t k = 0; k < count; ++k) {
      windowed[begin + k] = (signal[begin + k] - mean) * (0.5 - 0.5 * cosines[k]);
    }
  }
  const std::vector<std::complex<double>> bins = RealSpectrum(windowed);
  std::vector<double> power(bins.size());
  for (std::size_t k = 0; k < bins.size(); ++k) power[k] = std::norm(bins[k]);
  return power;
}

// the most of `size` samples that transform fast: a product of 2, 3, 5 and 7 only; all of a short
// signal, which costs little whatever its length
std::size_t TransformSize(std::size_t size) {
  constexpr std::size_t kShort = std::size_t{1} << 16U;
  if (size <= kShort) return size;
  for (;; --size) {
    std::size_t rest = size;
    for (const std::size_t factor : {2U, 3U, 5U, 7U}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return size;
  }
}

// the highest local maximum whose bin lies within half a bin of the band; a shoulder of something
// outside is none
std::optional<std::size_t> HighestPeak(const std::vector<double>& power, double lower_bin,
                                       double upper_bin) {
  std::optional<std::size_t> highest;
  const auto first = static_cast<std::size_t>(std::max(1.0, std::round(lower_bin)));
  for (std::size_t k = first;
       k + 1 < power.size() && static_cast<double>(k) <= std::round(upper_bin); ++k) {
    const bool peak = power[k] > 0 && power[k] >= power[k - 1] && power[k] >= power[k + 1];
    if (peak && (!highest || power[k] > power[*highest])) highest = k;
  }
  return highest;
}

// where between the bins a Hann peak at bin `k` lies: with r the ratio of the larger neighbour to
// the peak, the distance is (2 r - 1) / (r + 1)
double PeakBin(const std::vector<double>& power, std::size_t k) {
  const double before = power[k - 1];
  const double after = power[k + 1];
  const double ratio = std::sqrt(std::max(before, after) / power[k]);
  const double distance = std::clamp((2 * ratio - 1) / (ratio + 1), 0.0, 0.5);
  return static_cast<double>(k) + (after > before ? distance : -distance);
}

// the level of noise on one side of a peak: the median of power[begin, end), for exponentially
// distributed powers ln 2 of their mean
struct NoiseLevel {
  double mean = 0;
  double values = 0;  // independent ones behind it; 0: too few neighbours
};

NoiseLevel LevelOf(const std::vector<double>& power, std::size_t begin, std::size_t end) {
  if (end < begin + kLeastNeighbours) return {};
  std::vector<double> side(power.begin() + static_cast<std::ptrdiff_t>(begin),
                           power.begin() + static_cast<std::ptrdiff_t>(end));
  const auto middle = side.begin() + static_cast<std::ptrdiff_t>(side.size() / 2);
  std::ranges::nth_element(side, middle);
  return {*middle / std::numbers::ln2, static_cast<double>(side.size()) / kNeighboursPerValue};
}

// the noisier of the two sides of bin `k`; bin 0 is not asked, the mean is gone from it
NoiseLevel LevelAround(const std::vector<double>& power, std::size_t k) {
  const std::size_t left_end = k > kMainLobeBins ? k - kMainLobeBins : 1;
  const std::size_t left_begin = left_end > kNeighbours ? left_end - kNeighbours : 1;
  const std::size_t right_begin = std::min(power.size(), k + kMainLobeBins + 1);
  const std::size_t right_end = std::min(power.size(), right_begin + kNeighbours);
  const NoiseLevel left = LevelOf(power, left_begin, left_end);
  const NoiseLevel right = LevelOf(power, right_begin, right_end);
  return left.mean >= right.mean ? left : right;
}

double BinsIn(const ToneSearch& search, double duration_s) {
  return std::max(1.0, (search.upper_hz - search.lower_hz) * duration_s);
}

// whether noise hardly ever gives so high a peak in the band, by the spectrum beside it: of m
// exponential values in units of a mean that is known from v, none is above x with the probability
// 1 - m (1 + x/v)^-v
bool StandsOutOfNeighbours(double peak_power, const NoiseLevel& level, double bins,
                           double false_alarm) {
  const double v = level.values;
  return peak_power > level.mean * v * (std::pow(bins / false_alarm, 1 / v) - 1);
}

// the same by what the fit leaves, where there are too few neighbours to ask
bool StandsOutOfResidual(const SineFit& fit, double bins, double false_alarm) {
  const double u = fit.amplitude_uncertainty;
  return fit.amplitude * fit.amplitude > 2 * u * u * std::log(bins / false_alarm);
}

}  // namespace

std::optional<SineFit> StrongestTone(std::span<const double> signal, const ToneSearch& search) {
  HAPTOMETER_CHECK(search.rate_hz > 0 && search.lower_hz > 0, "rate_hz = {}, lower_hz = {}",
                   search.rate_hz, search.lower_hz);
  const auto seen = signal.first(TransformSize(signal.size()));
  const double duration_s = static_cast<double>(seen.size()) / search.rate_hz;
  const double whole_s = static_cast<double>(signal.size()) / search.rate_hz;
  if (whole_s * search.lower_hz < 2 || signal.size() > kLongestTransform) return std::nullopt;

  const std::vector<double> power = HannPower(seen);
  const std::optional<std::size_t> peak =
      HighestPeak(power, search.lower_hz * duration_s, search.upper_hz * duration_s);
  if (!peak) return std::nullopt;

  // between the bins by interpolation, then exactly by least squares
  const double start_hz = PeakBin(power, *peak) / duration_s;
  const NoiseLevel level = LevelAround(power, *peak);
  const double bins = BinsIn(search, duration_s);
  if (level.values > 0 && !StandsOutOfNeighbours(power[*peak], level, bins, search.false_alarm)) {
    return std::nullopt;
  }
  const SineFit fit = FitSine(signal, {search.rate_hz, search.noise_bandwidth_hz}, start_hz);
  const double slack_hz = 0.5 / duration_s;  // a tone on a corner may fall to either side
  const bool inside = fit.frequency_hz > search.lower_hz - slack_hz &&
                      fit.frequency_hz < search.upper_hz + slack_hz;
  if (!fit.converged || !inside) return std::nullopt;
  if (level.values == 0 && !StandsOutOfResidual(fit, bins, search.false_alarm)) {
    return std::nullopt;
  }
  return fit;
}

}  // namespace haptometer::dsp
