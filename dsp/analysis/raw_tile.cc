#include "dsp/analysis/raw_tile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "dsp/analysis/tone_in_values.h"

namespace haptometer::dsp {
namespace {

constexpr double kValuesPerUpper = 8;  // kept of a period of the upper corner
constexpr double kBelow = 0.75;        // of the lower corner: motion that a tile is rid of
constexpr double kMoreDegrees = 4;     // cube roots of the half waves' degree above that
constexpr double kClearOf = 1.5;       // of the fastest motion that the polynomial takes
constexpr std::size_t kValuesPerDegree = 4;
constexpr double kLeastNorm = 0.05;  // of a step that is left: at the ends almost none is

double RateOfValues(double rate_hz, const BandPass& band) {
  return rate_hz / static_cast<double>(SamplesAValue(rate_hz, band));
}

std::size_t ValuesOf(std::size_t samples, double rate_hz, const BandPass& band) {
  return samples / SamplesAValue(rate_hz, band);
}

// d = x + 4 x^(1/3), x = pi 0.75 lower T: such a polynomial holds motion up to 0.75 lower
std::size_t DegreeOf(std::size_t samples, double rate_hz, const BandPass& band) {
  const double turns = kBelow * band.lower_hz * static_cast<double>(samples) / rate_hz;
  const double degree = std::numbers::pi * turns;
  return static_cast<std::size_t>(std::ceil(degree + kMoreDegrees * std::cbrt(degree)));
}

// means of `many` samples each, about the first sample, so that the distance costs no digits
std::vector<double> MeansOf(std::span<const double> raw, std::size_t many) {
  std::vector<double> means(raw.size() / many);
  for (std::size_t k = 0; k < means.size(); ++k) {
    double sum = 0;
    for (std::size_t i = 0; i < many; ++i) sum += raw[k * many + i] - raw[0];
    means[k] = sum / static_cast<double>(many);
  }
  return means;
}

}  // namespace

std::size_t SamplesAValue(double rate_hz, const BandPass& band) {
  return static_cast<std::size_t>(std::max(1.0, rate_hz / (kValuesPerUpper * band.upper_hz)));
}

bool TileShape::IsPossible(std::size_t samples, double rate_hz, const BandPass& band) {
  return ValuesOf(samples, rate_hz, band) >=
         kValuesPerDegree * (DegreeOf(samples, rate_hz, band) + 1);
}

TileShape::TileShape(std::size_t samples, double rate_hz, const BandPass& band)
    : samples_(samples),
      samples_a_value_(SamplesAValue(rate_hz, band)),
      rate_hz_(RateOfValues(rate_hz, band)),
      clear_hz_(
          std::max(band.lower_hz, kClearOf * static_cast<double>(DegreeOf(samples, rate_hz, band)) /
                                      (std::numbers::pi * static_cast<double>(samples) / rate_hz))),
      basis_(ValuesOf(samples, rate_hz, band), DegreeOf(samples, rate_hz, band)) {}

double RawTile::Time(std::size_t k) const { return start_s_ + static_cast<double>(k) / rate_hz(); }

Result<RawTile> RawTile::Read(const SegmentSamples& samples, std::size_t begin,
                              const TileShape& shape) {
  std::vector<double> raw(shape.samples());
  if (auto read = samples.Read(begin, raw); !read) return std::unexpected(read.error());
  RawTile tile;
  tile.shape_ = &shape;
  tile.start_s_ =
      samples.segment().start_s + static_cast<double>(begin) / samples.segment().rate_hz;
  tile.values_m_ = MeansOf(raw, shape.samples_a_value());
  shape.basis().TakeOut(tile.values_m_);
  return tile;
}

// the least-squares step at k reduces the squares by (sum of values from k on)^2 / norms[k]
bool RawTile::TakeOutStep(double least_m2) {
  const std::vector<double>& norms = shape_->basis().step_norms();
  const std::size_t n = values_m_.size();
  double sum = 0;
  double most = least_m2;
  double height = 0;
  std::size_t at = n;
  for (std::size_t k = n; k-- > 0;) {
    sum += values_m_[k];
    if (norms[k] < kLeastNorm || sum * sum <= most * norms[k]) continue;
    most = sum * sum / norms[k];
    height = sum / norms[k];
    at = k;
  }
  if (at == n) return false;
  // the step less its own polynomial, since the values have none
  std::vector<double> step(n, 0.0);
  std::fill(step.begin() + static_cast<std::ptrdiff_t>(at), step.end(), height);
  shape_->basis().TakeOut(step);
  for (std::size_t k = 0; k < n; ++k) values_m_[k] -= step[k];
  return true;
}

// the tone without the polynomial's part of it, as in the tile's values
void RawTile::TakeOutTone(double frequency_hz, double most_m) {
  Turns turns = TurnsOf(frequency_hz, rate_hz(), values_m_.size());
  shape_->basis().TakeOut(turns.cosine);
  shape_->basis().TakeOut(turns.sine);
  TakeOutNearest(turns, values_m_, most_m);
}

}  // namespace haptometer::dsp
