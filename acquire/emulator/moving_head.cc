#include "acquire/emulator/moving_head.h"

#include <cmath>

namespace haptometer::acquire::emulator {

MonotonicNs MovingHead::SampleTime(std::int64_t number) const {
  return std::llround(static_cast<double>(number) * head.sampling_s * static_cast<double>(kNsPerS));
}

std::int64_t MovingHead::LastSample(MonotonicNs now) const {
  // the quotient may be off by one at a sample's own time; SampleTime() decides
  auto number = static_cast<std::int64_t>(SecondsFromNs(now) / head.sampling_s);
  while (SampleTime(number + 1) <= now) ++number;
  while (number > 0 && SampleTime(number) > now) --number;
  return number;
}

trial::HeadReading MovingHead::Reading(std::int64_t number) const {
  return trial::ReadingAt(head, displacement, number, seed);
}

}  // namespace haptometer::acquire::emulator
