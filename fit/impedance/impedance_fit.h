#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/impedance/impedance_model.h"
#include "fit/residuals.h"

namespace haptometer::fit {

/// What an impedance sweep says about an actuator.
struct ImpedanceFit {
  FittedValue stiffness;            ///< Kv, N/m; needs the mass
  FittedValue damping;              ///< Bv, N s/m; needs the mass
  FittedValue force_constant;       ///< |Km|, N/A; needs the mass
  FittedValue stiffness_over_mass;  ///< Kv/M, 1/s^2
  FittedValue damping_over_mass;    ///< Bv/M, 1/s
  FittedValue coupling_over_mass;   ///< Km^2/M, N^2/(A^2 kg)
  FittedValue natural_frequency;    ///< sqrt(Kv/M)/2pi, Hz
  FittedValue quality_factor;       ///< sqrt(Kv M)/Bv: of the open circuit
  FittedValue resistance;           ///< R, ohm: coil and leads
  FittedValue inductance;           ///< L, H; not determined below three standard uncertainties
  std::string mass_symbol = "Mv";   ///< M: "Mv", or "Mv Mc/(Mv+Mc)" of a free case
  std::size_t points = 0;
  std::size_t points_near_resonance = 0;  ///< within half a bandwidth, sqrt(3) f0/Q
  double lowest_hz = 0;
  double highest_hz = 0;
  double magnitude_noise = 0;           ///< standard deviation of a point's |Z| over |Z|
  double phase_noise_rad = 0;           ///< standard deviation of a point's phase
  double degrees_of_freedom = 0;        ///< of all residuals
  double coverage_95 = 0;               ///< Student's factor: the largest of the parameters
  ResidualLook residuals;               ///< in the order of frequency
  double farthest_hz = 0;               ///< the frequency of the point with the largest residual
  std::vector<double> singular_values;  ///< of the column-scaled Jacobian, largest first
  std::vector<double> correlation;      ///< (5 x 5) of ln Kv/M, ln Bv/M, ln Km^2/M, ln R, L; type A
  /// Combined relative covariance (that of logarithms) of Kv, Bv, Km, R and L; 0 in the rows and
  /// columns of what is not determined.
  std::array<std::array<double, 5>, 5> relative_covariance{};
  std::vector<double> parameters;        ///< by ImpedanceParameter, see ImpedanceAt
  std::vector<ImpedancePoint> measured;  ///< (points) that were fitted, in the order of frequency
  std::vector<ImpedanceValue> model;     ///< (points) at each of them
  std::vector<InputInfluence> influences;
  Findings findings;  ///< doubts, and what is assumed or not determined
  bool converged = false;
  int iterations = 0;  ///< of the last round
};

/// Fits the actuator's circuit to an electrical impedance sweep (impedance_model.h):
///
///     Z = R + j w L + (Km^2/M) j w / (w0^2 - w^2 + j w g),   Kv = M w0^2, Bv = M g.
///
/// Residuals are logarithms of magnitude ratios and phase differences; both noises, a share of |Z|
/// and an angle, are unknown and estimated along (fit/residuals.h), so each point's uncertainty is
/// theirs times its |Z|. The sweep alone contains Kv/M, Bv/M and Km^2/M, not M: without a mass
/// nothing else is given. A stated resistance or inductance is taken where the sweep does not tell
/// it (resistance: uncertain to more than 5 %; inductance: always, when stated); otherwise the
/// resistance is compared. Type A: covariance with the estimated noises, which are uncertain
/// themselves. Type B: masses, what was taken as stated, and magnitudes and phases that are rounded
/// to more than their noise. Each interval has Student's factor of its own degrees of freedom.
///
/// The six points nearest to the resonance are left out one at a time: where that moves a constant
/// by more than five of the rest's standard uncertainties, the fit follows that point alone, and
/// nothing is determined.
///
/// Points without a number (NaN) are left out, in any order; repeated frequencies are welcome, but
/// points that were written again (TakeOutCopies) count once.
///
/// Errors (Cause::kCannotAnswer): fewer than 6 points, no three different frequencies, a point with
/// a frequency or a magnitude that is not positive, no resonance in the sweep, or phases that fit
/// well only as radians or with the other sign. Cost: about 0.7 s.
[[nodiscard]] Result<ImpedanceFit> FitImpedance(const std::vector<ImpedancePoint>& points,
                                                const ActuatorKnowns& knowns,
                                                CaseCondition condition, const std::string& name);

}  // namespace haptometer::fit
