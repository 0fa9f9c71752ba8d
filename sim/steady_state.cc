#include "sim/steady_state.h"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "base/check.h"
#include "sim/matrix_exponential.h"

namespace haptometer::sim {

namespace {

using Complex = std::complex<double>;
using Wide = std::complex<long double>;

// M X = r with M = j w I - A in balanced units
struct PhasorSystem {
  Eigen::MatrixXcd matrix;  // (n, n)
  Eigen::VectorXcd right;   // (n)
  // what rounding left out of both (linear_model.h), or empty
  Eigen::MatrixXd matrix_rest{};
  Eigen::VectorXd right_rest{};
};

PhasorSystem SystemOf(const LinearModel& model, const BalancedMatrix& balanced,
                      const SineDrive& drive) {
  const Eigen::Index n = model.states();
  const double omega = 2 * std::numbers::pi * drive.frequency_hz;
  PhasorSystem system;
  system.matrix = Complex(0, omega) * Eigen::MatrixXcd::Identity(n, n) - balanced.matrix;
  system.right = drive.amplitude_v * model.b.cwiseQuotient(balanced.scale);
  if (model.a_rest.size() == 0) return system;
  system.matrix_rest =
      -(balanced.scale.cwiseInverse().asDiagonal() * model.a_rest * balanced.scale.asDiagonal());
  system.right_rest = drive.amplitude_v * model.b_rest.cwiseQuotient(balanced.scale);
  // the product with the amplitude was rounded too
  for (Eigen::Index k = 0; k < n; ++k) {
    system.right_rest(k) +=
        std::fma(drive.amplitude_v, model.b(k) / balanced.scale(k), -system.right(k).real());
  }
  return system;
}

Wide RestOfResidual(const PhasorSystem& system, Eigen::Index row, const Eigen::VectorXcd& x) {
  Wide sum(static_cast<long double>(system.right_rest(row)));
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    sum -= static_cast<long double>(system.matrix_rest(row, k)) * Wide(x(k));
  }
  return sum;
}

// right - matrix * x, accumulated in 64 bits so that the refinement has something to refine
Eigen::VectorXcd Residual(const PhasorSystem& system, const Eigen::VectorXcd& x) {
  Eigen::VectorXcd residual(x.size());
  for (Eigen::Index row = 0; row < x.size(); ++row) {
    Wide sum(system.right(row));
    for (Eigen::Index k = 0; k < x.size(); ++k) sum -= Wide(system.matrix(row, k)) * Wide(x(k));
    if (system.right_rest.size() > 0) sum += RestOfResidual(system, row, x);
    residual(row) = Complex(static_cast<double>(sum.real()), static_cast<double>(sum.imag()));
  }
  return residual;
}

// |M^-1| (|residual| + eps (|M| |x| + |right|)): how far each entry may be off
Eigen::VectorXd ForwardBound(const PhasorSystem& system, const Eigen::MatrixXcd& inverse,
                             const Eigen::VectorXcd& x) {
  // what the numbers themselves are worth
  const double eps = system.right_rest.size() > 0
                         ? static_cast<double>(std::numeric_limits<long double>::epsilon())
                         : std::numeric_limits<double>::epsilon();
  const Eigen::VectorXd rounding =
      eps * (system.matrix.cwiseAbs() * x.cwiseAbs() + system.right.cwiseAbs());
  return inverse.cwiseAbs() * (Residual(system, x).cwiseAbs() + rounding);
}

// the numbers that the phasors hold
void Summarise(const LinearModel& model, const SineDrive& drive, const Skin& skin,
               SteadyState& steady) {
  const Eigen::VectorXcd& x = steady.phasors;
  const double omega = 2 * std::numbers::pi * drive.frequency_hz;
  steady.current_a =
      (model.current_row.cast<Complex>() * x).value() + model.current_per_volt * drive.amplitude_v;
  const Eigen::VectorXd& mean = steady.mean;
  steady.mean_current_a = model.current_row.dot(mean) + model.current_per_volt * drive.offset_v;
  steady.mean_travel_m = mean(LinearModel::kMover) - mean(LinearModel::kCase);
  steady.mean_skin_force_n = skin.stiffness_n_per_m * mean(model.skin());
  const auto rms = [](double constant, const Complex& peak) {
    return constant == 0 ? std::abs(peak) / std::numbers::sqrt2
                         : std::hypot(constant, std::abs(peak) / std::numbers::sqrt2);
  };
  steady.skin_rms_m = rms(mean(model.skin()), x(model.skin()));
  steady.case_rms_m = rms(mean(LinearModel::kCase), x(LinearModel::kCase));
  steady.mover_peak_m =
      std::abs(steady.mean_travel_m) + std::abs(x(LinearModel::kMover) - x(LinearModel::kCase));
  steady.current_rms_a = rms(steady.mean_current_a, steady.current_a);
  steady.power_w =
      drive.offset_v * steady.mean_current_a + drive.amplitude_v * steady.current_a.real() / 2;
  steady.phase_rad =
      drive.amplitude_v < 0 ? std::arg(-steady.current_a) : std::arg(steady.current_a);
  steady.skin_force_peak_n =
      std::abs(steady.mean_skin_force_n) +
      std::abs(Complex(skin.stiffness_n_per_m, omega * skin.damping_n_s_per_m) * x(model.skin()));
}

}  // namespace

SteadyState SolveSteadyState(const LinearModel& model, const SineDrive& drive, const Skin& skin) {
  HAPTOMETER_CHECK(drive.frequency_hz > 0, "frequency_hz = {}", drive.frequency_hz);
  // balanced units, so that pivots and norms compare like with like
  const BalancedMatrix balanced = Balance(model.a);
  const PhasorSystem system = SystemOf(model, balanced, drive);

  // solve, then correct once by the residual
  const Eigen::PartialPivLU<Eigen::MatrixXcd> factors(system.matrix);
  Eigen::VectorXcd x = factors.solve(system.right);
  x += factors.solve(Residual(system, x));

  SteadyState steady;
  steady.phasors = balanced.scale.asDiagonal() * x;
  steady.mean = StaticState(model, drive.offset_v);
  Summarise(model, drive, skin, steady);

  // the skin's own bound; a singular matrix gives no number to compare with
  const Eigen::Index k = model.skin();
  const double bound = ForwardBound(system, factors.inverse(), x)(k);
  const double error = bound / std::abs(x(k));
  // nothing drives it, or it is held
  const bool silent = drive.amplitude_v == 0 || (bound == 0 && x(k) == 0.0);
  steady.error_estimate = std::isfinite(error) ? error : silent ? 0 : HUGE_VAL;
  return steady;
}

SteadyState SolveSteadyState(const Scene& scene) {
  SteadyState steady = SolveSteadyState(AssembleModel(scene), scene.drive, scene.skin);
  if (scene.drive.offset_v != 0 && !IsHeldInPlace(scene)) steady.error_estimate = HUGE_VAL;
  return steady;
}

bool IsHeldInPlace(const Scene& scene) {
  return scene.skin.stiffness_n_per_m > 0 || scene.grip.stiffness_n_per_m > 0 || scene.grip.holds;
}

Eigen::VectorXd StaticState(const LinearModel& model, double voltage_v) {
  if (voltage_v == 0) return Eigen::VectorXd::Zero(model.states());
  const BalancedMatrix balanced = Balance(model.a);
  const Eigen::VectorXd push = -voltage_v * model.b.cwiseQuotient(balanced.scale);
  const Eigen::PartialPivLU<Eigen::MatrixXd> factors(balanced.matrix);
  Eigen::VectorXd x = factors.solve(push);
  x += factors.solve(push - balanced.matrix * x);
  return balanced.scale.cwiseProduct(x);
}

double SkinRmsUncertainty(const Scene& scene) {
  constexpr double kStep = 1e-4;
  std::array<double, kActuatorSymbols.size()> gradient{};
  for (std::size_t place = 0; place < gradient.size(); ++place) {
    const auto logarithm = [&](double factor) {
      Scene moved = scene;
      moved.actuator = Scaled(scene.actuator, place, factor);
      return std::log(SolveSteadyState(moved).skin_rms_m);
    };
    gradient[place] = (logarithm(std::exp(kStep)) - logarithm(std::exp(-kStep))) / (2 * kStep);
  }
  double square = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    for (std::size_t j = 0; j < gradient.size(); ++j) {
      square += gradient[i] * scene.actuator_covariance[i][j] * gradient[j];
    }
  }
  return std::sqrt(std::max(square, 0.0));
}

}  // namespace haptometer::sim
