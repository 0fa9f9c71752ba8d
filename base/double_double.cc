#include "base/double_double.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>

namespace haptometer {

#if defined(__FAST_MATH__) || FLT_EVAL_METHOD != 0
#error "sums and products must be rounded to double as they stand"
#endif
static_assert(std::numeric_limits<double>::is_iec559);

double Scaled(DoubleDouble a, int exponent) {
  // neither half of the factor is subnormal
  const int clamped = std::clamp(exponent, -1100, 1100);
  const auto times_power = [clamped](double value) {
    return value * PowerOfTwo(clamped / 2) * PowerOfTwo(clamped - clamped / 2);
  };
  const double rounded = a.high + a.low;
  if (clamped > -1000 || std::abs(rounded) >= PowerOfTwo(-1022 - clamped)) {
    return times_power(rounded);
  }
  // where bits fall off, they are rounded off both doubles at once: next to a number whose last
  // bit is that of the subnormals
  const double sign = std::copysign(1.0, a.high);
  const double coarse = PowerOfTwo(-1022 - clamped);
  const DoubleDouble sum = ExactSum(coarse, sign * a.high);
  const double whole = sum.high + (sum.low + sign * a.low);
  return sign * times_power(whole - coarse);
}

}  // namespace haptometer
