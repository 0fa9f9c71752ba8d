#include "dsp/spectrum/ridge.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "dsp/spectrum/fft.h"

namespace haptometer::dsp {
namespace {

// bins that the ridge moves in a frame without a jump
constexpr std::size_t kMostBins = 2;
constexpr std::size_t kPadding = 4;

// the spectra of frames within a range of frequencies
class Spectra {
 public:
  Spectra(const RidgeFrames& frames, double lower_hz, double upper_hz)
      : frames_(&frames),
        window_(frames.frame(0).size()),
        fft_(std::bit_ceil(kPadding * window_.size())),
        padded_(fft_.size()),
        spectrum_(fft_.bins()) {
    for (std::size_t n = 0; n < window_.size(); ++n) {
      const double turn = 2 * std::numbers::pi * (static_cast<double>(n) + 0.5) /
                          static_cast<double>(window_.size());
      window_[n] = 0.5 - 0.5 * std::cos(turn);
    }
    bin_hz_ = frames.rate_hz / static_cast<double>(fft_.size());
    first_ = static_cast<std::size_t>(std::ceil(lower_hz / bin_hz_));
    const auto last = static_cast<std::size_t>(upper_hz / bin_hz_);
    count_ = std::min(last, fft_.bins() - 2) + 1 - first_;
  }

  [[nodiscard]] std::size_t bins() const { return count_; }
  [[nodiscard]] double FrequencyOf(double bin) const {
    return (static_cast<double>(first_) + bin) * bin_hz_;
  }

  // magnitudes of the frame `k`
  void Magnitudes(std::size_t k, std::span<double> magnitudes) {
    const std::span<const double> values = frames_->frame(k);
    // what is behind the frame stays zero
    for (std::size_t n = 0; n < values.size(); ++n) padded_[n] = window_[n] * values[n];
    fft_.Forward(padded_, spectrum_);
    for (std::size_t bin = 0; bin < count_; ++bin) {
      magnitudes[bin] = std::sqrt(std::norm(spectrum_[first_ + bin]));
    }
  }

 private:
  const RidgeFrames* frames_;
  std::vector<double> window_;
  RealFft fft_;
  std::vector<double> padded_;
  std::vector<std::complex<double>> spectrum_;
  double bin_hz_ = 0;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

// Best score of each bin after one frame more, and the bin that it came from. `score` has kMostBins
// of minus infinity at either end.
void Advance(std::span<const double> magnitudes, double largest, double bin_cost,
             std::vector<double>& score, std::vector<double>& next, std::span<std::uint16_t> from) {
  constexpr std::size_t kSteps = 2 * kMostBins + 1;
  std::array<double, kSteps> cost{};
  for (std::size_t step = 0; step < kSteps; ++step) {
    cost[step] = bin_cost * largest * std::abs(static_cast<double>(step) - double{kMostBins});
  }
  const auto highest = std::ranges::max_element(score);
  const double jump = *highest - largest;
  const auto top = static_cast<std::size_t>(highest - score.begin()) - kMostBins;
  for (std::size_t bin = 0; bin < magnitudes.size(); ++bin) {
    double best = jump;
    // origin + kMostBins, so that it is never below zero
    std::size_t origin = top + kMostBins;
    for (std::size_t step = 0; step < kSteps; ++step) {
      const double with = score[bin + step] - cost[step];
      origin = with > best ? bin + step : origin;
      best = with > best ? with : best;
    }
    next[bin + kMostBins] = best + magnitudes[bin];
    from[bin] = static_cast<std::uint16_t>(origin - kMostBins);
  }
  std::swap(score, next);
}

// bin between the neighbours at which a parabola through three logarithms is highest
double Interpolated(std::span<const double> magnitudes, std::size_t bin) {
  const auto middle = static_cast<double>(bin);
  if (bin == 0 || bin + 1 >= magnitudes.size()) return middle;
  const double tiny = std::numeric_limits<double>::min();
  const double left = std::log(magnitudes[bin - 1] + tiny);
  const double top = std::log(magnitudes[bin] + tiny);
  const double right = std::log(magnitudes[bin + 1] + tiny);
  const double bend = left - 2 * top + right;
  if (!(bend < 0)) return middle;
  return middle + std::clamp(0.5 * (left - right) / bend, -0.5, 0.5);
}

}  // namespace

std::vector<double> FindRidge(const RidgeFrames& frames, double lower_hz, double upper_hz,
                              double bin_cost) {
  if (frames.count == 0) return {};
  Spectra spectra(frames, lower_hz, upper_hz);
  const std::size_t bins = spectra.bins();
  std::vector<double> magnitudes(bins * frames.count);
  const auto of = [&](std::size_t k) { return std::span(magnitudes).subspan(k * bins, bins); };
  // the largest magnitude decides what moves cost
  double largest = 0;
  for (std::size_t k = 0; k < frames.count; ++k) {
    spectra.Magnitudes(k, of(k));
    largest = std::max(largest, *std::ranges::max_element(of(k)));
  }
  // scores with a margin in which no path begins
  std::vector<double> score(bins + 2 * kMostBins, -std::numeric_limits<double>::infinity());
  std::vector<double> next = score;
  std::fill_n(score.begin() + kMostBins, bins, 0.0);
  std::vector<std::uint16_t> from(bins * frames.count);
  for (std::size_t k = 0; k < frames.count; ++k) {
    Advance(of(k), largest, bin_cost, score, next, std::span(from).subspan(k * bins, bins));
  }
  // the path back from the best end
  auto bin = static_cast<std::size_t>(std::ranges::max_element(score) - score.begin()) - kMostBins;
  std::vector<double> ridge(frames.count);
  for (std::size_t k = frames.count; k-- > 0;) {
    ridge[k] = spectra.FrequencyOf(Interpolated(of(k), bin));
    bin = from[k * bins + bin];
  }
  return ridge;
}

}  // namespace haptometer::dsp
