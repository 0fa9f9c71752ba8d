#pragma once

#include <cstddef>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/polynomial_basis.h"
#include "dsp/analysis/segments.h"
#include "dsp/filter/butterworth.h"

/// A short stretch of a segment without what lies below its band, and without a filter's edges.
namespace haptometer::dsp {

/// How many samples of `rate_hz` may be taken as one so that eight or more are left of a period of
/// the upper corner: their mean keeps 0.97 of a tone there, 0.9 of one in the middle of the band
/// above it, and what folds into the band comes from seven upper corners on, where 0.13 is left.
[[nodiscard]] std::size_t SamplesAValue(double rate_hz, const BandPass& band);

/// How the tiles of a segment are made; one for all tiles of a length.
class TileShape {
 public:
  /// Tiles of `samples` samples at `rate_hz`.
  ///
  /// The polynomial's degree is d = x + 4 x^(1/3), x = pi 0.75 lower T. A sine of n turns over T
  /// has Legendre terms up to degree pi n, and from there on they fall as Airy's function does over
  /// pi n^(1/3) degrees (Bessel functions of an order above their argument, DLMF 10.19(iii)): so
  /// the polynomial holds every motion up to 0.75 lower to about 1e-5 (of 0.8 mm at 12 Hz in the
  /// default band 10 nm are left of a tile of 0.6 s). It takes tones up to d / (pi T) along. Cost:
  /// a PolynomialBasis.
  TileShape(std::size_t samples, double rate_hz, const BandPass& band);

  [[nodiscard]] std::size_t samples() const { return samples_; }
  [[nodiscard]] std::size_t samples_a_value() const { return samples_a_value_; }
  [[nodiscard]] const PolynomialBasis& basis() const { return basis_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  /// Above are tones as they were: 1.5 d / (pi T), 32 Hz in the default band's tile of 0.6 s, where
  /// a polynomial of that degree holds 1e-3 of one at most but for the tile's ends.
  [[nodiscard]] double clear_hz() const { return clear_hz_; }

  /// Whether values are left when a polynomial of that degree is taken out: four a degree, else
  /// much of the band is gone too.
  [[nodiscard]] static bool IsPossible(std::size_t samples, double rate_hz, const BandPass& band);

 private:
  std::size_t samples_;
  std::size_t samples_a_value_;
  double rate_hz_;  // of values
  double clear_hz_;
  PolynomialBasis basis_;
};

/// Means of neighbouring samples before the filter, less the polynomial nearest to them.
class RawTile {
 public:
  /// Of samples from `begin` on; `shape` must outlive it. Errors: as RowSource::Read.
  /// Cost: 4 d flops a value.
  [[nodiscard]] static Result<RawTile> Read(const SegmentSamples& samples, std::size_t begin,
                                            const TileShape& shape);

  [[nodiscard]] const std::vector<double>& values_m() const { return values_m_; }
  [[nodiscard]] double rate_hz() const { return shape_->rate_hz(); }
  [[nodiscard]] double clear_hz() const { return shape_->clear_hz(); }
  /// In the record's time, of value `k`.
  [[nodiscard]] double Time(std::size_t k) const;

  /// Takes out the step that explains most of what is left, if that is more than `least_m2` (a sum
  /// of squares); false where it is not.
  bool TakeOutStep(double least_m2);
  /// Takes out the sine of this frequency that is nearest to what is left, if its amplitude is
  /// `most_m` at most.
  void TakeOutTone(double frequency_hz, double most_m);

 private:
  RawTile() = default;

  const TileShape* shape_ = nullptr;
  std::vector<double> values_m_;
  double start_s_ = 0;
};

}  // namespace haptometer::dsp
