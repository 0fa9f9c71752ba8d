#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptometer::sim {

/// The skin under the contact: a spring and a damper to ground, no mass (Lindsay 2013, eq. 2.4).
struct Skin {
  double stiffness_n_per_m = 0;  ///< Ks >= 0
  double damping_n_s_per_m = 0;  ///< Bs >= 0
};

/// Upper end of the skin's stiffness. The thesis prints two ranges and does not say which one its
/// figures use.
enum class SkinRange : std::uint8_t {
  kText,   ///< 600-2000 N/m (section 2.1.1)
  kTable,  ///< 600-1200 N/m (Table 2.1)
};

/// Contact areas that the law below covers, in m2.
inline constexpr double kSkinAreaMinM2 = 1e-6;
inline constexpr double kSkinAreaMaxM2 = 100e-6;

/// Skin under a contact of `contact_area_m2`, which must lie in [kSkinAreaMinM2, kSkinAreaMaxM2].
///
///   K(A) = Kmin + (Kmax - Kmin) (A^(1/3) - Amin^(1/3)) / (Amax^(1/3) - Amin^(1/3)),
///
/// likewise B(A) from 0.75 to 2.38 N s/m, A from 1 to 100 mm2 (Lindsay 2013, section 2.1.1).
/// Worked: 78.5 mm2 (the bare case) with kText gives 1861.7 N/m and 2.2189 N s/m; 1 mm2 gives 600
/// N/m and 0.75 N s/m with either range.
[[nodiscard]] Skin SkinUnderArea(double contact_area_m2, SkinRange range);

/// Where a grid of receptors lies on its pad. The thesis does not say which it used.
enum class ReceptorGrid : std::uint8_t {
  kCellCentred,  ///< each in the middle of its share: spacing side / n, half a spacing to the edge
  kEdgeToEdge,   ///< the outermost on the pad's edge: spacing side / (n - 1)
};

/// A square pad of fast adapting receptors, type II (FAII, Pacini), with circular receptive fields.
///
/// Defaults: Lindsay 2013, section 2.1.1: a pad of 15 mm x 15 mm, 0.22 receptors/mm2 (49.5, so 7 x
/// 7), fields of 5.7 mm radius, that is about 101 mm2.
struct ReceptorField {
  double pad_side_m = 15e-3;       ///< > 0
  double density_per_m2 = 0.22e6;  ///< > 0
  double field_radius_m = 5.7e-3;  ///< >= 0
  double edge_width_m = 0;         ///< standard deviation of a field's edge; 0: sharp
  ReceptorGrid grid = ReceptorGrid::kCellCentred;
};

/// Position of a receptor from the pad's centre.
struct ReceptorPosition {
  double x_m = 0;
  double y_m = 0;
};

/// Receptors along one side: round(side sqrt(density)), at least 1.
[[nodiscard]] std::size_t ReceptorsPerSide(const ReceptorField& field);

/// All n x n of them, row by row from the lower left.
[[nodiscard]] std::vector<ReceptorPosition> ReceptorPositions(const ReceptorField& field);

/// Nr(r): receptive fields that a round contactor of `radius_m` at the pad's centre touches.
///
/// Sharp edges count the receptors at a distance d <= r + field radius. Soft edges (ours: the
/// thesis only says that it would expect a gradual drop-off) add for each receptor the share of
/// fields that reach the contactor when field radii are normally distributed,
///
///   Nr(r) = sum over receptors of erfc((d - r - field radius) / (sqrt(2) edge width)) / 2,
///
/// which tends to the sharp count as the width goes to 0. Worked (defaults): r = 2 mm touches 37
/// (cell-centred) or 29 (edge to edge); all 49 from r = 3.3914 mm or 4.9066 mm on.
/// Cost: n^2 distances, about 0.1 us for 49.
[[nodiscard]] double StimulatedReceptors(const ReceptorField& field, double radius_m);

/// Radii at which the sharp count steps up, rising, without repeats, those above 0 only: distances
/// less the field radius. Distances within 1e-12 of the pad's side count as one.
[[nodiscard]] std::vector<double> SteppingRadii(const ReceptorField& field);

/// S = Nr(r) x RMS in m (Lindsay 2013, equation 2.7, prints mm).
[[nodiscard]] double SkinStimulus(const ReceptorField& field, double radius_m, double skin_rms_m);

/// Radius of a round contact of that area, and the other way.
[[nodiscard]] double ContactRadius(double contact_area_m2);
[[nodiscard]] double ContactArea(double contact_radius_m);

}  // namespace haptometer::sim
