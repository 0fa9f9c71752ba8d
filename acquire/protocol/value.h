#pragma once

#include <cstdint>
#include <limits>

#include "trial/record.h"

namespace haptometer::acquire {

/// Stands in Value::counts where the sensor sent letters instead of a number.
inline constexpr std::int32_t kNoCounts = std::numeric_limits<std::int32_t>::min();

/// One value as it was sent: `+01.234` is 1234 counts with 3 decimals. Nothing is rounded or
/// scaled.
struct Value {
  std::int32_t counts = 0;  ///< the digits with their sign, as sent; kNoCounts where there are none
  int decimals = 0;         ///< digits after the point
  trial::SampleStatus status = trial::SampleStatus::kOk;

  friend bool operator==(const Value&, const Value&) = default;
};

}  // namespace haptometer::acquire
