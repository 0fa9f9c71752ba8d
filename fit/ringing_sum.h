#pragma once

#include <array>
#include <cstddef>

#include "fit/ring_down_problem.h"
#include "fit/ringing_parts.h"

namespace haptometer::fit {

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
/// @param shared the point's shared parameters, @param own those of this record
[[nodiscard]] RingingSum SumOfParts(const RingDownSamples& record, double inductance_h,
                                    const double* shared, const double* own);

}  // namespace haptometer::fit
