#pragma once

#include "acquire/emulator/device.h"
#include "trial/sensor_head.h"

namespace haptometer::acquire::emulator {

/// An IL-030 without noise and averaging that looks at `displacement`, so that every reading is
/// known.
inline MovingHead QuietHead(trial::Displacement displacement, const char* name = "IL-030") {
  MovingHead head{.head = trial::Il030(), .displacement = std::move(displacement)};
  head.head.name = name;
  head.head.noise_rms_m = 0;
  head.head.averages = 1;
  return head;
}

/// The same at rest.
inline MovingHead StillHead(double position_m, const char* name = "IL-030") {
  return QuietHead([position_m](double) { return position_m; }, name);
}

}  // namespace haptometer::acquire::emulator
