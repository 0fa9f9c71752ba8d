#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "fit/drop_test/ring_down_problem.h"

namespace haptometer::fit {

/// What a ringing voltage is made of at one time after the blow (sim/ring_down.h): the fundamental
/// solutions of x'' + 2 d x' + q x = 0, and the coil's current's own decay.
struct RingingMoment {
  double since_s = 0;
  double even = 0;        ///< E = e^(-d t) cosh(r t), r^2 = d^2 - q
  double odd = 0;         ///< O = e^(-d t) sinh(r t) / r, in seconds
  double electrical = 0;  ///< e^(-p t); 0 before the blow
};

/// Derivatives of E and O by d, q and the time, whatever the damping.
struct RingingSlopes {
  double even_by_decay = 0;
  double even_by_stiffness = 0;
  double even_by_time = 0;
  double odd_by_decay = 0;
  double odd_by_stiffness = 0;
  double odd_by_time = 0;
};

/// The moments of samples that lie `step_s` apart, some perhaps missing.
///
/// E and O of a stretch's first sample are computed; those of the following ones come by the
/// addition theorems
///
///     E(a + b) = E(a) E(b) + (d^2 - q) O(a) O(b),    O(a + b) = O(a) E(b) + E(a) O(b)
///
/// from a table of 64 steps, which holds for any damping and costs no sine and no exponential.
/// Relative to the envelope the error is below 1e-15 and that of the angle. A sample that is off
/// the grid, behind a longer hole, or before the blow (where the sums cancel under heavy damping)
/// is a stretch of its own. No allocation.
class RingingMoments {
 public:
  /// @param decay_per_s d
  /// @param stiffness_per_s2 q
  /// @param electrical_rate_per_s p; 0: there is no such current
  /// @param step_s 0: no grid is known
  RingingMoments(double decay_per_s, double stiffness_per_s2, double electrical_rate_per_s,
                 double step_s);

  /// At the next sample: times must rise to be cheap.
  RingingMoment At(double since_s) {
    RingingMoment moment = Moved(since_s);
    const double exponents = electrical_rate_per_s_ * since_s;
    if (electrical_rate_per_s_ > 0 && since_s >= 0 && exponents < kMostExponents) {
      moment.electrical = std::exp(-exponents);
    }
    return moment;
  }

  [[nodiscard]] RingingSlopes SlopesAt(const RingingMoment& moment) const;

  /// dO/d(d^2 - q) at a given d, part of the slopes.
  [[nodiscard]] double OddByDiscriminant(const RingingMoment& moment) const;

 private:
  static constexpr std::size_t kSteps = 64;
  static constexpr double kOffGrid = 1e-6;       // of a step: more than rounding
  static constexpr double kMostExponents = 700;  // e^-700 is no part of any voltage

  RingingMoment Moved(double since_s) {
    const double steps = (since_s - first_.since_s) * steps_per_s_;
    const bool is_near =
        first_.since_s >= 0 && steps > -0.5 && steps < static_cast<double>(kSteps) - 0.5;
    const double above = steps + 0.5;  // positive where it counts: cut off, it is the nearest
    const std::size_t step = is_near ? static_cast<std::size_t>(above) : 0;
    if (!is_near || steps_per_s_ == 0 || std::abs(steps - static_cast<double>(step)) > kOffGrid) {
      return Begin(since_s);
    }
    const RingingMoment& further = table_[step];
    return {.since_s = since_s,
            .even = first_.even * further.even + discriminant_per_s2_ * first_.odd * further.odd,
            .odd = first_.odd * further.even + first_.even * further.odd};
  }
  RingingMoment Begin(double since_s);  // a stretch

  double decay_per_s_;
  double discriminant_per_s2_;  // d^2 - q
  double stiffness_per_s2_;
  double electrical_rate_per_s_;
  double steps_per_s_;  // 0: no grid is known
  std::array<RingingMoment, kSteps> table_{};
  RingingMoment first_{.since_s = std::numeric_limits<double>::infinity()};  // of the stretch
};

/// What a recorded ringing and its derivatives are sums of, t being the time since the impact.
/// RingingMoment has E, O and the electrical part.
enum class Part : std::uint8_t {
  kEven,             ///< E(t)
  kOdd,              ///< O(t)
  kTimesEven,        ///< t E(t)
  kTimesOdd,         ///< t O(t)
  kByDiscriminant,   ///< dO/d(d^2 - q) at a given d
  kElectrical,       ///< e^(-p t)
  kTimesElectrical,  ///< t e^(-p t)
  kConstant,
  // of the recording, over the time shown
  kDrift,      ///< from the middle of the samples
  kHumCosine,  ///< of the first line of hum
  kHumSine,    ///< behind it the cosine and sine of each further line
};

[[nodiscard]] constexpr std::size_t Index(Part part) { return static_cast<std::size_t>(part); }
inline constexpr std::size_t kPartCount = Index(Part::kHumCosine) + 2 * kMostHumLines;

/// A number for each part: its value at a time, or what of it is in a sum.
using PartNumbers = std::array<double, kPartCount>;

/// What one volt (or volt per second) of each disturbance of a recording adds at a time.
struct RecordingParts {
  explicit RecordingParts(const RingDownSamples& record);

  /// Drift, then cosine and sine of each line of hum; 0 of lines that the record does not have.
  [[nodiscard]] std::array<double, 1 + 2 * kMostHumLines> At(double time_s) const;

  double middle_s;
  std::size_t lines;
  std::array<double, kMostHumLines> hum_rad_per_s{};
};

/// A ringing's rates, and when it begins on the record's time axis.
struct RingingRates {
  double decay_per_s = 0;            ///< d
  double stiffness_per_s2 = 0;       ///< q
  double electrical_rate_per_s = 0;  ///< p; 0: there is no such current
  double impact_s = 0;

  bool operator==(const RingingRates&) const = default;
};

/// The parts at one sample of a record after another (times must rise to be cheap).
class RingingParts {
 public:
  RingingParts(const RingDownSamples& record, const RingingRates& rates);

  [[nodiscard]] PartNumbers At(double time_s);

  /// A sum of parts that no derivative needs: without kTimesEven, kTimesOdd, kByDiscriminant,
  /// kTimesElectrical.
  [[nodiscard]] double SumAt(double time_s, const PartNumbers& coefficients);

 private:
  RecordingParts recording_;
  double impact_s_;
  double per_time_scale_;
  RingingMoments moments_;
};

/// The parameters that a record answers to: the shared ones, then its own.
inline constexpr std::size_t kAnsweredCount = kSharedCount + kOwnCount;

/// A derivative by each of them, and a 0, for whole pairs.
using AnsweredSlopes = std::array<double, kAnsweredCount + 1>;

/// A record's voltage at a point as a sum of parts, and its derivatives:
///
///     v = sum of voltage[part] part(t),    dv/dp = sum of slopes[part][p] part(t).
struct RingingSum {
  RingingRates rates;
  PartNumbers voltage{};
  std::array<AnsweredSlopes, kPartCount> slopes{};
  RecordPoles poles;
};

/// The sum of a record at a point. The blow's direction is such that the first half period has the
/// record's polarity. Derivatives of the circuit's poles and shape are automatic. Not numbers where
/// a given impact speed meets an impossible Km^2.
///
/// @param record of which all but the samples counts
/// @param inductance_h of the coil
/// @param shared the point's shared parameters
/// @param own those of this record
[[nodiscard]] RingingSum SumOfParts(const RingDownSamples& record, double inductance_h,
                                    const double* shared, const double* own);

}  // namespace haptometer::fit
