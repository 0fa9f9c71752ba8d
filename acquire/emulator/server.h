#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "acquire/emulator/device.h"
#include "acquire/emulator/endpoint.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// Hands bytes to a sink that may take less than it is given, and loses only whole lines.
///
/// A wire does not wait: what neither the sink nor `room` bytes here can hold is dropped. A serial
/// port's driver keeps 64 KiB for a reader who stalled; a pseudo-terminal takes only 12 KiB, and
/// that much comes at once when the machine held up the emulator itself. So that the reader finds
/// nothing but whole lines afterwards, a line that the sink took a part of is kept until it takes
/// the rest (no more than 256 bytes of it), and one that there is no room for is dropped and
/// counted.
class LineWriter {
 public:
  /// Takes bytes, returns how many it took.
  using Sink = std::function<std::size_t(std::string_view)>;

  /// What a serial port's driver keeps (Linux, tty_buffer.c: TTYB_DEFAULT_MEM_LIMIT).
  static constexpr std::size_t kPortRoom = 65'536;

  /// `line_end` is the last byte of a line.
  LineWriter(char line_end, std::size_t room, Sink sink)
      : line_end_(line_end), room_(room), sink_(std::move(sink)) {}

  /// Bytes in order; lines may be cut anywhere between calls.
  void Write(std::string_view bytes);

  /// The host has gone: forgets the line under way. The next host may come in the middle of one.
  void Abandon();

  /// Lines lost so far for want of room.
  [[nodiscard]] std::uint64_t dropped_lines() const { return dropped_lines_; }

 private:
  void Drop(std::string_view lines);

  char line_end_;
  std::size_t room_;
  Sink sink_;
  std::string kept_;       ///< what the sink has not taken yet
  bool mid_line_ = false;  ///< the last byte taken did not end a line
  bool dropping_ = false;  ///< inside a line that is being dropped
  std::uint64_t dropped_lines_ = 0;
};

/// What a run of Serve() came to.
struct ServeReport {
  std::uint64_t bytes = 0;          ///< handed to hosts
  std::uint64_t dropped_lines = 0;  ///< lost because the host did not read and there was no room
                                    ///< left (LineWriter)
  std::uint64_t hang_ups = 0;       ///< times the device dropped off the line
};

/// Runs `device` at `endpoint` in real time, from its own time 0, until `stop` is true (looked at
/// every 50 ms, and after a signal) or `duration_ns` is over.
///
/// Bytes are handed over when they have crossed the emulated wire: never earlier, and later only by
/// what the system takes to wake the thread, which never adds up. While no host is there they are
/// lost, as on a wire. `announce` gets the endpoint's name at the start, when a host may come, and
/// again when a terminal's name has changed. One thread; costs one wake-up per due time.
/// Errors (Cause::kFailed): no new terminal after a hang-up.
[[nodiscard]] Result<ServeReport> Serve(Device& device, Endpoint& endpoint,
                                        const std::atomic<bool>& stop,
                                        std::optional<MonotonicNs> duration_ns,
                                        const std::function<void(const std::string&)>& announce);

}  // namespace haptometer::acquire::emulator
