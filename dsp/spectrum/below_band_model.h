#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

class Decimator;

/// A hand's tremor and drift as a sum that goes on beyond a record's ends:
///
///   m(tau) = sum over k = 0..3 of drift[k] P_k(tau) + sum over the sines of
///            cosine cos(w t) + sine sin(w t),      t from the middle of the signal
///
/// with P_k Legendre's polynomials over the signal (tau from -1 to 1).
///
/// A filter's ends are wrong by what it must guess beyond them; with 0.5 mm of tremor about a 1 um
/// tone the guess costs 0.47 s on either side. What the model explains need not be guessed: a sine
/// that goes on for ever leaves the filter multiplied by |H|^2, a cubic leaves it as 0 (each pass
/// has at least that many zeros at 0 Hz, for orders of 2 and more), and only the rest is filtered.
/// The sum is the filter's own output, for any model, as far as the motion goes on as the model
/// says; the two continuations of the rest say how far that may be wrong (dsp/filter/transient.h).
class BelowBandModel {
 public:
  struct Sine {
    double frequency_hz = 0;
    double cosine = 0;
    double sine = 0;

    [[nodiscard]] double amplitude() const;
  };

  /// Fits the cubic and up to three sines below `lower_hz`, together with up to two in-band tones
  /// (up to `upper_hz`) that are then let go, by Gauss and Newton's method; each sine starts at the
  /// strongest tone of what is left. Nothing where no tone below the band stands out, which is so
  /// for fewer than two of its periods. Where that leaves 4096 samples and a rate of 4 `upper_hz`,
  /// every n-th is fitted, behind a low-pass whose gain is divided out (dsp/spectrum/decimated.h).
  /// Steps end where what they leave is a tenth of a phase's uncertainty from noise, or after
  /// twelve. Cost: 100 flops a sample, sine and step. Memory: two copies.
  [[nodiscard]] static std::optional<BelowBandModel> Fit(std::span<const double> signal,
                                                         double rate_hz, double lower_hz,
                                                         double upper_hz);

  /// The sines, the strongest first; at least one.
  [[nodiscard]] const std::vector<Sine>& sines() const { return sines_; }

  /// Takes the model from samples [first, first + samples.size()) of the signal it was fitted to.
  void Subtract(std::size_t first, std::span<double> samples) const;

  /// Adds to filtered samples from `first` on what two passes of `design` make of the model, steady
  /// for ever.
  void AddFiltered(const FilterDesign& design, std::size_t first, std::span<double> filtered) const;

 private:
  [[nodiscard]] static std::optional<BelowBandModel> FitAll(std::span<const double> signal,
                                                            double rate_hz, double lower_hz,
                                                            double upper_hz);
  void Refer(const Decimator& decimator, std::size_t size);

  std::array<double, 4> drift_{};
  std::vector<Sine> sines_;
  double rate_hz_ = 0;
  std::size_t size_ = 0;  // of the signal
};

}  // namespace haptometer::dsp
