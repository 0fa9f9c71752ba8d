#include "sim/skin/skin.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/circular_functions.h"
#include "base/elementary_functions.h"
#include "base/error.h"

namespace haptometer::sim {

Skin SkinUnderArea(double contact_area_m2, SkinRange range) {
  HAPTOMETER_CHECK(contact_area_m2 >= kSkinAreaMinM2 && contact_area_m2 <= kSkinAreaMaxM2,
                   "contact_area_m2 = {}", contact_area_m2);
  // Lindsay 2013, section 2.1.1: both constants run with the cube root of the area
  const double Kmin = 600;
  const double Kmax = range == SkinRange::kText ? 2000 : 1200;
  const double Bmin = 0.75;
  const double Bmax = 2.38;
  static const double lower = Cbrt(kSkinAreaMinM2), upper = Cbrt(kSkinAreaMaxM2);
  const double part = (Cbrt(contact_area_m2) - lower) / (upper - lower);
  return {.stiffness_n_per_m = Kmin + (Kmax - Kmin) * part,
          .damping_n_s_per_m = Bmin + (Bmax - Bmin) * part};
}

namespace {

// distances that differ by the rounding of their coordinates are one
constexpr double kSamePart = 1e-12;

double Distance(const ReceptorPosition& position) { return Hypot(position.x_m, position.y_m); }

}  // namespace

std::size_t ReceptorsPerSide(const ReceptorField& field) {
  HAPTOMETER_CHECK(field.pad_side_m > 0 && field.density_per_m2 > 0, "{} m, {} /m2",
                   field.pad_side_m, field.density_per_m2);
  // n x n receptors at about the stated density
  const double side = std::round(field.pad_side_m * std::sqrt(field.density_per_m2));
  return std::max<std::size_t>(1, static_cast<std::size_t>(side));
}

std::vector<ReceptorPosition> ReceptorPositions(const ReceptorField& field) {
  const std::size_t n = ReceptorsPerSide(field);
  const bool to_edge = field.grid == ReceptorGrid::kEdgeToEdge && n > 1;
  // from edge to edge, or in the middles of n equal cells
  const double spacing_m = field.pad_side_m / static_cast<double>(to_edge ? n - 1 : n);
  const double middle = static_cast<double>(n - 1) / 2;
  std::vector<ReceptorPosition> positions;
  positions.reserve(n * n);
  for (std::size_t row = 0; row < n; ++row) {
    for (std::size_t column = 0; column < n; ++column) {
      positions.push_back({.x_m = (static_cast<double>(column) - middle) * spacing_m,
                           .y_m = (static_cast<double>(row) - middle) * spacing_m});
    }
  }
  return positions;
}

double StimulatedReceptors(const ReceptorField& field, double radius_m) {
  // a step's own radius, however it was rounded, is on the step
  const double slack_m = kSamePart * field.pad_side_m;
  double sum = 0;
  for (const ReceptorPosition& position : ReceptorPositions(field)) {
    const double beyond_m = Distance(position) - radius_m - field.field_radius_m;
    // soft edge: a share that falls by a normal distribution; hard edge: inside or outside
    if (field.edge_width_m > 0) {
      sum += Erfc(beyond_m / (std::numbers::sqrt2 * field.edge_width_m)) / 2;
    } else if (beyond_m <= slack_m) {
      sum += 1;
    }
  }
  return sum;
}

std::vector<double> SteppingRadii(const ReceptorField& field) {
  std::vector<double> radii;
  const auto positions = ReceptorPositions(field);
  radii.reserve(positions.size());
  for (const ReceptorPosition& position : positions) {
    radii.push_back(Distance(position) - field.field_radius_m);
  }
  std::ranges::sort(radii);
  std::vector<double> steps;
  steps.reserve(radii.size());
  for (const double radius_m : radii) {
    if (radius_m <= 0) continue;
    // receptors at equal distances are one step
    if (!steps.empty() && radius_m - steps.back() <= kSamePart * field.pad_side_m) continue;
    steps.push_back(radius_m);
  }
  return steps;
}

double SkinStimulus(const ReceptorField& field, double radius_m, double skin_rms_m) {
  return StimulatedReceptors(field, radius_m) * skin_rms_m;
}

double ContactRadius(double contact_area_m2) {
  return std::sqrt(contact_area_m2 / std::numbers::pi);
}

double ContactArea(double contact_radius_m) {
  return std::numbers::pi * contact_radius_m * contact_radius_m;
}

}  // namespace haptometer::sim
