#include "dsp/analysis/raw_tile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace haptometer::dsp {
namespace {

constexpr double kTileSamplesPerUpper = 8;  // kept of a period of the upper corner
constexpr double kBelow = 0.75;             // of the lower corner: motion that a tile is rid of
constexpr double kMoreDegrees = 12;         // than half waves in a tile
constexpr double kClearOf = 1.5;            // of the fastest motion that the polynomial takes
constexpr double kLeastNorm = 0.05;         // of a step that is left: at the ends hardly any is

// polynomials orthonormal over `size` evenly spaced samples, one degree after the other (Gram's, by
// their recurrence)
class Polynomials {
 public:
  explicit Polynomials(std::size_t size)
      : before_(size, 0.0), now_(size, 1 / std::sqrt(static_cast<double>(size))) {}

  [[nodiscard]] const std::vector<double>& now() const { return now_; }

  void Next() {
    const auto n = static_cast<double>(now_.size());
    double square = 0;
    for (std::size_t i = 0; i < now_.size(); ++i) {
      const double x = (2 * static_cast<double>(i) + 1) / n - 1;
      before_[i] = x * now_[i] - scale_ * before_[i];
      square += before_[i] * before_[i];
    }
    scale_ = std::sqrt(square);
    for (double& value : before_) value /= scale_;
    std::swap(before_, now_);
  }

 private:
  std::vector<double> before_;
  std::vector<double> now_;
  double scale_ = 0;
};

void TakeOut(const std::vector<double>& unit, std::vector<double>& values) {
  double share = 0;
  for (std::size_t i = 0; i < values.size(); ++i) share += values[i] * unit[i];
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= share * unit[i];
}

// means of `stride` samples each, from the first
std::vector<double> MeansOf(std::span<const double> raw, std::size_t stride) {
  std::vector<double> means(raw.size() / stride);
  for (std::size_t k = 0; k < means.size(); ++k) {
    double sum = 0;
    for (std::size_t i = 0; i < stride; ++i) sum += raw[k * stride + i] - raw[0];
    means[k] = sum / static_cast<double>(stride);
  }
  return means;
}

}  // namespace

double RawTile::duration_s() const { return static_cast<double>(values_m_.size()) / rate_hz_; }

bool RawTile::IsRidOfWhatLiesBelow() const { return degree_ * degree_ <= 4 * values_m_.size(); }

double RawTile::Time(std::size_t k) const { return start_s_ + static_cast<double>(k) / rate_hz_; }

Result<RawTile> RawTile::Read(const BandSignal& signal, std::size_t begin, std::size_t end,
                              const BandPass& band) {
  std::vector<double> raw(end - begin);
  if (auto read = signal.samples().Read(begin, raw); !read) return std::unexpected(read.error());
  const auto stride = static_cast<std::size_t>(
      std::max(1.0, signal.rate_hz() / (kTileSamplesPerUpper * band.upper_hz)));
  RawTile tile;
  tile.rate_hz_ = signal.rate_hz() / static_cast<double>(stride);
  tile.start_s_ = signal.start_s() + static_cast<double>(begin) / signal.rate_hz();
  tile.values_m_ = MeansOf(raw, stride);
  const double half_waves = std::numbers::pi * tile.duration_s();
  const double degree = std::ceil(half_waves * kBelow * band.lower_hz) + kMoreDegrees;
  tile.degree_ = static_cast<std::size_t>(degree);
  tile.clear_hz_ = std::max(kClearOf * degree / half_waves, band.lower_hz);
  if (tile.IsRidOfWhatLiesBelow()) tile.TakeOutPolynomial();
  return tile;
}

void RawTile::TakeOutPolynomial() {
  const std::size_t n = values_m_.size();
  step_norms_.resize(n);
  for (std::size_t k = 0; k < n; ++k) step_norms_[k] = static_cast<double>(n - k);
  Polynomials polynomials(n);
  for (std::size_t degree = 0; degree <= degree_; ++degree) {
    if (degree > 0) polynomials.Next();
    TakeOut(polynomials.now(), values_m_);
    double sum = 0;
    for (std::size_t k = n; k-- > 0;) {
      sum += polynomials.now()[k];
      step_norms_[k] -= sum * sum;
    }
  }
}

bool RawTile::TakeOutStep(double least_m2) {
  const std::size_t n = values_m_.size();
  double sum = 0;
  double most = least_m2;
  double height = 0;
  std::size_t at = n;
  for (std::size_t k = n; k-- > 0;) {
    sum += values_m_[k];
    if (step_norms_[k] < kLeastNorm || sum * sum <= most * step_norms_[k]) continue;
    most = sum * sum / step_norms_[k];
    height = sum / step_norms_[k];
    at = k;
  }
  if (at == n) return false;
  std::vector<double> step(n, 0.0);
  std::fill(step.begin() + static_cast<std::ptrdiff_t>(at), step.end(), height);
  Polynomials polynomials(n);
  for (std::size_t degree = 0; degree <= degree_; ++degree) {
    if (degree > 0) polynomials.Next();
    TakeOut(polynomials.now(), step);
  }
  for (std::size_t k = 0; k < n; ++k) values_m_[k] -= step[k];
  return true;
}

}  // namespace haptometer::dsp
