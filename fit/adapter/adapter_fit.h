#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/quantity.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/residuals.h"
#include "trial/record.h"

namespace haptometer::fit {

/// How one tap was read and met.
struct FittedTap {
  std::string name;
  double first_s = 0;  ///< of the fitted part, on the record's own time axis
  double end_s = 0;
  std::size_t samples = 0;          ///< fitted, after averaging to 32 a period where there are more
  double natural_frequency_hz = 0;  ///< sqrt(q)/2pi of s^2 + 2 d s + q
  double decay_per_s = 0;           ///< d
  double amplitude = 0;             ///< of the ringing where the fitted part begins
  double residual_rms = 0;
  std::string unit;         ///< of the two above
  ResidualDensity density;  ///< of the residuals at the resonance
  Findings found;           ///< later impacts, hum, drift, tail, and what is done
};

/// What one or several ring-downs of a tapped adapter say of its spring and damper.
struct AdapterFit {
  FittedValue stiffness;            ///< Ka, N/m
  FittedValue damping;              ///< Ba, N s/m
  FittedValue natural_frequency;    ///< sqrt(Ka/M)/2pi, Hz
  FittedValue quality_factor;       ///< sqrt(Ka M)/Ba
  FittedValue stiffness_over_mass;  ///< Ka/M, 1/s^2
  FittedValue damping_over_mass;    ///< Ba/M, 1/s
  Quantity mass_kg;                 ///< M as given
  /// Root of the mean square of the taps' deviations from their mean in units of their own standard
  /// uncertainties (R. T. Birge, Phys. Rev. 40, 207 (1932)), for ln Ka and ln Ba; 0: one tap. Where
  /// it is above 1, weights and uncertainty contain the scatter between taps (consensus_mean.h).
  double stiffness_birge_ratio = 0;
  double damping_birge_ratio = 0;
  std::vector<FittedTap> taps;
  std::vector<Error> left_out;  ///< records that hold no usable ring-down
  Findings findings;            ///< a refusal where Ba is not determined, doubts, what is assumed
};

/// Takes a tap out of a recording: its displacement channel, or its only channel (the poles are
/// the same in any quantity that follows the motion linearly).
///
/// Errors (Cause::kCannotAnswer), named by `name`: no channel or several that could be meant, gaps
/// or an uneven time base.
[[nodiscard]] Result<ImpulseRecord> TapFromRecord(const trial::Record& record,
                                                  const std::string& name);

/// Fits x'' + 2 d x' + q x = 0 to the ring-down of each record and gives, with the mass M that
/// rings on the spring while the other side is held,
///
///     Ka = M q,    Ba = 2 M d,
///
/// as x'' M + Ba x' + Ka x = 0 (J. Lindsay, "A Mechanical Amplifier for Haptic Feedback",
/// University of Washington 2013, equation 2.4 without skin).
///
/// Each record is prepared as a drop is (prepared_record.h: rails, later blows, hum, drift,
/// quantised tail) and fitted by one free pole pair with offset (ring_fit.h). Type A: covariance
/// of the fit with the noise as dense as it is at the resonance; several taps have a common value
/// whose weights and uncertainty contain the scatter between them (consensus_mean.h). Type B: the
/// mass. A fit from half a decay time later, which must agree, shows a spring that stiffens or
/// a joint that rubs.
///
/// Worked: 8200 N/m, 0.01 N s/m and 4.6 g ring at 212.495 Hz with d = 1.08696 1/s.
///
/// Errors (Cause::kCannotAnswer): no record holds a ring-down (see FindRingStart); the first reason
/// is given. Cost: about 10 ms a record.
[[nodiscard]] Result<AdapterFit> FitAdapter(const std::vector<ImpulseRecord>& records,
                                            const Quantity& mass_kg);

}  // namespace haptometer::fit
