#include "fit/skin_problem.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptometer::fit {
namespace {

using P = ContactParameter;

constexpr std::size_t kMostStarts = 4;

double Wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

double Cost(const LeastSquares& problem, const std::vector<double>& at) {
  std::vector<double> residuals(problem.residuals);
  if (!problem.evaluate(at, residuals, {})) return HUGE_VAL;
  double cost = 0;
  for (const double residual : residuals) cost += residual * residual;
  return cost;
}

bool AreAlike(const std::vector<double>& a, const std::vector<double>& b) {
  constexpr double kAlike = 0.01;
  return std::abs(a[Index(P::kStiffness)] - b[Index(P::kStiffness)]) < kAlike &&
         std::abs(a[Index(P::kDamping)] - b[Index(P::kDamping)]) < kAlike;
}

}  // namespace

SkinProblem::SkinProblem(sim::Actuator actuator, DriveQuantity drive, std::vector<SkinPoint> points)
    : actuator_(actuator),
      drive_(drive),
      points_(std::move(points)),
      has_phases_(points_.front().phase_rad.has_value()),
      has_uncertainties_(points_.front().displacement_standard_uncertainty_m.has_value()) {}

std::size_t SkinProblem::Residuals() const { return points_.size() * (has_phases_ ? 2 : 1); }

bool SkinProblem::Evaluate(const sim::Actuator& actuator, std::span<const double> at,
                           std::span<double> residuals, std::span<double> jacobian) const {
  const std::vector<double> parameters(at.begin(), at.end());
  if (!(actuator.case_mass_kg + parameters[Index(P::kMass)] > 0)) return false;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    const SkinPoint& point = points_[n];
    const ContactValue model = ContactAt(actuator, drive_, parameters, point.frequency_hz);
    const double unit =
        has_uncertainties_ ? *point.displacement_standard_uncertainty_m / point.displacement_m : 1;
    residuals[n] = std::log(std::abs(model.motion) * point.drive / point.displacement_m) / unit;
    if (!std::isfinite(residuals[n])) return false;
    const std::size_t phase = n + points_.size();
    if (has_phases_) residuals[phase] = Wrapped(std::arg(model.motion) - *point.phase_rad);
    if (jacobian.empty()) continue;
    for (std::size_t k = 0; k < kContactParameters; ++k) {
      jacobian[n * kContactParameters + k] = model.logarithmic_slopes[k].real() / unit;
      if (has_phases_) {
        jacobian[phase * kContactParameters + k] = model.logarithmic_slopes[k].imag();
      }
    }
  }
  return true;
}

LeastSquares SkinProblem::Whole() const {
  return {
      Residuals(), kContactParameters,
      [this](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
        return Evaluate(actuator_, at, residuals, jacobian);
      }};
}

NoiseGroups SkinProblem::Groups() const {
  NoiseGroups groups{std::vector<std::size_t>(Residuals(), 0), {has_uncertainties_ ? 1.0 : 0.0}};
  if (!has_phases_) return groups;
  groups.least_noise.push_back(0);
  for (std::size_t n = points_.size(); n < Residuals(); ++n) groups.group_of[n] = 1;
  return groups;
}

std::vector<double> SkinProblem::ResidualsWith(const sim::Actuator& actuator,
                                               const std::vector<double>& parameters) const {
  std::vector<double> residuals(Residuals());
  const bool defined = Evaluate(actuator, parameters, residuals, {});
  if (!defined) std::ranges::fill(residuals, std::nan(""));
  return residuals;
}

std::vector<double> SkinProblem::Amplitudes(const std::vector<double>& parameters) const {
  std::vector<double> amplitudes;
  amplitudes.reserve(points_.size());
  for (const auto& point : points_) {
    const auto model = ContactAt(actuator_, drive_, parameters, point.frequency_hz);
    amplitudes.push_back(std::abs(model.motion) * point.drive);
  }
  return amplitudes;
}

void SkinProblem::TurnPhases() {
  for (auto& point : points_) point.phase_rad = Wrapped(*point.phase_rad + std::numbers::pi);
}

std::vector<SkinStart> StartSkin(const SkinProblem& problem) {
  const LeastSquares whole = problem.Whole();
  std::vector<SkinStart> cells;
  constexpr int kStiffnesses = 14;  // 10 N/m to 82 kN/m
  constexpr int kDampings = 14;     // 0.01 to 82 N s/m
  for (int k = 0; k < kStiffnesses * kDampings; ++k) {
    const double stiffness = std::ldexp(10.0, k / kDampings);
    const double damping = std::ldexp(0.01, k % kDampings);
    for (const double mass : {0.0, 1.0, 4.0, 20.0}) {
      std::vector<double> at{std::log(stiffness), std::log(damping),
                             mass * problem.actuator().case_mass_kg};
      const double cost = Cost(whole, at);
      if (std::isfinite(cost)) cells.push_back({std::move(at), cost});
    }
  }
  std::ranges::sort(cells, {}, &SkinStart::cost);
  std::vector<SkinStart> solutions;
  // the best cells of different neighbourhoods: every eighth of the best thirty-two
  constexpr std::size_t kStride = 8;
  for (std::size_t k = 0; k < cells.size() && k < kMostStarts * kStride; k += kStride) {
    SkinStart solution = cells[k];
    const auto report =
        Minimise(whole, std::vector<bool>(kContactParameters, true), &solution.parameters);
    if (!report.converged) continue;
    solution.cost = Cost(whole, solution.parameters);
    const bool known = std::ranges::any_of(solutions, [&](const SkinStart& other) {
      return AreAlike(other.parameters, solution.parameters);
    });
    if (!known) solutions.push_back(std::move(solution));
  }
  std::ranges::sort(solutions, {}, &SkinStart::cost);
  return solutions;
}

}  // namespace haptometer::fit
