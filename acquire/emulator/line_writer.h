#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace haptometer::acquire::emulator {

/// Hands bytes to a sink that may take less than it is given, and loses only whole lines.
///
/// A wire does not wait: what the sink has no room for is dropped. So that a reader who stalled
/// finds nothing but whole lines afterwards, a line that the sink took a part of is kept until it
/// takes the rest, and one that it took nothing of is dropped and counted. Holds one line at most,
/// and no more than 256 bytes of it.
class LineWriter {
 public:
  /// Takes bytes, returns how many it took.
  using Sink = std::function<std::size_t(std::string_view)>;

  /// `line_end` is the last byte of a line.
  LineWriter(char line_end, Sink sink) : line_end_(line_end), sink_(std::move(sink)) {}

  /// Bytes in order; lines may be cut anywhere between calls.
  void Write(std::string_view bytes);

  /// The host has gone: forgets the line under way. The next host may come in the middle of one.
  void Abandon();

  /// Lines lost so far for want of room.
  [[nodiscard]] std::uint64_t dropped_lines() const { return dropped_lines_; }

 private:
  void Drop(std::string_view lines);

  char line_end_;
  Sink sink_;
  std::string kept_;       ///< rest of a line that the sink took a part of
  bool mid_line_ = false;  ///< the last byte taken did not end a line
  bool dropping_ = false;  ///< inside a line that is being dropped
  std::uint64_t dropped_lines_ = 0;
};

}  // namespace haptometer::acquire::emulator
