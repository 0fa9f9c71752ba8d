#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// The device's end of the connector: where a host plugs in, one at a time. One thread only.
class Endpoint {
 public:
  virtual ~Endpoint() = default;

  /// What a host opens: a path, or HOST:PORT. Changes when Unplug() makes a new terminal.
  [[nodiscard]] virtual std::string name() const = 0;

  /// Sleeps until bytes come, a host comes or goes, `longest_ns` is over, or a signal arrives (the
  /// coming of a host may be noticed 2 ms late). Returns whether a host is there.
  [[nodiscard]] virtual bool Wait(MonotonicNs longest_ns) = 0;

  /// Appends the bytes that are there to `bytes`; never waits. Returns whether the host is still
  /// there.
  [[nodiscard]] virtual bool Read(std::string& bytes) = 0;

  /// Hands over as much of `bytes` as the system takes without waiting; returns how much that was.
  [[nodiscard]] virtual std::size_t Write(std::string_view bytes) = 0;

  /// Drops off the line as a pulled plug does, and is at once ready for the next host.
  [[nodiscard]] virtual Result<void> Unplug() = 0;
};

/// A pseudo-terminal in raw mode, 8N1; gone with the object.
///
/// `link` is a symbolic link to make on it, or "". A link to another terminal that is in the way is
/// replaced (a killed emulator leaves one), anything else is not. Errors (Cause::kFailed): no
/// terminal to be had, the link cannot be made.
[[nodiscard]] Result<std::unique_ptr<Endpoint>> OpenPty(const std::string& link);

/// A listening TCP socket on `address`, HOST:PORT or [HOST]:PORT; port 0 lets the system choose. Of
/// several hosts the second waits until the first has gone. Errors: Cause::kUsage for an address
/// that is none, Cause::kFailed where it cannot be listened on.
[[nodiscard]] Result<std::unique_ptr<Endpoint>> ListenTcp(const std::string& address);

}  // namespace haptometer::acquire::emulator
