#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "sim/findings.h"
#include "sim/scene/scene.h"
#include "sim/skin/skin.h"

namespace haptometer::sim {

/// From `lower` to `upper`, both included; equal ends hold a quantity fixed.
struct Range {
  double lower = 0;
  double upper = 0;
  [[nodiscard]] double At(double part) const {
    return part >= 1 ? upper : lower + (upper - lower) * part;
  }
};

/// Where the adapter's five numbers may lie.
struct AdapterBounds {
  Range motor_side_mass_kg;  ///< Ma1 >= 0
  Range skin_side_mass_kg;   ///< Ma2 > 0
  Range stiffness_n_per_m;   ///< Ka > 0
  Range damping_n_s_per_m;   ///< Ba >= 0
  Range contact_area_m2;     ///< A, within the skin law's; of no meaning for a fixed skin
};

/// Lindsay 2013, Table 2.2: Ma1 and Ma2 0.25-10 g, Ka 2000-12000 N/m, Ba 0.01-0.1 N s/m, A 1-100
/// mm2.
[[nodiscard]] AdapterBounds ThesisBounds();

/// What is tuned: the actuator and its drive, the skin, and where the adapter may lie.
struct TuningProblem {
  Actuator actuator;
  SineDrive drive;
  SkinRange skin_range = SkinRange::kText;
  std::optional<Skin> fixed_skin{};  ///< present: the skin whatever the area, instead of the law
  AdapterBounds bounds;
  /// Skins differ: Ks and Bs may each be this part of themselves larger or smaller, from 0 up to
  /// less than 1. What is asked of an RMS then is asked of the least over all those skins.
  double skin_variation = 0;
  /// The mover's travel in its case may not exceed this, peak (sim/tuning/travel_limit.h).
  double mover_limit_m = std::numeric_limits<double>::infinity();
};

/// The thesis's search: its actuator, 5 V at 225 Hz, its bounds and its skin law.
[[nodiscard]] TuningProblem ThesisProblem();

/// An adapter and the area of its contact.
struct AdapterPoint {
  Adapter adapter;
  double contact_area_m2 = 0;
};

/// The skin under a contact of `contact_area_m2`.
[[nodiscard]] Skin SkinOf(const TuningProblem& problem, double contact_area_m2);

/// The area whose cube root lies `part` of the way between those of the ends: 0 the lower end, 1
/// the upper. Stiffness and damping of the skin are straight lines over that part.
[[nodiscard]] double AreaAt(const Range& contact_area_m2, double part);

/// The largest Bs with either end of Ks: the two skins of which one moves least, because
///
///   |Fc / Xs|^2 = t^2 ((Ks + Re Z - Ma2 w^2)^2 + (w Bs + Im Z)^2)
///
/// grows with Bs and with the distance of Ks from Ma2 w^2 - Re Z (sim/tuning/adapter_grid.h).
[[nodiscard]] std::array<Skin, 2> HardestSkins(const TuningProblem& problem,
                                               double contact_area_m2);

/// What is wrong with the bounds, or nothing.
[[nodiscard]] std::optional<FindingKind> Fault(const TuningProblem& problem);

/// Ma1, Ka, Ba, the area by AreaAt() and Ma2, each as its part of the way between its bounds; Ka
/// and Ba by their logarithms where their bounds are wide.
inline constexpr int kCubeAxes = 5;
using CubePlace = Eigen::Matrix<double, kCubeAxes, 1>;

/// The part of the way from the range's lower end to its upper at which `value` lies; 0 where they
/// are equal.
[[nodiscard]] double PartOf(const Range& range, double value);

/// Whether a range is told by its logarithm: its lower end above 0 and its upper more than 20 times
/// that. What serves best is narrow in proportion to itself: of 100 N/m to 10 MN/m a lattice even
/// over the stiffness sees one decade of five, and a step of the range's millionth is 10 N/m.
[[nodiscard]] bool IsWide(const Range& range);

/// Ka or Ba at a part of its range, and back: by the logarithm where the range is wide.
[[nodiscard]] double ScaledAt(const Range& range, double part);
[[nodiscard]] double ScaledPartOf(const Range& range, double value);

/// The adapter at a place, and the place of an adapter.
[[nodiscard]] AdapterPoint PointOf(const AdapterBounds& bounds, const CubePlace& place);
[[nodiscard]] CubePlace PlaceOf(const AdapterBounds& bounds, const AdapterPoint& point);

/// The cube's upper end: 1, and 0 where the bounds hold an axis or the skin has no area.
[[nodiscard]] CubePlace UpperEndOf(const TuningProblem& problem);

/// Every combination of the parts that are given for Ma1, Ka, Ba and the area, as far as they lie
/// below `upper`; Ma2's is 0. The area changes first.
[[nodiscard]] std::vector<CubePlace> Lattice(const CubePlace& upper,
                                             const std::array<std::vector<double>, 4>& parts);

}  // namespace haptometer::sim
