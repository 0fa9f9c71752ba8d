#include "fit/impedance/impedance_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace haptometer::fit {
namespace {

using Complex = std::complex<double>;
using P = ImpedanceParameter;

// what a grid of many thousand resonances can afford
constexpr std::size_t kMostPoints = 500;

// the linear least squares of Z/|Z| over the columns 1, j w L and the resonance, all over |Z|
struct LinearShare {
  std::array<double, 3> values{};  // R, L in ohm at the middle frequency, k
  double cost = 0;
};

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

// `columns` of 1, j w / scale, admittance (2: without the resonance)
LinearShare SolveLinear(const std::vector<ImpedancePoint>& points, double scale, int columns,
                        double angular, double damping) {
  // normal equations of real unknowns; a column that is not used has the identity
  Eigen::Matrix3d normal = Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  normal.topLeftCorner(columns, columns).setZero();
  double whole = 0;
  for (const auto& point : points) {
    const double omega = Omega(point.frequency_hz);
    // residuals relative to abs(Z)
    const double weight = 1 / std::abs(point.ohm);
    Eigen::Vector3cd basis(Complex(1, 0), Complex(0, omega / scale), Complex(0, 0));
    // times g: of the order of 1 at the resonance
    if (columns > 2) basis[2] = Admittance(omega, angular, damping) * damping;
    basis *= weight;
    const Complex target = point.ohm * weight;
    for (int i = 0; i < columns; ++i) {
      right[i] += (std::conj(basis[i]) * target).real();
      for (int j = 0; j <= i; ++j) normal(i, j) += (std::conj(basis[i]) * basis[j]).real();
    }
    whole += std::norm(target);
  }
  const Eigen::Vector3d solved = normal.selfadjointView<Eigen::Lower>().ldlt().solve(right);
  LinearShare share;
  share.values = {solved[0], solved[1] / scale, columns > 2 ? solved[2] * damping : 0};
  // z'z - b'x, the residual's square sum
  share.cost = whole - solved.head(columns).dot(right.head(columns));
  return share;
}

}  // namespace

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
  start.plain_cost = start.cost = SolveLinear(picked, scale, 2, 0, 0).cost;
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
      const auto share = SolveLinear(picked, scale, 3, angular, damping);
      const auto [resistance, inductance, coupling] = share.values;
      // only a positive resistance and coupling have logarithms
      if (!(share.cost < start.cost && resistance > 0 && coupling > 0)) continue;
      start.cost = share.cost;
      start.parameters = {std::log(angular), std::log(damping), std::log(coupling),
                          std::log(resistance), inductance};
    }
  }
  if (start.parameters.empty()) return {};
  return start;
}

}  // namespace haptometer::fit
