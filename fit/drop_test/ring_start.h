#pragma once

#include <cstddef>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/poles.h"

namespace haptometer::fit {

/// Where a record's ring-down begins and what it looks like: start values for the fit.
struct RingStart {
  double quiet_noise_v = 0;       ///< RMS about the mean of what precedes the blow; 0: nothing does
  std::size_t quiet_samples = 0;  ///< samples certainly before the blow
  double blow_s = 0;              ///< of the first sample behind the blow
  std::size_t first_sample = 0;   ///< the fit begins here, an eighth of a period behind the blow
  PolePair poles;                 ///< with the record's own load
  double impact_s = 0;          ///< when the motion, continued backwards, starts from rest at x = 0
  double impact_voltage_v = 0;  ///< the ring-down's voltage at that instant, signed, without offset
  double release_s = 0;         ///< the ring-down's zero that is nearest to the blow
  double release_slope_v_per_s = 0;  ///< its slope there
  /// How long the impact may last (95 %), as a half sine of force: see WriteContact in
  /// ring_start.cc. Both 0: not looked for, because no drop height is stated or nothing quiet
  /// precedes the blow.
  double shortest_contact_s = 0;  ///< 0: no sample shows that the blow lasts
  double longest_contact_s = 0;
  bool contact_may_be_longer = false;  ///< no length that was tried is too long for the samples
  double offset_v = 0;
  double residual_rms_v = 0;  ///< of the fit by this pole pair, from first_sample on
};

/// Finds the blow in a record and the start values of its ring-down.
///
/// The blow is the sample that best parts a quiet stretch from the ring-down (least squares over
/// the two periods around the amplitude's rise; between the quality factors 1 and 4.5 with a
/// ring-down of one decay rate fitted to what follows each), for a motion without oscillation the
/// first sample beyond half of the largest distance from the median. What lies well before it is
/// quiet and gives the noise; a record that begins with the blow has none.
/// A slow course or a hum of the ring-down's own size hides it: where such parts last
/// (fit/drop_test/first_look.h), the record is tried without them too, and the start that explains
/// more of quiet part and ring-down is taken. Noise, offset and residual are then without them.
/// From an eighth of a period behind the blow (contact lasts that long, and the coil's current has
/// settled) the poles are estimated (poles.h) and amplitude, phase and offset follow by linear
/// least squares. The impact is the zero of the motion nearest to the blow.
///
/// The poles are refined by ring_fit.h on blocks of a sixteenth of a period.
///
/// Beyond 0.7 of critical damping they come from a grid of natural frequencies and dampings,
/// because the pencil sees the slow decay alone.
///
/// Cost: a spectrum and two pencils, some ms; ten times that for the grid.
/// Errors (Cause::kCannotAnswer, named by the record): fewer than 32 samples or 2 periods behind
/// the blow, fewer than 5 samples a period, a constant record, an oscillation too weak to carry a
/// fit (energy over noise density rho = A^2/(4 d dt s^2) below 50, where the decay rate alone is
/// uncertain to 28 %).
[[nodiscard]] Result<RingStart> FindRingStart(const ImpulseRecord& record);

}  // namespace haptometer::fit
