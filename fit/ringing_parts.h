#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "fit/ring_down_problem.h"
#include "fit/ringing_moments.h"

namespace haptometer::fit {

/// What a recorded ringing and its derivatives are sums of, t being the time since the blow
/// (ringing_moments.h).
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
  kDrift,  ///< from the middle of the samples
  kHumCosine,
  kHumSine,
};
inline constexpr std::size_t kPartCount = 11;

/// A number for each part: its value at a time, or what of it is in a sum.
using PartNumbers = std::array<double, kPartCount>;

[[nodiscard]] constexpr std::size_t Index(Part part) { return static_cast<std::size_t>(part); }

/// What one volt (or volt per second) of each disturbance of a recording adds at a time.
struct RecordingParts {
  explicit RecordingParts(const RingDownSamples& record)
      : middle_s(0.5 * (record.times_s.front() + record.times_s.back())),
        hum_rad_per_s(2 * std::numbers::pi * record.hum_hz) {}

  /// Drift, hum's cosine and sine; 1 and 0 of a hum of 0 Hz.
  [[nodiscard]] std::array<double, 3> At(double time_s) const;

  double middle_s;
  double hum_rad_per_s;
};

/// A ringing's rates, and when it begins on the record's time axis.
struct RingingRates {
  double decay_per_s = 0;            ///< d
  double stiffness_per_s2 = 0;       ///< q
  double electrical_rate_per_s = 0;  ///< p; 0: there is no such current
  double impact_s = 0;

  bool operator==(const RingingRates&) const = default;
};

/// The parts at one sample of a record after another (ringing_moments.h: times must rise to be
/// cheap).
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

}  // namespace haptometer::fit
