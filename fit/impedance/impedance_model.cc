#include "fit/impedance/impedance_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

namespace haptometer::fit {
namespace {

using Complex = std::complex<double>;
using P = ImpedanceParameter;

// what a grid of many thousand resonances can afford
constexpr std::size_t kMostPoints = 500;

double Omega(double frequency_hz) { return 2 * std::numbers::pi * frequency_hz; }

// at most kMostPoints, picked at equal distances in the order of frequency
std::vector<ImpedancePoint> Picked(const std::vector<ImpedancePoint>& points) {
  if (points.size() <= kMostPoints) return points;
  std::vector<ImpedancePoint> picked;
  picked.reserve(kMostPoints);
  for (std::size_t k = 0; k < kMostPoints; ++k) {
    picked.push_back(points[k * points.size() / kMostPoints]);
  }
  return picked;
}

// jw / (w0^2 - w^2 + j w g)
Complex Admittance(double omega, double angular, double damping) {
  return Complex(0, omega) / Complex((angular - omega) * (angular + omega), omega * damping);
}

// The linear least squares of Z/|Z| over the columns 1, j w L and k times the admittance, all over
// |Z|. What the resonance does not change is summed once for a grid of resonances.
class LinearShares {
 public:
  struct Share {
    double resistance_ohm = 0;
    double inductance_h = 0;
    double coupling = 0;  // k
    double cost = 0;      // square sum of the residuals
  };

  // the inductance's column is scaled by w / `scale`
  LinearShares(const std::vector<ImpedancePoint>& points, double scale) : scale_(scale) {
    for (const auto& point : points) {
      const double omega = Omega(point.frequency_hz);
      const double weight = 1 / std::norm(point.ohm);
      const Complex target = point.ohm * weight;
      const double scaled = omega / scale;
      terms_.push_back({omega, scaled, weight, target});
      normal_.diagonal() += Eigen::Vector3d(weight, weight * scaled * scaled, 0);
      right_ += Eigen::Vector3d(target.real(), scaled * target.imag(), 0);
    }
  }

  [[nodiscard]] Share WithoutResonance() const {
    Eigen::Matrix3d normal = normal_;
    normal(2, 2) = 1;
    return Solve(normal, right_, 0);
  }

  // the column is g times the admittance, of the order of 1 at the resonance:
  // j r / (x + j r) = (r + j x) r / (x^2 + r^2) with x = w0^2 - w^2, r = w g
  [[nodiscard]] Share With(double angular, double damping) const {
    Eigen::Matrix3d normal = normal_;
    Eigen::Vector3d right = right_;
    for (const Term& term : terms_) {
      const double x = (angular - term.omega) * (angular + term.omega);
      const double r = term.omega * damping;
      const double share = r / (x * x + r * r);
      const double real = share * r;
      const double imaginary = share * x;
      normal(2, 0) += term.weight * real;
      normal(2, 1) += term.weight * term.scaled * imaginary;
      normal(2, 2) += term.weight * (real * real + imaginary * imaginary);
      right[2] += real * term.target.real() + imaginary * term.target.imag();
    }
    return Solve(normal, right, damping);
  }

 private:
  struct Term {
    double omega = 0;
    double scaled = 0;  // w / scale
    double weight = 0;  // 1 / |Z|^2
    Complex target;     // Z / |Z|^2
  };

  [[nodiscard]] Share Solve(const Eigen::Matrix3d& normal, const Eigen::Vector3d& right,
                            double damping) const {
    const Eigen::Vector3d solved = normal.selfadjointView<Eigen::Lower>().ldlt().solve(right);
    // z'z - b'x, each |Z|/|Z| being 1
    const double cost = static_cast<double>(terms_.size()) - solved.dot(right);
    return {solved[0], solved[1] / scale_, solved[2] * damping, cost};
  }

  double scale_;
  std::vector<Term> terms_;
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

}  // namespace

std::size_t TakeOutCopies(std::vector<ImpedancePoint>* points) {
  constexpr std::size_t kLeastCopies = 3;  // fewer may be chance, and count little
  std::vector<ImpedancePoint> different;
  std::ranges::unique_copy(*points, std::back_inserter(different));
  const std::size_t copies = points->size() - different.size();
  // points with the frequency of the one before, and points that differ from both beside them
  std::size_t repeats = 0;
  std::size_t single = 0;
  for (auto point = points->begin(); point != points->end(); ++point) {
    const bool is_first = point == points->begin();
    const bool is_last = std::next(point) == points->end();
    if (!is_first && point->frequency_hz == std::prev(point)->frequency_hz) ++repeats;
    if ((is_first || *point != *std::prev(point)) && (is_last || *point != *std::next(point))) {
      ++single;
    }
  }
  if (copies < kLeastCopies || (10 * copies < 9 * repeats && single > 0)) return 0;
  *points = std::move(different);
  return copies;
}

ImpedanceValue ImpedanceAt(const std::vector<double>& parameters, double frequency_hz) {
  const double omega = Omega(frequency_hz);
  const double angular = std::exp(parameters[Index(P::kAngular)]);
  const double damping = std::exp(parameters[Index(P::kDamping)]);
  const double coupling = std::exp(parameters[Index(P::kCoupling)]);
  const double resistance = std::exp(parameters[Index(P::kResistance)]);
  const Complex admittance = Admittance(omega, angular, damping);
  const Complex motion = coupling * admittance;
  // d(1/D) = -dD/D^2, and jw/D = admittance
  const Complex per_denominator = -motion * admittance / Complex(0, omega);
  ImpedanceValue value;
  value.ohm = Complex(resistance, omega * parameters[Index(P::kInductance)]) + motion;
  value.slopes[Index(P::kAngular)] = per_denominator * (2 * angular * angular);
  value.slopes[Index(P::kDamping)] = per_denominator * Complex(0, omega * damping);
  value.slopes[Index(P::kCoupling)] = motion;
  value.slopes[Index(P::kResistance)] = resistance;
  value.slopes[Index(P::kInductance)] = Complex(0, omega);
  return value;
}

LeastSquares ImpedanceProblem(const std::vector<ImpedancePoint>& points) {
  return {2 * points.size(), kImpedanceParameters,
          [&points](std::span<const double> at, std::span<double> residuals,
                    std::span<double> jacobian) {
            const std::vector<double> parameters(at.begin(), at.end());
            for (std::size_t n = 0; n < points.size(); ++n) {
              const ImpedanceValue model = ImpedanceAt(parameters, points[n].frequency_hz);
              // ln and arg of the ratio: relative error of the magnitude, and phase error in rad
              const Complex ratio = model.ohm / points[n].ohm;
              const std::size_t phase = n + points.size();
              residuals[n] = std::log(std::abs(ratio));
              residuals[phase] = std::arg(ratio);
              if (!std::isfinite(residuals[n])) return false;
              if (jacobian.empty()) continue;
              for (std::size_t k = 0; k < kImpedanceParameters; ++k) {
                const Complex slope = model.slopes[k] / model.ohm;
                jacobian[n * kImpedanceParameters + k] = slope.real();
                jacobian[phase * kImpedanceParameters + k] = slope.imag();
              }
            }
            return true;
          }};
}

NoiseGroups ImpedanceGroups(std::size_t points) {
  NoiseGroups groups{std::vector<std::size_t>(2 * points, 0), {0.0, 0.0}};
  std::fill(groups.group_of.begin() + static_cast<std::ptrdiff_t>(points), groups.group_of.end(),
            1);
  return groups;
}

std::optional<ImpedanceStart> StartImpedance(const std::vector<ImpedancePoint>& points) {
  const auto picked = Picked(points);
  const auto [lowest, highest] =
      std::ranges::minmax(picked, {}, [](const auto& point) { return point.frequency_hz; });
  // the inductance's column is scaled at the geometric mean frequency
  const double scale = Omega(std::sqrt(lowest.frequency_hz * highest.frequency_hz));
  ImpedanceStart start;
  // cost of a coil without a resonance
  const LinearShares shares(picked, scale);
  start.plain_cost = start.cost = shares.WithoutResonance().cost;
  // factor by which the grid exceeds the sweep at either end
  constexpr double kBeyond = 1.5;
  constexpr int kResonances = 300;
  constexpr int kQualities = 10;  // 0.5 to 256
  const double first = lowest.frequency_hz / kBeyond;
  const double ratio = highest.frequency_hz * kBeyond / first;
  for (int k = 0; k < kResonances; ++k) {
    // resonances uniform in ln f, damping g = w0/Q
    const double angular = Omega(first * std::pow(ratio, k / (kResonances - 1.0)));
    for (int octave = 0; octave < kQualities; ++octave) {
      const double damping = angular / std::ldexp(0.5, octave);
      const auto [resistance, inductance, coupling, cost] = shares.With(angular, damping);
      // only a positive resistance and coupling have logarithms
      if (!(cost < start.cost && resistance > 0 && coupling > 0)) continue;
      start.cost = cost;
      start.parameters = {std::log(angular), std::log(damping), std::log(coupling),
                          std::log(resistance), inductance};
    }
  }
  if (start.parameters.empty()) return {};
  return start;
}

}  // namespace haptometer::fit
