#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "dsp/filter/butterworth.h"
#include "tests/dsp/signals.h"

namespace haptometer::dsp {

// 113 bits: on AArch64 those of long double
#ifdef __aarch64__
using Quad = long double;
#else
__extension__ typedef __float128 Quad;
#endif

// the numerator 1 + one/z + two/z^2, and what it makes of a constant 1
struct Numerator {
  int one;
  int two;
  int gain;
};

inline Numerator NumeratorOf(SectionKind kind) {
  switch (kind) {
    case SectionKind::kHighPass:
      return {-2, 1, 0};
    case SectionKind::kBandPass:
      return {0, -1, 0};
    case SectionKind::kLowPass:
      return {2, 1, 4};
  }
  return {};
}

// the same coefficients in direct form I and 113-bit arithmetic: another recursion, the same filter
inline std::vector<Quad> QuadFiltered(const FilterDesign& design, std::vector<Quad> signal,
                                      Quad constant) {
  Quad before = constant;
  for (const DeltaSection& section : design.sections) {
    const auto e = static_cast<Quad>(section.e);
    const auto f = static_cast<Quad>(section.f);
    const auto b = static_cast<Quad>(section.b);
    const auto [one, two, gain] = NumeratorOf(section.kind);
    // as if the input had been `before` for ever
    Quad x1 = before;
    Quad x2 = before;
    before = gain * before * b / e;
    Quad y1 = before;
    Quad y2 = before;
    for (Quad& value : signal) {
      const Quad x = value;
      const Quad y = b * (x + one * x1 + two * x2) - (e + f - 2) * y1 - (1 - f) * y2;
      x2 = x1;
      x1 = x;
      y2 = y1;
      y1 = y;
      value = y;
    }
  }
  return signal;
}

inline std::vector<double> QuadFiltered(const FilterDesign& design, const std::vector<double>& in,
                                        double constant) {
  const std::vector<Quad> signal =
      QuadFiltered(design, std::vector<Quad>(in.begin(), in.end()), static_cast<Quad>(constant));
  std::vector<double> out(in.size());
  for (std::size_t k = 0; k < in.size(); ++k) out[k] = static_cast<double>(signal[k]);
  return out;
}

inline double RelativeRmsError(const std::vector<double>& actual,
                               const std::vector<double>& expected, std::size_t from) {
  double error = 0;
  double power = 0;
  for (std::size_t k = from; k < actual.size(); ++k) {
    error += (actual[k] - expected[k]) * (actual[k] - expected[k]);
    power += expected[k] * expected[k];
  }
  return std::sqrt(error / power);
}

// 30 mm of distance, 0.5 mm of tremor, 1 um of vibration
inline std::vector<double> HandHeld(double rate_hz, double duration_s) {
  return Samples(rate_hz, static_cast<std::size_t>(rate_hz * duration_s), 30e-3,
                 {{0.5e-3, 8.3}, {1e-6, 100}});
}

}  // namespace haptometer::dsp
