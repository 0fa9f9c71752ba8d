#include "dsp/analysis/hum.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <optional>

#include "dsp/analysis/band_noise.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_states.h"
#include "dsp/spectrum/sine_fit.h"

namespace haptometer::dsp {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
constexpr std::size_t kBlock = PhasorBlocks::kBlock;
constexpr int kMostMultiples = 10;

// tapered windows of one length, each beginning half of it after the one before
struct Windows {
  std::span<const double> values;
  double rate_hz = 0;
  std::vector<double> weights;
  double weight_sum = 0;

  Windows(std::span<const double> all, double rate, std::size_t length)
      : values(all),
        rate_hz(rate),
        weights(BlackmanHarris(length)),
        weight_sum(std::accumulate(weights.begin(), weights.end(), 0.0)) {}

  [[nodiscard]] std::size_t length() const { return weights.size(); }
  [[nodiscard]] std::size_t step() const { return length() / 2; }
  [[nodiscard]] std::size_t count() const { return (values.size() - length()) / step() + 1; }
  [[nodiscard]] double step_s() const { return static_cast<double>(step()) / rate_hz; }

  // 2 sum w x exp(-j 2 pi f t) / sum w, t from the first value of all
  [[nodiscard]] std::complex<double> Demodulated(std::size_t k, double frequency_hz) const {
    const std::size_t first = k * step();
    const PhasorBlocks phasors(kTwoPi * frequency_hz / rate_hz);
    Eigen::ArrayXd cosines(kBlock);
    Eigen::ArrayXd sines(kBlock);
    Eigen::ArrayXd weighted(kBlock);
    std::complex<double> sum = 0;
    for (std::size_t begin = 0; begin < length(); begin += kBlock) {
      const std::size_t size = std::min(kBlock, length() - begin);
      const auto count = static_cast<Eigen::Index>(size);
      phasors.Fill(static_cast<double>(first + begin), std::span(cosines.data(), size),
                   std::span(sines.data(), size));
      weighted.head(count) = Eigen::Map<const Eigen::ArrayXd>(&weights[begin], count) *
                             Eigen::Map<const Eigen::ArrayXd>(&values[first + begin], count);
      sum += std::complex((weighted * cosines).head(count).sum(),
                          -(weighted * sines).head(count).sum());
    }
    return 2.0 * sum / weight_sum;
  }
};

// whether a line is there in every short window, but for its noise
bool IsSteady(const Windows& windows, double frequency_hz, const std::complex<double>& mean) {
  const double whole_s = static_cast<double>(windows.values.size()) / windows.rate_hz;
  const double short_s = std::max(kHumWindowS, whole_s / kHumWindows);
  const Windows shorter(
      windows.values, windows.rate_hz,
      std::min(windows.length(), static_cast<std::size_t>(short_s * windows.rate_hz)));
  const double away_hz = kReachBins * windows.rate_hz / static_cast<double>(shorter.length());
  for (std::size_t k = 0; k < shorter.count(); ++k) {
    const double noise = std::min(std::abs(shorter.Demodulated(k, frequency_hz - away_hz)),
                                  std::abs(shorter.Demodulated(k, frequency_hz + away_hz)));
    const double off = std::abs(shorter.Demodulated(k, frequency_hz) - mean);
    if (off > kSteadyWithin * std::abs(mean) + kFalseAlarmDeviations * noise) return false;
  }
  return true;
}

// a line near `frequency_hz`, if it is steady and above the noise beside it
std::optional<SteadyLine> LineNear(const Windows& windows, double frequency_hz, double tolerance) {
  // frequency: phase from window to window
  std::complex<double> product = 0;
  std::complex<double> before = windows.Demodulated(0, frequency_hz);
  for (std::size_t k = 1; k < windows.count(); ++k) {
    const std::complex<double> z = windows.Demodulated(k, frequency_hz);
    product += z * std::conj(before);
    before = z;
  }
  const double moved_hz = std::arg(product) / kTwoPi / windows.step_s();
  if (std::abs(moved_hz) > tolerance) return std::nullopt;
  const double exact_hz = frequency_hz + moved_hz;
  // the windows at that frequency, and their noise from ten bins on either side, until it is enough
  std::complex<double> mean = 0;
  for (std::size_t k = 0; k < windows.count(); ++k) {
    mean += windows.Demodulated(k, exact_hz) / static_cast<double>(windows.count());
  }
  double noise = 0;
  const double away_hz = 2 * kReachBins * windows.rate_hz / static_cast<double>(windows.length());
  for (std::size_t k = 0; k < windows.count(); ++k) {
    noise += std::min(std::abs(windows.Demodulated(k, exact_hz - away_hz)),
                      std::abs(windows.Demodulated(k, exact_hz + away_hz)));
    if (std::abs(mean) <= kClearUncertainties * noise / static_cast<double>(windows.count()))
      return std::nullopt;
  }
  return IsSteady(windows, exact_hz, mean)
             ? std::optional(SteadyLine{exact_hz, mean.real(), -mean.imag()})
             : std::nullopt;
}

}  // namespace

bool IsOfMains(double frequency_hz, double tolerance_hz) {
  return std::ranges::any_of(kMainsHz, [&](double mains_hz) {
    return frequency_hz > 0.5 * mains_hz &&
           std::abs(std::remainder(frequency_hz, mains_hz)) < tolerance_hz;
  });
}

double SteadyLine::amplitude_m() const { return std::hypot(cosine_m, sine_m); }

void SubtractLines(std::span<const SteadyLine> lines, double rate_hz, double first,
                   std::span<double> samples) {
  for (const SteadyLine& line : lines) {
    SubtractSine(kTwoPi * line.frequency_hz / rate_hz, line.cosine_m, line.sine_m, first, samples);
  }
}

Result<std::vector<SteadyLine>> FindHum(const BandSignal& signal, const BandPass& band,
                                        std::optional<double> stated_hz) {
  const KeptFrames kept = FramesToKeep(signal.size(), signal.rate_hz(), band);
  const double rate_hz = signal.rate_hz() / static_cast<double>(kept.stride);
  const std::size_t frames = (signal.size() - 1) / kept.stride + 1;
  const double duration_s = static_cast<double>(frames) / rate_hz;
  std::vector<SteadyLine> lines;
  if (duration_s < kLeastLineS || kept.frame != kept.period) return lines;
  HAPTOMETER_LET(const auto values, ReadForStates(signal, band, {}, 0, signal.size()));
  const double window_s = std::min(kLongestModelledS, duration_s / 2);
  const Windows windows(values, rate_hz, static_cast<std::size_t>(window_s * rate_hz));
  for (const double mains_hz : kMainsHz) {
    if (mains_hz < band.lower_hz || mains_hz > band.upper_hz) continue;
    if (stated_hz && std::abs(std::remainder(*stated_hz, mains_hz)) < kMainsWithinHz) continue;
    const double tolerance_hz = kMainsPart * kMainsHz.front();
    const auto fundamental = LineNear(windows, mains_hz, tolerance_hz);
    if (!fundamental) continue;
    lines.push_back(*fundamental);
    for (int order = 2; order <= kMostMultiples; ++order) {
      const double at_hz = order * fundamental->frequency_hz;
      if (at_hz > band.upper_hz) break;
      const auto line = LineNear(windows, at_hz, order * tolerance_hz);
      if (line && line->amplitude_m() <= fundamental->amplitude_m()) lines.push_back(*line);
    }
    return lines;
  }
  return lines;
}

}  // namespace haptometer::dsp
