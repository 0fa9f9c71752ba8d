#pragma once

#include <time.h>

#include <span>
#include <string>
#include <string_view>

#include "acquire/transport/transport.h"

/// Reading and writing with deadlines on an open file descriptor, the same for serial ports,
/// virtual terminals and sockets. Deadlines are on CLOCK_MONOTONIC (base/clock.h: SystemClock).
namespace haptometer::acquire {

/// Closes its descriptor when it goes.
class OwnedDescriptor {
 public:
  explicit OwnedDescriptor(int descriptor) : descriptor_(descriptor) {}
  OwnedDescriptor(OwnedDescriptor&& other) noexcept : descriptor_(other.descriptor_) {
    other.descriptor_ = -1;
  }
  OwnedDescriptor& operator=(OwnedDescriptor&& other) noexcept;
  OwnedDescriptor(const OwnedDescriptor&) = delete;
  OwnedDescriptor& operator=(const OwnedDescriptor&) = delete;
  ~OwnedDescriptor();

  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// `ns` as the system wants it; 0 below 0.
[[nodiscard]] timespec TimespecOf(MonotonicNs ns);

/// Sets a terminal raw, 8N1: no echo, no line editing, no translation of CR, no flow control.
/// Whether that went well; errno says why not.
[[nodiscard]] bool MakeRaw(int descriptor);

/// Waits for `events` of poll(2) until `deadline`; 0 after the deadline or a signal, else what
/// came.
[[nodiscard]] int WaitFor(int descriptor, int events, MonotonicNs deadline);

/// Waits for bytes until `deadline` and takes what is there.
///
/// The other end is gone when poll reports a hang-up or an error with nothing left to read, when it
/// is readable but gives no byte (how a removed USB serial port looks), or when read fails (EIO:
/// how a closed pseudo-terminal looks). Bytes that came before a hang-up are handed out first.
[[nodiscard]] ReadOutcome ReadDescriptor(int descriptor, std::span<char> buffer,
                                         MonotonicNs deadline);

/// Sends all of `bytes` before `deadline`; the descriptor must be non-blocking. `name` is the port
/// in messages. Errors: Cause::kFailed.
[[nodiscard]] Result<void> WriteDescriptor(int descriptor, std::string_view bytes,
                                           MonotonicNs deadline, const std::string& name);

/// Takes the port for this process alone: flock, which other programs with manners respect.
/// Errors: Cause::kCannotAnswer, "is busy", naming the process that holds it where /proc tells.
[[nodiscard]] Result<void> LockPort(int descriptor, const std::string& name);

/// Asks a serial port's driver to hand bytes over at once (ASYNC_LOW_LATENCY: FTDI adapters then
/// answer within 1 ms and not 16 ms); whether it now does. Most drivers but not all know the
/// setting.
[[nodiscard]] bool AskForLowLatency(int descriptor);

/// The error of a port that did not open, by errno, with the remedy for it: absent, no permission,
/// busy, or anything else.
[[nodiscard]] Error PortDoesNotOpen(const std::string& name, int error_number);

/// Who else has the device at `path` open: "minicom (process 123)", or "" where /proc does not tell
/// (another user's process). Looks at every process; for error messages only.
[[nodiscard]] std::string PortHolder(const std::string& path);

}  // namespace haptometer::acquire
