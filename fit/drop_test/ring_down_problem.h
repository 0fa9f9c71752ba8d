#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fit/identifiability.h"
#include "fit/least_squares.h"
#include "fit/poles.h"

namespace haptometer::fit {

/// The parameters that all records share: logarithms of SI values, but for Km^2. That is what a
/// load shows, in proportion; where it is faint, noise may carry it through 0.
enum class Shared : std::uint8_t {
  kStiffness,             ///< ln Kv
  kDamping,               ///< ln Bv
  kForceConstantSquared,  ///< Km^2 in N^2/A^2
  kMass,                  ///< ln M
  kResistance,            ///< ln R
};
inline constexpr std::size_t kSharedCount = 5;

/// What a record shows of the ringing.
enum class RingingSignal : std::uint8_t {
  kBlowVoltage,       ///< sim::RingDown::voltage
  kBlowDisplacement,  ///< sim::RingDown::displacement
  kReleaseVoltage,    ///< sim::RingDown::release
};

/// Lines of hum that a record is fitted with at most: the mains' fundamental and three harmonics.
inline constexpr std::size_t kMostHumLines = 4;

/// The parameters of each record alone.
enum class Own : std::uint8_t {
  /// ln of Km v0 in V; follows from Km^2 where the impact speed v0 is given. Of a displacement: ln
  /// of the speed seen in m/s. Of a release it follows from Km^2 always.
  kAmplitude,
  kImpact,  ///< time of the impact or release in s
  kOffset,  ///< in V
  // disturbances of the recording, held at 0 where a record shows none
  kDrift,      ///< of the offset, in V/s, about the middle of the fitted samples
  kHumCosine,  ///< in V, at the first of the record's `hum_hz`
  kHumSine,    ///< in V; behind it the cosine and sine of each further line
  // what this drop's constants are above those of all, held at 0 where the drops do not scatter
  kStiffness = kHumCosine + 2 * kMostHumLines,  ///< of ln Kv
  kDamping,                                     ///< of ln Bv
};

[[nodiscard]] constexpr std::size_t Index(Shared parameter) {
  return static_cast<std::size_t>(parameter);
}
[[nodiscard]] constexpr std::size_t Index(Own parameter) {
  return static_cast<std::size_t>(parameter);
}
inline constexpr std::size_t kOwnCount = Index(Own::kDamping) + 1;

/// The fitted samples of one record, and what is fixed about it.
struct RingDownSamples {
  std::vector<double> times_s;
  std::vector<double> voltages_v;
  double step_s = 0;                 ///< between samples; some may be missing
  double noise_v = 1;                ///< standard deviation; residuals are divided by it
  std::vector<double> root_weights;  ///< factors of the residuals (fit/residuals.h); empty: all 1
  double load_ohm = 0;               ///< infinite: open
  double time_scale = 1;             ///< shown over true seconds
  double mass_ratio = 1;  ///< the record's ringing mass is mass_ratio * M + added_mass_kg
  double added_mass_kg = 0;
  RingingSignal signal = RingingSignal::kBlowVoltage;
  double polarity = 1;           ///< +1 or -1: sign of the voltage's first half period
  double speed_m_per_s = 0;      ///< of the impact; 0: not given
  double release_current_a = 0;  ///< of a release, times the voltage's scale
  bool drifts = false;           ///< whether the drift is fitted
  std::vector<double> hum_hz;    ///< lines of the mains that are fitted, at most kMostHumLines
  /// Standard deviations with which ln Kv and ln Bv differ between drops; 0: not at all.
  double stiffness_scatter = 0;
  double damping_scatter = 0;
};

/// The mass that rings in a record, in kg.
[[nodiscard]] inline double RingingMass(const RingDownSamples& record, double mass_kg) {
  return record.mass_ratio * mass_kg + record.added_mass_kg;
}

/// A point in parameter space, or a direction.
struct RingDownPoint {
  std::array<double, kSharedCount> shared{};
  std::vector<std::array<double, kOwnCount>> own;  ///< one a record
};

/// The point's components in the order of the Jacobian's columns: the shared parameters, then each
/// record's own (see Column).
[[nodiscard]] std::vector<double> ToColumns(const RingDownPoint& point);

/// The point of these components.
[[nodiscard]] RingDownPoint FromColumns(const std::vector<double>& columns);

/// The Jacobian's column of a record's own parameter.
[[nodiscard]] constexpr std::size_t Column(std::size_t record, Own parameter) {
  return kSharedCount + kOwnCount * record + Index(parameter);
}

/// A record's pole pair, and its derivatives by the shared parameters.
struct RecordPoles {
  PolePair poles;
  std::array<double, kSharedCount> decay_slopes{};
  std::array<double, kSharedCount> stiffness_slopes{};
};

/// All records of a drop test as one least-squares problem over the circuit model of
/// sim/ring_down.h:
///
///     voltage = offset - polarity a u(t - impact) + drift (t - middle)
///               + sum of cosine cos(2 pi hum t) + sine sin(2 pi hum t),
///
/// u being a ratio of RingDown there at true seconds and a the amplitude that belongs to it: Km v0,
/// Km^2 I0/M of a release, or the speed of which a displacement is seen; so that the ringing begins
/// with the sign of `polarity`. Where drops scatter, each has its own Kv and Bv; what these are
/// above those of all, over the scatter, are residuals too, behind those of the samples.
/// Derivatives are those of fit/drop_test/ringing_model.h.
class RingDownProblem {
 public:
  RingDownProblem(std::vector<RingDownSamples> records, double inductance_h);

  /// Minimises (least_squares.h) over the columns that are free; `point` becomes the best one
  /// found, and `condensed`, where it is asked for, what Condense gives there, at no further cost.
  [[nodiscard]] SolverReport Minimise(const std::vector<bool>& is_free, RingDownPoint* point,
                                      Jacobian* condensed = nullptr) const;

  /// Residuals and their derivatives with respect to all parameters, held or not.
  [[nodiscard]] Jacobian Linearise(const RingDownPoint& point) const;

  /// The same linear least-squares problem in 20 rows a record (condensed_record.h).
  [[nodiscard]] Jacobian Condense(const RingDownPoint& point) const;

  /// Whether the voltages at a point can be computed: no overflow, no root of a negative Km^2.
  [[nodiscard]] bool IsDefined(const RingDownPoint& point) const;

  /// Weighted residuals alone: the samples', records in order, then those of the scatter.
  [[nodiscard]] std::vector<double> Residuals(const RingDownPoint& point) const;

  /// J'c: the products of each parameter's derivatives at a point with `changes` of the residuals.
  [[nodiscard]] std::vector<double> Products(const RingDownPoint& point,
                                             std::span<const double> changes) const;

  /// The same of the rows of one record alone.
  [[nodiscard]] std::vector<double> ProductsOf(const RingDownPoint& point, std::size_t record,
                                               std::span<const double> changes) const;

  /// The model's voltage at `times_s` for a record, offset and disturbances included.
  [[nodiscard]] std::vector<double> Voltages(const RingDownPoint& point, std::size_t record,
                                             const std::vector<double>& times_s) const;

  /// The pole pair with which a record rings, in true seconds, its load included.
  [[nodiscard]] RecordPoles Poles(const RingDownPoint& point, std::size_t record) const;

  /// Residuals that are no sample's: one a record for each scatter that is not 0.
  [[nodiscard]] std::size_t ScatterRows() const;

  [[nodiscard]] const std::vector<RingDownSamples>& records() const { return records_; }
  [[nodiscard]] std::vector<RingDownSamples>& records() { return records_; }
  [[nodiscard]] double inductance_h() const { return inductance_h_; }
  void set_inductance_h(double inductance_h) { inductance_h_ = inductance_h; }

 private:
  [[nodiscard]] LeastSquares Whole() const;
  [[nodiscard]] LeastSquares Condensed() const;

  std::vector<RingDownSamples> records_;
  double inductance_h_;
};

/// Mean error of a converter's code for the value `x` with Gaussian noise of standard deviation
/// `noise` before it, everything in steps:
///
///     e(x) = sum over codes m of Phi((x - m + 1/2)/noise) - x,   noise from 0 to 1/2;
///
/// without noise the rounding error itself, with it (1/pi) exp(-2 pi^2 noise^2) sin(2 pi x) at most
/// (Widrow and Kollar, Quantization Noise, 2008, 5.3).
[[nodiscard]] double MeanRoundingError(double x, double noise);

/// What the rounding of a record to its converter's codes may move the solution by: changes of the
/// parameters, independent of each other (CovarianceBy of fit/residuals.h).
///
/// A rounding error follows the motion, and is white noise only where many codes are passed or
/// noise goes before it. What a ringing of few codes makes of it is therefore computed: e(x) along
/// the fitted motion, in 16 cases over which the offset takes all places between two codes and the
/// ringing all peaks within a step, each evenly (van der Corput). The noise before the converter is
/// the residuals' without step/sqrt(12). Type A contains the white part already, which then counts
/// twice.
/// @param problem of all records
/// @param point its solution
/// @param seen at `point`
/// @param record whose rounding it is
/// @param step_v the converter's; 0: none
/// @param deviation_v standard deviation of the record's residuals, or of one sample's noise and
///        rounding where the samples are means
/// Empty where half a step of noise or more goes before the converter. Cost: 16 times 6 error
/// functions a sample.
[[nodiscard]] std::vector<std::vector<double>> RoundingChanges(const RingDownProblem& problem,
                                                               const RingDownPoint& point,
                                                               const Identifiability& seen,
                                                               std::size_t record, double step_v,
                                                               double deviation_v);

}  // namespace haptometer::fit
