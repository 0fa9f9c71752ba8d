#include "sim/tuning/travel_limit.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "base/error.h"
#include "sim/tuning/bounded_climb.h"

namespace haptometer::sim {

namespace {

using Complex = std::complex<double>;

double Dot(Complex a, Complex b) { return a.real() * b.real() + a.imag() * b.imag(); }

// a y^2 + 2 b y + c, not above 0 where the limit is kept
struct Excess {
  double a = 0, b = 0, c = 0;
  [[nodiscard]] double At(double y) const { return (a * y + 2 * b) * y + c; }
};

Excess ExcessOf(const TuningProblem& problem, const MotorSource& source,
                const AdapterPoint& point) {
  const double w = source.omega_rad_per_s, T = problem.mover_limit_m;
  const Skin skin = SkinOf(problem, point.contact_area_m2);
  const Complex contact(skin.stiffness_n_per_m, skin.damping_n_s_per_m * w);
  const Complex ka(point.adapter.stiffness_n_per_m, point.adapter.damping_n_s_per_m * w);
  const double Mc1 = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  const Complex D1 = source.stiffness_n_per_m - Mc1 * w * w;
  const Complex U = 1.0 + D1 / ka;
  const Complex pushed = source.travel_per_case * source.force_n;
  const Complex Q = pushed / ka + source.free_travel_m * U;
  const Complex p = pushed + source.free_travel_m * D1 + Q * contact;
  const Complex d = D1 + U * contact;
  return {.a = std::norm(Q) - T * T * std::norm(U),
          .b = T * T * Dot(d, U) - Dot(p, Q),
          .c = std::norm(p) - T * T * std::norm(d)};
}

// real roots without cancellation
std::vector<double> RootsOf(const Excess& excess) {
  const double square = excess.b * excess.b - excess.a * excess.c;
  if (square < 0) return {};
  const double sum = -(excess.b + std::copysign(std::sqrt(square), excess.b));
  std::vector<double> roots;
  if (excess.a != 0) roots.push_back(sum / excess.a);
  if (sum != 0) roots.push_back(excess.c / sum);
  return roots;
}

}  // namespace

double WantedSkinSideMass(const TuningProblem& problem, const MotorSource& source,
                          const AdapterPoint& point) {
  const double w = source.omega_rad_per_s;
  const double Mc1 = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  const std::complex<double> D1 = source.stiffness_n_per_m - Mc1 * w * w;
  const std::complex<double> ka(point.adapter.stiffness_n_per_m,
                                point.adapter.damping_n_s_per_m * w);
  const double Ks = SkinOf(problem, point.contact_area_m2).stiffness_n_per_m;
  return (Ks + (D1 * ka / (D1 + ka)).real()) / (w * w);
}

std::optional<double> NearestWithinTravel(const TuningProblem& problem, const MotorSource& source,
                                          const AdapterPoint& point, double wanted_kg) {
  const double w = source.omega_rad_per_s;
  const Range& mass_kg = problem.bounds.skin_side_mass_kg;
  const double within_kg = std::clamp(wanted_kg, mass_kg.lower, mass_kg.upper);
  if (std::isinf(problem.mover_limit_m)) return within_kg;
  const Excess excess = ExcessOf(problem, source, point);
  if (excess.At(within_kg * w * w) <= 0) return within_kg;
  std::optional<double> nearest;
  const auto offer = [&](double kg) {
    if (!nearest || std::abs(kg - wanted_kg) < std::abs(*nearest - wanted_kg)) nearest = kg;
  };
  for (const double end_kg : {mass_kg.lower, mass_kg.upper}) {
    if (excess.At(end_kg * w * w) <= 0) offer(end_kg);
  }
  // at a root the limit is met, to rounding
  for (const double root : RootsOf(excess)) {
    const double kg = root / (w * w);
    if (kg >= mass_kg.lower && kg <= mass_kg.upper) offer(kg);
  }
  return nearest;
}

double LimitedTravelBound(Objective objective, const TuningProblem& problem,
                          const MotorSource& source, const ReceptorField& receptors) {
  HAPTOMETER_CHECK(objective != Objective::kRmsPerWatt, "{}", Name(objective));
  const double w = source.omega_rad_per_s, q = source.coupling_damping_n_per_m;
  const double F = std::abs(source.coil_force_n);
  const double T = std::min(problem.mover_limit_m, F / (2 * q));
  const double Bs = SkinOf(problem, problem.bounds.contact_area_m2.lower).damping_n_s_per_m;
  const double work_n_m = (F * T - q * T * T) * (1 + source.rounding_allowance + kKeptLimit);
  if (objective == Objective::kSkinPower) return w * work_n_m / 2;
  const double rms_m = std::sqrt(work_n_m / (w * Bs) / 2);
  if (objective == Objective::kSkinRms) return rms_m;
  return rms_m *
         StimulatedReceptors(receptors, ContactRadius(problem.bounds.contact_area_m2.upper));
}

}  // namespace haptometer::sim
