#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

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

}  // namespace haptometer::acquire::emulator
