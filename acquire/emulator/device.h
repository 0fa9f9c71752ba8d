#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/clock.h"

namespace haptometer::acquire::emulator {

/// What an emulated device does with bytes and time, and nothing else: no file, no thread, no
/// clock.
///
/// All times are nanoseconds since the device was switched on, so sample 0 is taken at 0. The
/// caller never goes back in time. How often it calls makes no difference to the bytes: only to how
/// late they are handed over.
class Device {
 public:
  virtual ~Device() = default;

  /// The host wrote `bytes` at `now`; they still have to cross the wire.
  virtual void Receive(std::string_view bytes, MonotonicNs now) = 0;

  /// Appends to `out` the bytes that have crossed the wire to the host by `now` and were not handed
  /// over before, in order.
  virtual void Advance(MonotonicNs now, std::string& out) = 0;

  /// When Advance() next has something to do; nothing while the device waits for the host.
  [[nodiscard]] virtual std::optional<MonotonicNs> NextDue() const = 0;

  /// Whether the device has just dropped off the line (a fault); asking clears it.
  [[nodiscard]] virtual bool TakeHangUp() = 0;

  /// The last byte of a line, by which a reader finds its place again.
  [[nodiscard]] virtual char line_end() const = 0;
};

}  // namespace haptometer::acquire::emulator
