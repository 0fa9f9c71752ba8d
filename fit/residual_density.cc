#include "fit/residual_density.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <ranges>
#include <span>

#include "dsp/spectrum/fft.h"

namespace haptometer::fit {
namespace {

constexpr std::size_t kLeastLines = 8;
constexpr double kOneInAHundred = 2.33;  // deviations of a Gaussian

// the transform of few values is planned longer than its lines are summed up one by one
constexpr double kMostTerms = 3e5;

// |X[k]|^2 of one line, by Horner's rule
double PowerOfLine(std::span<const double> values, std::size_t line) {
  const double angle =
      2 * std::numbers::pi * static_cast<double>(line) / static_cast<double>(values.size());
  const double cosine = std::cos(angle);
  const double sine = std::sin(angle);
  double real = 0;
  double imaginary = 0;
  for (const double value : std::views::reverse(values)) {
    const double turned = real * cosine + imaginary * sine + value;
    imaginary = imaginary * cosine - real * sine;
    real = turned;
  }
  return real * real + imaginary * imaginary;
}

// mean |X[k]|^2 of the lines from `first` to before `end`, and of all but the line at 0
struct MeanPowers {
  double band = 0;
  double whole = 0;
};

MeanPowers PowersByTransform(const std::vector<double>& values, std::size_t first,
                             std::size_t end) {
  const auto lines = dsp::RealSpectrum(values);
  const auto mean = [](std::span<const std::complex<double>> some) {
    double sum = 0;
    for (const auto& line : some) sum += std::norm(line);
    return sum / static_cast<double>(some.size());
  };
  const std::span all(lines);
  return {mean(all.subspan(first, end - first)), mean(all.subspan(1))};
}

// the band line by line, the whole by Parseval's theorem
MeanPowers PowersByLine(const std::vector<double>& values, std::size_t first, std::size_t end) {
  MeanPowers powers;
  for (std::size_t line = first; line < end; ++line) powers.band += PowerOfLine(values, line);
  powers.band /= static_cast<double>(end - first);
  double squares = 0;
  double sum = 0;
  double alternating = 0;
  double sign = 1;
  for (const double value : values) {
    squares += value * value;
    sum += value;
    alternating += sign * value;
    sign = -sign;
  }
  const auto count = static_cast<double>(values.size());
  const bool is_even = values.size() % 2 == 0;
  const double highest = is_even ? alternating * alternating : 0;  // has no mirror image
  powers.whole = (count * squares - sum * sum + highest) / 2 / std::floor(count / 2);
  return powers;
}

}  // namespace

ResidualDensity DensityAt(const std::vector<double>& residuals, double step_s,
                          double resonance_hz) {
  if (residuals.size() < 2 * kLeastLines) return {};
  const double lines_per_hz = static_cast<double>(residuals.size()) * step_s;
  const auto first = static_cast<std::size_t>(std::ceil(0.5 * resonance_hz * lines_per_hz));
  const auto end = static_cast<std::size_t>(1.5 * resonance_hz * lines_per_hz) + 1;
  // the offset takes the line at 0
  if (first < 1 || end > residuals.size() / 2 + 1 || end < first + kLeastLines) return {};
  const double terms = static_cast<double>(end - first) * static_cast<double>(residuals.size());
  const MeanPowers powers = terms < kMostTerms ? PowersByLine(residuals, first, end)
                                               : PowersByTransform(residuals, first, end);
  if (!(powers.whole > 0)) return {};
  ResidualDensity density;
  density.ratio = powers.band / powers.whole;
  const double deviation = 1 / std::sqrt(static_cast<double>(end - first));
  density.is_coloured = density.ratio > 1 + kOneInAHundred * deviation;
  return density;
}

}  // namespace haptometer::fit
