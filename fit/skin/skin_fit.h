#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/drop_test_fit.h"
#include "fit/residuals.h"
#include "sim/scene/actuator.h"

namespace haptometer::fit {

/// The parameters of the skin under a contact.
enum class ContactParameter : std::uint8_t {
  kStiffness,  ///< ln Ks, N/m
  kDamping,    ///< ln Bs, N s/m
  kMass,       ///< m itself in kg: what moves with the contact besides the case
};
inline constexpr std::size_t kContactParameters = 3;

[[nodiscard]] constexpr std::size_t Index(ContactParameter parameter) {
  return static_cast<std::size_t>(parameter);
}

/// What drives the actuator in a measurement.
enum class DriveQuantity : std::uint8_t { kCurrent, kVoltage };

/// Displacement of the contact per unit of drive, and d ln(that) by the parameters.
struct ContactValue {
  std::complex<double> motion;  ///< m/A or m/V
  std::array<std::complex<double>, kContactParameters> logarithmic_slopes;
};

/// The contact's steady motion under an actuator whose case lies on the skin (directly, or through
/// a rigid contactor), J. Lindsay, University of Washington 2013, equations 2.1-2.3 with the skin's
/// spring, damper and mass m on the case. With w = 2 pi frequency_hz, D = Kv + j w Bv and
/// T = Ks + j w Bs - w^2 (Mc + m):
///
///     x/i = -w^2 Mv Km / (T (D - w^2 Mv) - w^2 Mv D),
///     v/i = R + j w L - j w Km y,   y = (w^2 Mv x/i - Km) / (D - w^2 Mv),
///
/// y being the mover's travel in the case per ampere. Equal to sim/linear/steady_state.h, which
/// solves the five states, to rounding (a test holds it to that), for m = 0 or with m counted into
/// Mc. Cost: 100 ns.
[[nodiscard]] ContactValue ContactAt(const sim::Actuator& actuator, DriveQuantity drive,
                                     const std::vector<double>& parameters, double frequency_hz);

/// One frequency of a drive sweep on the skin.
struct SkinPoint {
  double frequency_hz = 0;
  double displacement_m = 0;  ///< amplitude at the contact
  double drive = 0;           ///< amplitude, A or V
  /// Of the displacement (towards the skin positive) against the drive; absent: not measured.
  std::optional<double> phase_rad{};
  /// Standard uncertainty of the displacement; absent: not stated.
  std::optional<double> displacement_standard_uncertainty_m{};
};

/// A sweep under one contact.
struct SkinSweep {
  std::string name;
  std::optional<double> area_m2;  ///< of the contact
  bool is_simulated = false;      ///< by this program, not measured
  DriveQuantity drive = DriveQuantity::kCurrent;
  std::vector<SkinPoint> points;
};

/// What one given number does to the results.
struct SkinInfluence {
  std::string input;  ///< "Mv" and the others of kActuatorSymbols, "displacement over drive"
  double relative_standard_uncertainty = 0;  ///< 0: stated as exact
  double stiffness_percent_per_percent = 0;
  double damping_percent_per_percent = 0;
  double mass_kg_per_percent = 0;
};

/// The skin under one contact.
struct SkinFit {
  std::string name;
  std::optional<double> area_m2;
  bool is_simulated = false;
  FittedValue stiffness;  ///< Ks, N/m
  FittedValue damping;    ///< Bs, N s/m
  /// m, kg: the skin's (and a contactor's) mass that moves with the case, besides the case itself.
  /// Determined where its statistical uncertainty is below a quarter of Mc + m; then it may well be
  /// 0 within its interval.
  FittedValue mass;
  std::array<double, kContactParameters * kContactParameters>
      correlation{};                    ///< of ln Ks, ln Bs, m; type A
  std::vector<double> singular_values;  ///< of the column-scaled Jacobian, largest first
  std::size_t points = 0;
  double magnitude_noise = 0;  ///< relative, of a point; as a factor on stated uncertainties
  bool uncertainties_stated = false;
  std::optional<double> phase_noise_rad;  ///< where phases were measured
  double degrees_of_freedom = 0;          ///< of all residuals
  double coverage_95 = 0;                 ///< Student's factor: the largest of the parameters
  ResidualLook residuals;                 ///< in the order of frequency
  std::vector<double> model_m;            ///< amplitude at each point, in order of frequency
  std::vector<double> frequencies_hz;
  std::vector<double> measured_m;
  std::vector<SkinInfluence> influences;          ///< eight
  sim::ActuatorCovariance actuator_covariance{};  ///< of the first seven, relative
  Findings findings;  ///< of Ks and Bs that are not determined refusals; doubts; notes
  bool converged = false;
  int iterations = 0;
};

/// Fits Ks, Bs and m to a sweep with a known actuator (ContactAt).
///
/// Residuals are logarithms of the amplitude's ratio to the model and, where measured, differences
/// of phase, weighted by noises that are estimated along (fit/residuals.h): a share of the
/// amplitude where no uncertainty is stated, at least the stated ones otherwise. Amplitudes alone
/// may leave two solutions, below and above a resonance; a second one that fits as well within nine
/// units of chi-square is named. Type A: covariance, with the noises' own uncertainty. Type B: the
/// actuator's numbers by central differences of the exact model (1e-4 of each, good to 1e-8), with
/// their stated correlations, and what is rounded to more than its noise. Each interval has
/// Student's factor of its own degrees of freedom.
///
/// Errors (Cause::kCannotAnswer): an actuator without Kv, Bv or Km; fewer than 5 points or 4
/// different frequencies; a frequency, amplitude or drive that is not positive; phases or
/// uncertainties stated for some points only. Points with NaN are left out. Cost: about 20 ms.
[[nodiscard]] Result<SkinFit> FitSkin(const SkinSweep& sweep, const sim::StatedActuator& actuator);

}  // namespace haptometer::fit
