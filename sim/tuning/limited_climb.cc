#include "sim/tuning/limited_climb.h"

#include <algorithm>
#include <cmath>

#include "sim/tuning/slope.h"

namespace haptometer::sim {

namespace {

using CubeNumber = Slope<double, kCubeAxes>;

struct CubePhasor {
  CubeNumber re, im;
};
CubePhasor operator+(const CubePhasor& a, const CubePhasor& b) {
  return {a.re + b.re, a.im + b.im};
}
CubePhasor operator*(const CubePhasor& a, const CubePhasor& b) {
  return {a.re * b.re + a.im * b.im * -1.0, a.re * b.im + a.im * b.re};
}
CubePhasor operator*(const CubePhasor& a, std::complex<double> b) {
  return {a.re * b.real() + a.im * -b.imag(), a.im * b.real() + a.re * b.imag()};
}
CubeNumber Norm(const CubePhasor& z) { return z.re * z.re + z.im * z.im; }

CubeNumber On(const Range& range, const CubePlace& place, int axis) {
  return Variable<double, kCubeAxes>(place[axis], static_cast<std::size_t>(axis), 1.0) *
             (range.upper - range.lower) +
         range.lower;
}

// Ka or Ba, as ScaledAt() has them
CubeNumber ScaledOn(const Range& range, const CubePlace& place, int axis) {
  if (!IsWide(range)) return On(range, place, axis);
  const double decades = std::log(range.upper / range.lower);
  const double value = range.lower * std::exp(place[axis] * decades);
  return Variable<double, kCubeAxes>(0.0, static_cast<std::size_t>(axis), value * decades) + value;
}

CubePlace SlopesOf(const CubeNumber& number) {
  return CubePlace::Map(number.by.data()) / number.value;  // of the logarithm
}

}  // namespace

LimitedClimb::LimitedClimb(Objective objective, const TuningProblem& problem,
                           const MotorSource& source, const ReceptorField& receptors)
    : objective_(objective),
      problem_(problem),
      source_(source),
      receptors_(receptors),
      upper_(UpperEndOf(problem)) {}

double LimitedClimb::LogWeight(double part) const {
  const double area_m2 = AreaAt(problem_.bounds.contact_area_m2, part);
  return 2 * std::log(StimulatedReceptors(receptors_, ContactRadius(area_m2)));
}

LimitedView LimitedClimb::At(const CubePlace& place) const {
  const AdapterBounds& bounds = problem_.bounds;
  const double w = source_.omega_rad_per_s;
  const Skin first = SkinOf(problem_, bounds.contact_area_m2.lower);
  const Skin last = SkinOf(problem_, bounds.contact_area_m2.upper);
  const CubeNumber p = (On(bounds.motor_side_mass_kg, place, 0) + source_.case_mass_kg) * (-w * w) +
                       source_.stiffness_n_per_m.real();
  const CubePhasor D1{p, {.value = source_.stiffness_n_per_m.imag()}};
  const CubePhasor ka{ScaledOn(bounds.stiffness_n_per_m, place, 1),
                      ScaledOn(bounds.damping_n_s_per_m, place, 2) * w};
  const CubeNumber b = On({first.damping_n_s_per_m, last.damping_n_s_per_m}, place, 3) * w;
  const CubePhasor D2{On({first.stiffness_n_per_m, last.stiffness_n_per_m}, place, 3) +
                          On(bounds.skin_side_mass_kg, place, 4) * (-w * w),
                      b};

  // Xs = Fc ka / N, travel = (G (D2 + ka) + f N) / N
  const CubePhasor N = D1 * D2 + ka * (D1 + D2);
  const CubePhasor M =
      (D2 + ka) * (source_.travel_per_case * source_.force_n) + N * source_.free_travel_m;
  const CubeNumber N2 = Norm(N), M2 = Norm(M), k2 = Norm(ka);
  LimitedView view{.cost = std::log(N2.value / k2.value),
                   .excess = std::log(M2.value / N2.value) - 2 * std::log(problem_.mover_limit_m),
                   .cost_slopes = SlopesOf(N2) - SlopesOf(k2),
                   .excess_slopes = SlopesOf(M2) - SlopesOf(N2)};
  if (objective_ == Objective::kSkinPower) {
    view.cost -= std::log(b.value);
    view.cost_slopes -= SlopesOf(b);
  } else if (objective_ == Objective::kRmsPerWatt) {
    // P |N|^2 = P0 |N|^2 + Re(beta Fc (ka + D2) conj N)
    const CubePhasor moved = (D2 + ka) * (source_.power_slope_w_per_m * source_.force_n);
    const CubeNumber power = N2 * source_.blocked_power_w + moved.re * N.re + moved.im * N.im;
    view.cost += 2 * std::log(power.value / N2.value);
    view.cost_slopes += 2 * (SlopesOf(power) - SlopesOf(N2));
  } else if (objective_ == Objective::kStimulus) {
    constexpr double kStep = 1e-5;
    const double before = std::clamp(place[3] - kStep, 0.0, 1.0);
    const double after = std::clamp(place[3] + kStep, 0.0, 1.0);
    view.cost -= LogWeight(place[3]);
    if (after > before)
      view.cost_slopes[3] -= (LogWeight(after) - LogWeight(before)) / (after - before);
  }
  return view;
}

LimitedSummit LimitedClimb::From(const CubePlace& start) const {
  return ClimbWithinBounds([this](const CubePlace& place) { return At(place); }, CubePlace::Zero(),
                           upper_, start);
}

}  // namespace haptometer::sim
