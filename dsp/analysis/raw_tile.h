#pragma once

#include <cstddef>
#include <vector>

#include "base/result.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/filter/butterworth.h"

/// A short stretch of a signal without what lies below its band, and without a filter's edges.
namespace haptometer::dsp {

/// Means of neighbouring samples before the filter, as few as hold the band (8 a period of its
/// upper corner or more), less the polynomial nearest to them.
///
/// Its degree is d = pi 0.75 lower T + 12: it holds every motion up to 0.75 lower (of 0.8 mm at 12
/// Hz in the default band 10 nm are left of a tile of 0.6 s) and takes tones up to d / (pi T)
/// along.
class RawTile {
 public:
  /// Of samples [begin, end) of `signal`. Errors: as RowSource::Read. Cost: 4 d flops a sample.
  [[nodiscard]] static Result<RawTile> Read(const BandSignal& signal, std::size_t begin,
                                            std::size_t end, const BandPass& band);

  [[nodiscard]] const std::vector<double>& values_m() const { return values_m_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] double duration_s() const;
  /// Whether there are values enough for a polynomial of that degree: (d / 2)^2. With fewer Gram's
  /// recurrence loses its digits, and nothing is taken out.
  [[nodiscard]] bool IsRidOfWhatLiesBelow() const;
  /// In the record's time, of value `k`.
  [[nodiscard]] double Time(std::size_t k) const;
  /// Above are tones as they were: 1.5 d / (pi T), 31 Hz in the default band's tile of 0.6 s.
  [[nodiscard]] double clear_hz() const { return clear_hz_; }

  /// Takes out the step that explains most of what is left, if that is more than `least_m2` (a sum
  /// of squares); false where it is not.
  bool TakeOutStep(double least_m2);

 private:
  RawTile() = default;
  void TakeOutPolynomial();

  std::vector<double> values_m_;
  std::vector<double> step_norms_;  // sum of squares of what the polynomial leaves of a step at k
  std::size_t degree_ = 0;
  double rate_hz_ = 0;
  double start_s_ = 0;
  double clear_hz_ = 0;
};

}  // namespace haptometer::dsp
