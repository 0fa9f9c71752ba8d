#include "acquire/protocol/wire.h"

#include "base/error.h"

namespace haptometer::acquire {

MonotonicNs WireTimeNs(std::size_t bytes, int baud, int bits_per_character) {
  HAPTOMETER_CHECK(baud > 0, "baud = {}", baud);
  return static_cast<MonotonicNs>(bytes) * bits_per_character * kNsPerS / baud;
}

double HighestObservableHz(double rate_hz) { return rate_hz / kReadingsPerPeriod; }

}  // namespace haptometer::acquire
