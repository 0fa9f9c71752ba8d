#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "fit/least_squares.h"
#include "fit/residuals.h"

namespace haptometer::fit {

/// One point of an impedance sweep.
struct ImpedancePoint {
  double frequency_hz = 0;         ///< > 0
  std::complex<double> ohm = 0.0;  ///< voltage over current at the terminals

  bool operator==(const ImpedancePoint&) const = default;
};

/// Takes the points that were written again and not measured again, which would narrow all
/// intervals, out of points in the order of frequency and value; returns how many.
///
/// They repeat another point to all digits, as a pattern: at least three do, and nine in ten of the
/// points that repeat a frequency, or every point. A point that was measured again differs in its
/// last digits, or by less than they show, which is no news either.
std::size_t TakeOutCopies(std::vector<ImpedancePoint>* points);

/// The parameters of an actuator's electrical impedance.
enum class ImpedanceParameter : std::uint8_t {
  kAngular,     ///< ln w0, w0^2 = Kv/M in 1/s^2
  kDamping,     ///< ln g, g = Bv/M in 1/s
  kCoupling,    ///< ln k, k = Km^2/M in N^2/(A^2 kg)
  kResistance,  ///< ln R, in ohm
  kInductance,  ///< L itself in H: noise may make it negative
};
inline constexpr std::size_t kImpedanceParameters = 5;

[[nodiscard]] constexpr std::size_t Index(ImpedanceParameter parameter) {
  return static_cast<std::size_t>(parameter);
}

/// The impedance at w = 2 pi frequency_hz and its derivatives by the parameters:
///
///     Z = R + j w L + k j w / (w0^2 - w^2 + j w g),
///
/// which is Lindsay's circuit (2013, equations 2.1-2.3) with the case held, or free with the
/// reduced mass M. Tied to the solver of sim/ by a test.
struct ImpedanceValue {
  std::complex<double> ohm;
  std::complex<double> slopes[kImpedanceParameters];
};
[[nodiscard]] ImpedanceValue ImpedanceAt(const std::vector<double>& parameters,
                                         double frequency_hz);

/// The sweep as least squares: residuals ln |Zmodel/Z| of all points, then arg(Zmodel/Z) of all.
/// `points` must outlive the problem.
[[nodiscard]] LeastSquares ImpedanceProblem(const std::vector<ImpedancePoint>& points);

/// Magnitudes are group 0, phases group 1.
[[nodiscard]] NoiseGroups ImpedanceGroups(std::size_t points);

/// A start for the fit, from a grid of resonances (to half an octave beyond the sweep) and dampings
/// (Q 0.5 to 400), with k, R and L by linear least squares.
struct ImpedanceStart {
  std::vector<double> parameters;
  double cost = 0;        ///< sum of |Zmodel/Z - 1|^2
  double plain_cost = 0;  ///< the same of the best R + j w L
};

/// Nothing where no resonance with positive R and k fits better than a coil alone. At most 500
/// points, evenly picked, are looked at. Cost: about 0.1 s.
[[nodiscard]] std::optional<ImpedanceStart> StartImpedance(
    const std::vector<ImpedancePoint>& points);

}  // namespace haptometer::fit
