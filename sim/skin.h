#pragma once

#include <cstdint>

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

}  // namespace haptometer::sim
