#include "acquire/sensor/line_counter.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace haptometer::acquire {

std::int64_t LineCounter::LostBefore(std::int32_t number) {
  HAPTOMETER_CHECK(number >= 0 && number < turn_, "number {} of {}", number, turn_);
  const std::int64_t damaged = std::exchange(damaged_, 0);
  const std::optional<std::int32_t> last = std::exchange(last_, number);
  if (!last) return 0;
  // lines between the two numbers, 0 to turn - 1: the same number again is a whole turn later
  const std::int32_t between = (number - *last - 1 + turn_) % turn_;
  // noise may cut one line into several damaged ones, never make one of none
  return std::max<std::int64_t>(between - damaged, 0);
}

}  // namespace haptometer::acquire
