#pragma once

#include "fit/impedance_fit.h"
#include "fit/impulse_record.h"

namespace haptometer::fit {

/// Adds to a finished fit the mass it refers to, what its sweep does not determine and what would,
/// and what about it is unlike an actuator, with the mistake that usually stands behind it.
///
/// Doubted are: a resonance outside of 20-2000 Hz (kHz or rad/s read as Hz) or outside of the
/// sweep, Q outside of 0.5-300, a coil outside of 0.1 ohm-10 kohm (kohm read as ohm), Km outside of
/// 1 mN/A-100 N/A, masses outside of 10 mg-100 g (case 1 kg; g read as kg), what
/// DoubtResiduals finds, and a fitted resistance that is
/// neither within 2 % nor within 3 deviations of the stated one.
///
/// @param fits_resistance whether R was fitted, not taken as stated
void AddImpedanceFindings(const ActuatorKnowns& knowns, CaseCondition condition,
                          bool fits_resistance, ImpedanceFit* fit);

}  // namespace haptometer::fit
