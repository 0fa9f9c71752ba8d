#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "fit/ring_down_problem.h"

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

/// Samples of a record that are taken together: a block of one length for all, on the record's
/// grid, without a hole or a weight; or one alone.
struct Stretch {
  std::size_t first = 0;
  bool is_block = false;
};

/// All samples of a record.
[[nodiscard]] std::vector<Stretch> StretchesOf(const RingDownSamples& record);

/// A ringing's rates, and when it begins on the record's time axis.
struct RingingRates {
  double decay_per_s = 0;            ///< d
  double stiffness_per_s2 = 0;       ///< q
  double electrical_rate_per_s = 0;  ///< p; 0: there is no such current
  double impact_s = 0;
};

/// A record's samples y, in units of its noise, and the parts F of all its samples in as many rows
/// as there are parts: T with T'T = [F y]'[F y].
struct CondensedRecord {
  std::vector<Part> parts;   ///< F's columns; no kByDiscriminant, which is (t E - O)/(2 (d^2 - q))
  std::vector<double> rows;  ///< T, (parts + 1) x (parts + 1), row-major, the samples last
};

/// Whether the ringing swings long enough for kByDiscriminant to be had from the other parts
/// without loss: (q - d^2) t^2 above 100 at the last sample.
[[nodiscard]] bool CanBeCondensed(const RingDownSamples& record, const RingingRates& rates);

/// Condenses a record.
///
/// By the addition theorems (ringing_moments.h) the parts of any block are those of one block times
/// a small matrix. That block's parts are made orthonormal once, by reflections; each block's
/// samples then leave their products with them, and the length of the rest. What blocks leave is
/// reduced as in row_reduction.h: as stable as a QR decomposition of all rows of F. Cost: 20
/// operations a sample, and some for each block.
///
/// @param stretches of StretchesOf
[[nodiscard]] CondensedRecord CondenseRecord(const RingDownSamples& record,
                                             const std::vector<Stretch>& stretches,
                                             const RingingRates& rates);

}  // namespace haptometer::fit
