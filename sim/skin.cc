#include "sim/skin.h"

#include <cmath>

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
  const double lower = std::cbrt(kSkinAreaMinM2);
  const double part = (std::cbrt(contact_area_m2) - lower) / (std::cbrt(kSkinAreaMaxM2) - lower);
  return {.stiffness_n_per_m = Kmin + (Kmax - Kmin) * part,
          .damping_n_s_per_m = Bmin + (Bmax - Bmin) * part};
}

}  // namespace haptometer::sim
