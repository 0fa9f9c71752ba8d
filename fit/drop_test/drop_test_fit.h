#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/prepared_record.h"
#include "fit/poles.h"
#include "fit/residuals.h"
#include "sim/scene/plausible_ranges.h"

namespace haptometer::fit {

/// The coverage factor of the 95 % intervals: a normal distribution's, because records hold
/// thousands of samples.
inline constexpr double kCoverage95 = 1.96;

/// A constant from the fit. Nothing but `unit` and `at_most` means anything where `determined` is
/// false.
struct FittedValue {
  double value = 0;
  double standard_uncertainty = 0;  ///< statistical: from the records' noise alone (type A)
  double combined_standard_uncertainty =
      0;             ///< with masses, ohms, height, rebound, rounding (type A and B)
  double lower = 0;  ///< 95 % interval, of both; not always about the value
  double upper = 0;
  /// Of what is too faint to be determined: the upper end of the 95 % interval whose lower end lies
  /// at 0 or beyond. The same interval either way: a limit of 95 % that becomes an interval as soon
  /// as there is one would hold in 92.5 % only (Feldman and Cousins, Phys. Rev. D 57, 1998, p.
  /// 3873).
  std::optional<double> at_most;
  std::string unit;
  bool determined = false;
};

/// What is least in a fit: the sum of squared residuals, or that of Huber's loss (fit/residuals.h),
/// which a few samples far away hardly move, at 1/0.95 of the variance where there are none.
enum class Loss : std::uint8_t { kSquares, kHuber };

/// What one given input does to the results.
struct InputInfluence {
  std::string input;                         ///< "moving mass", "load", "time scale", ...
  double value = 0;                          ///< in SI units
  double standard_uncertainty = 0;           ///< in SI units; 0: stated as exact
  double relative_standard_uncertainty = 0;  ///< of the value; of 1 + e for the rebound e
  std::string unit;                          ///< SI unit
  /// Percent by which Kv, Bv and Km change when the input grows by 1 percent (of 1 + e for the
  /// rebound e).
  std::array<double, 3> percent_per_percent{};
};

/// How one record was read and met.
struct FittedRecord {
  std::string name;
  RecordedSignal signal = RecordedSignal::kVoltage;  ///< of a displacement, every V is a metre
  double load_ohm = 0;                               ///< infinite: open
  double impact_s = 0;                               ///< on the record's own time axis
  double impact_speed_m_per_s = 0;  ///< of mover against case, its magnitude; see below
  bool speed_determined = false;    ///< whether the impact speed is known or measured
  double offset_v = 0;
  double decay_per_s = 0;          ///< of this record, with its load
  double damped_frequency_hz = 0;  ///< 0 where it does not oscillate
  double residual_rms_v = 0;       ///< over the fitted samples
  std::size_t drawn_samples = 0;   ///< that Huber's loss weighs less than half
  double quiet_noise_v = 0;  ///< RMS of the noise before the impact; 0 where nothing precedes it
  ResidualDensity density;   ///< of the residuals at the resonance
  double peak_v = 0;         ///< largest distance from the offset in the fitted stretch
  std::size_t first_sample = 0;  ///< of the fitted part
  std::size_t samples = 0;       ///< fitted, measurements only
  std::vector<double> model_v;   ///< for every sample of the part, offset and disturbances included
  std::vector<double> residual_v;  ///< sample less model; NaN where a sample is not fitted
  UncertainPole pole;              ///< of the fit of all records, with its combined covariance
  PolePair start;                  ///< where the search began: this record by itself
  Findings found;                  ///< clipping, later impacts, hum, drift, and what is done
};

/// What a set of drops says about an actuator.
struct DropTestFit {
  FittedValue stiffness;            ///< Kv, N/m
  FittedValue damping;              ///< Bv, N s/m: mechanical, without the load's share
  FittedValue force_constant;       ///< |Km|, N/A
  FittedValue moving_mass;          ///< Mv, kg: where it is not given and added masses tell it
  FittedValue stiffness_over_mass;  ///< Kv/M, 1/s^2
  FittedValue damping_over_mass;    ///< Bv/M, 1/s
  FittedValue natural_frequency;    ///< sqrt(Kv/M)/2pi, Hz
  FittedValue quality_factor;       ///< sqrt(Kv M)/Bv with an open circuit
  /// Combined relative covariance of Kv, Bv and Km: that of their logarithms. 0 in the rows and
  /// columns of what is not determined.
  std::array<std::array<double, 3>, 3> relative_covariance{};
  /// Relative standard uncertainties of Kv, Bv and Km by the rounding of the records' converters
  /// (ring_down_problem.h).
  std::array<double, 3> by_rounding{};
  std::string mass_symbol = "Mv";  ///< M: "Mv", or "Mv Mc/(Mv+Mc)" when every case was free
  std::vector<FittedRecord> records;
  std::vector<InputInfluence> influences;
  /// Why the constants are useless (refusals), what speaks against the model (doubts), what is
  /// assumed or not determined (notes). Those of each record are there.
  Findings findings;
  double frequency_birge_ratio = 1;  ///< of the drops (consistency.h); in the uncertainties
  double decay_birge_ratio = 1;
  bool converged = false;
  std::string termination;  ///< the solver's reason to stop
  int iterations = 0;
  double chi_square_per_degree = 0;  ///< against the noise before the impact; 0 where none was seen
};

/// Fits the drop-test model (sim/ring_down.h) to all records together.
///
/// Kv, Bv, Km (and the mass and the coil's resistance where these are not given) are shared; each
/// record has its own impact speed, impact time and offset, and where drops scatter its own Kv and
/// Bv about those of all (consistency.h). Records of a released current have no
/// amplitude of their own: it is Km^2 I0/M, which tells Km without height or load (Rodgers et al.,
/// BSSA 85(3), 1995, p. 845). Those with a mass added to the mover tell the mover's mass. A laser's
/// displacement tells frequency and decay. A stated drop height h fixes the speed
/// at (1 + e) sqrt(2 g h), g = 9.80665 m/s^2; a rebound e that is not stated is taken as 0 with the
/// standard uncertainty 0.3/sqrt(3) of a uniform ignorance between 0 and 0.3. Where Km follows from
/// both the heights and the loads, the road with the smaller combined uncertainty is taken.
///
/// Ceres minimises the residuals in units of each record's noise, to rounding, with logarithms as
/// parameters but for Km^2, to which the loads' damping is proportional; the noise is what the
/// residuals show at the resonance (solved twice; fit/residuals.h). Before any number is given,
/// the singular values of the column-scaled Jacobian say what the records determine
/// (fit/identifiability.h). Type A: covariance with that noise. Type B: first-order propagation of
/// the inputs' standard uncertainties through the same Jacobian, and the rounding of coarse
/// converters (ring_down_problem.h); all add as squares (JCGM 100:2008, 5.1.2). Type A holds the
/// scatter between drops, intervals Student's factor of it.
///
/// Errors (Cause::kCannotAnswer): no records; held and free cases together without both masses.
/// Cost: 1 us a sample in all with what PrepareRecord takes, 5 ns of it an evaluation of the joint
/// fit; memory below 130 bytes a sample.
[[nodiscard]] Result<DropTestFit> FitDropTest(std::vector<PreparedRecord> records,
                                              const ActuatorKnowns& knowns,
                                              Loss loss = Loss::kSquares);

/// What about a fit is unlike any actuator, usually by a mistaken unit.
///
/// Doubted are: a resonance outside of 20-2000 Hz (times in ms or us read as s), a quality factor
/// beyond 1000, a voltage beyond 100 V or below 10 uV (mV read as V, or the reverse), a moving mass
/// outside of 10 mg-100 g and a case mass outside of 10 mg-1 kg (g read as kg), a coil outside of
/// 0.1 ohm-10 kohm, a drop from more than 1 m (mm read as m), a Km outside of 1 mN/A-100 N/A. The
/// limits are wide: LRAs ring at 50-500 Hz with Q of 2-200, weigh grams and give 10 mV to some
/// volts.
[[nodiscard]] Findings FindDoubts(const DropTestFit& fit, const std::vector<ImpulseRecord>& records,
                                  const ActuatorKnowns& knowns);

/// Adds the doubt `kind` where the value is outside of `plausible`; its number is `name`.
void DoubtUnusual(FindingKind kind, std::string_view name, double value,
                  sim::PlausibleRange plausible, Findings& findings,
                  const std::string& subject = {});
/// The same of a value that is determined.
void DoubtUnusual(FindingKind kind, std::string_view name, const FittedValue& value,
                  sim::PlausibleRange plausible, Findings& findings);
/// The same of a number that is given.
void DoubtUnusual(FindingKind kind, std::string_view name, const std::optional<Quantity>& value,
                  sim::PlausibleRange plausible, Findings& findings,
                  const std::string& subject = {});

}  // namespace haptometer::fit
