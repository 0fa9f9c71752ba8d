#include "dsp/analysis/tone_in_values.h"

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

#include "base/error.h"

namespace haptometer::dsp {
namespace {

// ratio of the determinant below which cosine and sine over the values are not separable
constexpr double kLeastDeterminant = 0.01;  // of the product of the squares

std::complex<double> TurnOf(double frequency_hz, double rate_hz) {
  return std::polar(1.0, 2 * std::numbers::pi * frequency_hz / rate_hz);
}

}  // namespace

Turns TurnsOf(double frequency_hz, double rate_hz, std::size_t size) {
  const std::complex<double> turn = TurnOf(frequency_hz, rate_hz);
  std::complex<double> phasor = 1;
  Turns turns{std::vector<double>(size), std::vector<double>(size)};
  for (std::size_t k = 0; k < size; ++k) {
    turns.cosine[k] = phasor.real();
    turns.sine[k] = phasor.imag();
    phasor *= turn;
  }
  return turns;
}

// least squares a, b of a cos + b sin from the 2 x 2 normal equations
void TakeOutNearest(const Turns& turns, std::span<double> values, double most) {
  HAPTOMETER_CHECK(turns.cosine.size() == values.size(), "{} turns, {} values", turns.cosine.size(),
                   values.size());
  double cc = 0;
  double cs = 0;
  double ss = 0;
  double cx = 0;
  double sx = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    cc += turns.cosine[k] * turns.cosine[k];
    cs += turns.cosine[k] * turns.sine[k];
    ss += turns.sine[k] * turns.sine[k];
    cx += turns.cosine[k] * values[k];
    sx += turns.sine[k] * values[k];
  }
  const double determinant = cc * ss - cs * cs;
  if (!(determinant > kLeastDeterminant * cc * ss)) return;
  const double a = (ss * cx - cs * sx) / determinant;
  const double b = (cc * sx - cs * cx) / determinant;
  // a larger amplitude than `most` is another motion: the values are kept
  if (std::hypot(a, b) > most) return;
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] -= a * turns.cosine[k] + b * turns.sine[k];
  }
}

// |2 / n sum of x exp(-j w t)|^2
double SquaredAmplitude(std::span<const double> values, double rate_hz, double frequency_hz) {
  const std::complex<double> turn = std::conj(TurnOf(frequency_hz, rate_hz));
  std::complex<double> phasor = 1;
  std::complex<double> sum = 0;
  for (const double x : values) {
    sum += x * phasor;
    phasor *= turn;
  }
  return 4 * std::norm(sum) / std::pow(static_cast<double>(values.size()), 2);
}

// running sums: the amplitude over any range by one difference
ToneSums::ToneSums(std::span<const double> values, double rate_hz, double frequency_hz) {
  const std::complex<double> turn = std::conj(TurnOf(frequency_hz, rate_hz));
  std::complex<double> phasor = 1;
  std::complex<double> sum = 0;
  sums_.reserve(values.size() + 1);
  for (const double x : values) {
    sums_.push_back(sum);
    sum += x * phasor;
    phasor *= turn;
  }
  sums_.push_back(sum);
}

double ToneSums::SquaredAmplitudeOf(std::size_t begin, std::size_t size) const {
  return 4 * std::norm(sums_[begin + size] - sums_[begin]) / std::pow(static_cast<double>(size), 2);
}

}  // namespace haptometer::dsp
