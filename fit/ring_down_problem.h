#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace haptometer::fit {

/// The parameters that all records share, each as the logarithm of its SI value.
enum class Shared : std::uint8_t {
  kStiffness,      ///< ln Kv
  kDamping,        ///< ln Bv
  kForceConstant,  ///< ln |Km|
  kMass,           ///< ln M
  kResistance,     ///< ln R
};
inline constexpr std::size_t kSharedCount = 5;

/// The parameters of each record alone.
enum class Own : std::uint8_t {
  kSpeed,   ///< ln of the impact speed in m/s
  kImpact,  ///< time of the impact in s
  kOffset,  ///< in V
};
inline constexpr std::size_t kOwnCount = 3;

[[nodiscard]] constexpr std::size_t Index(Shared parameter) {
  return static_cast<std::size_t>(parameter);
}
[[nodiscard]] constexpr std::size_t Index(Own parameter) {
  return static_cast<std::size_t>(parameter);
}

/// The fitted samples of one record, and what is fixed about it.
struct RingDownSamples {
  std::vector<double> times_s;
  std::vector<double> voltages_v;
  double noise_v = 1;     ///< standard deviation; residuals are divided by it
  double load_ohm = 0;    ///< infinite: open
  double mass_ratio = 1;  ///< the record's ringing mass is mass_ratio * M
  double polarity = 1;    ///< +1 or -1: sign of the voltage's first half period
};

/// A point in parameter space, or a direction.
struct RingDownPoint {
  std::array<double, kSharedCount> shared{};
  std::vector<std::array<double, kOwnCount>> own;  ///< one a record
};

/// Which parameters the solver may move; impact times and offsets always.
struct RingDownFreedom {
  std::array<bool, kSharedCount> shared{};
  std::vector<bool> speed;  ///< one a record
};

/// Derivatives of the weighted residuals, rows x columns, row-major. Columns: the shared
/// parameters, then three a record (see Column).
struct Jacobian {
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values;     ///< (rows x columns)
  std::vector<double> residuals;  ///< (rows) (model - sample) / noise
};

/// The Jacobian's column of a record's own parameter.
[[nodiscard]] constexpr std::size_t Column(std::size_t record, Own parameter) {
  return kSharedCount + kOwnCount * record + Index(parameter);
}

/// How the solver ended.
struct SolverReport {
  bool converged = false;
  std::string termination;  ///< in Ceres's words
  int iterations = 0;
};

/// All records of a drop test as one least-squares problem over the circuit model of
/// sim/ring_down.h:  voltage = offset - polarity v0 u(t - impact) / v0, so that it begins with the
/// sign of `polarity`.
///
/// Derivatives are automatic. The only file of the program that includes Ceres is this one's .cc.
class RingDownProblem {
 public:
  RingDownProblem(std::vector<RingDownSamples> records, double inductance_h);

  /// Levenberg-Marquardt with dense QR from `point`, until rounding stops it (tolerances 1e-15, at
  /// most 1000 iterations). `point` becomes the best one found.
  [[nodiscard]] SolverReport Minimise(const RingDownFreedom& freedom, RingDownPoint* point) const;

  /// Residuals and their derivatives with respect to all parameters, held or not.
  [[nodiscard]] Jacobian Linearise(const RingDownPoint& point) const;

  /// Weighted residuals alone, records in order.
  [[nodiscard]] std::vector<double> Residuals(const RingDownPoint& point) const;

  /// The model's voltage at `times_s` for a record, offset included.
  [[nodiscard]] std::vector<double> Voltages(const RingDownPoint& point, std::size_t record,
                                             const std::vector<double>& times_s) const;

  [[nodiscard]] const std::vector<RingDownSamples>& records() const { return records_; }
  [[nodiscard]] std::vector<RingDownSamples>& records() { return records_; }
  [[nodiscard]] double inductance_h() const { return inductance_h_; }
  void set_inductance_h(double inductance_h) { inductance_h_ = inductance_h; }

 private:
  std::vector<RingDownSamples> records_;
  double inductance_h_;
};

}  // namespace haptometer::fit
