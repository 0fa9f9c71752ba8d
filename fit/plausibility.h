#pragma once

#include <string>
#include <vector>

#include "fit/drop_test_fit.h"

namespace haptometer::fit {

/// What about a fit is unlike any actuator, with the mistake that usually stands behind it; a
/// sentence each.
///
/// Doubted are: a resonance outside of 20-2000 Hz (times in ms or us read as s), a quality factor
/// beyond 1000, a voltage beyond 100 V or below 10 uV (mV read as V, or the reverse), a moving mass
/// outside of 10 mg-100 g and a case mass outside of 10 mg-1 kg (g read as kg), a coil outside of
/// 0.1 ohm-10 kohm, a drop from more than 1 m (mm read as m), a Km outside of 1 mN/A-100 N/A. The
/// limits are wide: LRAs ring at 50-500 Hz with Q of 2-200, weigh grams and give 10 mV to some
/// volts.
[[nodiscard]] std::vector<std::string> FindDoubts(const DropTestFit& fit,
                                                  const std::vector<ImpulseRecord>& records,
                                                  const ActuatorKnowns& knowns);

}  // namespace haptometer::fit
