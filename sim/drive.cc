#include "sim/drive.h"

#include "base/check.h"

namespace haptometer::sim {

Drive::operator SineDrive() const {
  HAPTOMETER_CHECK(kind == DriveKind::kSine, "a drive of kind {} is no sine",
                   static_cast<int>(kind));
  return {.amplitude_v = amplitude_v, .frequency_hz = frequency_hz};
}

}  // namespace haptometer::sim
