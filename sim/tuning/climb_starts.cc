#include "sim/tuning/climb_starts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/tuning/adapter_grid.h"

namespace haptometer::sim {

namespace {

constexpr std::size_t kLattice = 9;

std::vector<double> MassParts(const Range& mass_kg, double case_mass_kg) {
  const Range moved{.lower = mass_kg.lower + case_mass_kg, .upper = mass_kg.upper + case_mass_kg};
  std::vector<double> parts = EqualSteps({.lower = 0, .upper = 1}, kLattice);
  if (!IsWide(moved)) return parts;
  for (double& part : parts) part = std::min(1.0, PartOf(moved, ScaledAt(moved, part)));
  return parts;
}

std::vector<double> DampingParts(const Range& damping) {
  std::vector<double> parts = EqualSteps({.lower = 0, .upper = 1}, kLattice);
  if (damping.lower > 0) return parts;
  for (std::size_t k = 1; k < kLattice; ++k) {
    parts[k] = std::ldexp(1, -3 * static_cast<int>(kLattice - 1 - k));
  }
  return parts;
}

// the x with a x^2 + 2 b x + c = 0, or where the square is nearest to 0
std::array<double, 2> RootsOf(double a, double b, double c) {
  const double square = b * b - a * c;
  if (square <= 0) return {-b / a, -b / a};
  const double sum = -(b + std::copysign(std::sqrt(square), b));
  return {sum / a, c / sum};
}

// what one place says of the ridge
struct Ridge {
  double p, Ka, e, b, q;

  [[nodiscard]] std::array<double, 2> Springs() const {
    return RootsOf(b - q, b * p, b * (p * p + (e + q) * (e + q)) - q * e * e - e * (p * p + q * q));
  }
  [[nodiscard]] std::array<double, 2> Loads() const {
    return RootsOf(b - e, b * Ka,
                   b * (Ka * Ka + (e + q) * (e + q)) - q * (Ka * Ka + e * e) - e * q * q);
  }
};

Ridge RidgeAt(const TuningProblem& problem, const MotorSource& source, const CubePlace& place) {
  const AdapterPoint point = PointOf(problem.bounds, place);
  const double w = source.omega_rad_per_s;
  const double moved_kg = source.case_mass_kg + point.adapter.motor_side_mass_kg;
  return {.p = source.stiffness_n_per_m.real() - moved_kg * w * w,
          .Ka = point.adapter.stiffness_n_per_m,
          .e = point.adapter.damping_n_s_per_m * w,
          .b = SkinOf(problem, point.contact_area_m2).damping_n_s_per_m * w,
          .q = source.stiffness_n_per_m.imag()};
}

// the value within the range; nothing to be had of a number that is none
double Within(const Range& range, double value) {
  return std::isfinite(value) ? std::clamp(value, range.lower, range.upper) : range.lower;
}

}  // namespace

std::vector<CubePlace> StartPlaces(const TuningProblem& problem, const MotorSource& source) {
  const AdapterBounds& bounds = problem.bounds;
  const CubePlace upper = UpperEndOf(problem);
  const double square = source.omega_rad_per_s * source.omega_rad_per_s;
  const std::vector<double> even = EqualSteps({.lower = 0, .upper = 1}, kLattice);
  const std::vector<double> lowest{0};
  const std::vector<double> masses = MassParts(bounds.motor_side_mass_kg, source.case_mass_kg);
  const std::vector<double> dampings = DampingParts(bounds.damping_n_s_per_m);

  std::vector<CubePlace> places = Lattice(upper, {masses, even, dampings, even});
  if (upper[1] > 0) {
    for (CubePlace place : Lattice(upper, {masses, lowest, dampings, even})) {
      for (const double Ka : RidgeAt(problem, source, place).Springs()) {
        const Range& range = bounds.stiffness_n_per_m;
        place[1] = std::clamp(ScaledPartOf(range, Within(range, Ka)), 0.0, 1.0);
        places.push_back(place);
      }
    }
  }
  if (upper[0] > 0) {
    for (CubePlace place : Lattice(upper, {lowest, even, dampings, even})) {
      for (const double p : RidgeAt(problem, source, place).Loads()) {
        const double kg = (source.stiffness_n_per_m.real() - p) / square - source.case_mass_kg;
        const Range& range = bounds.motor_side_mass_kg;
        place[0] = std::clamp(PartOf(range, Within(range, kg)), 0.0, 1.0);
        places.push_back(place);
      }
    }
  }
  return places;
}

}  // namespace haptometer::sim
