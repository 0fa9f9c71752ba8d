#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "dsp/filter/butterworth.h"

namespace haptometer::dsp {

/// A design that the test knows to be possible.
inline FilterDesign Designed(const BandPass& band, double rate_hz) {
  return DesignBandPass(band, rate_hz).value();
}

/// One term of a test signal: amplitude sin(2 pi frequency t + phase).
struct Sine {
  double amplitude = 0;
  double frequency_hz = 0;
  double phase_rad = 0;
};

/// offset + sines at t = (first + k) / rate, k = 0 .. count - 1.
inline std::vector<double> Samples(double rate_hz, std::size_t count, double offset,
                                   const std::vector<Sine>& sines, double first = 0) {
  std::vector<double> values(count, offset);
  for (std::size_t k = 0; k < count; ++k) {
    const double t_s = (first + static_cast<double>(k)) / rate_hz;
    for (const Sine& sine : sines) {
      values[k] += sine.amplitude *
                   std::sin(2 * std::numbers::pi * sine.frequency_hz * t_s + sine.phase_rad);
    }
  }
  return values;
}

/// What tests/dsp/filter/scipy_reference.py filters: noise of 1 um about 1 mm from an integer
/// generator.
inline std::vector<double> ScipyInput(std::size_t count) {
  std::vector<double> values(count);
  std::uint32_t x = 1;
  for (double& value : values) {
    x = (1103515245U * x + 12345U) & 0x7fffffffU;
    value = 1e-3 + 1e-6 * (x / 2147483648.0 - 0.5);
  }
  return values;
}

/// Gaussian noise that is the same on every platform (Box-Muller on a 64-bit mixer; std's
/// distributions are not specified).
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    const double u = Uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * Uniform());
  }

 private:
  double Uniform() {  // splitmix64, (0, 1]
    state_ += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 1) * 0x1p-53;
  }
  std::uint64_t state_;
};

}  // namespace haptometer::dsp
