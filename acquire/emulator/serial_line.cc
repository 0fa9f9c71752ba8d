#include "acquire/emulator/serial_line.h"

namespace haptometer::acquire::emulator {

MonotonicNs SerialLine::Send(MonotonicNs ready) {
  // a pause on the wire begins a new burst
  if (ready >= burst_end_) {
    burst_start_ = ready;
    burst_bytes_ = 0;
  }
  ++burst_bytes_;
  burst_end_ = burst_start_ + WireTimeNs(burst_bytes_, baud_, bits_per_character_);
  return burst_end_;
}

}  // namespace haptometer::acquire::emulator
