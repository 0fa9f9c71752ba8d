#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace haptometer::acquire {

/// How a device ends its lines.
enum class Delimiter : std::uint8_t {
  kCr,    ///< CR; a LF directly behind it belongs to it
  kLf,    ///< LF; a CR directly before it belongs to it
  kCrLf,  ///< CR LF; read like kLf
};

/// "\r", "\n" or "\r\n": the bytes to send.
[[nodiscard]] std::string_view Bytes(Delimiter delimiter);

/// What LineFramer::Next() found.
enum class Framing : std::uint8_t {
  kValid,     ///< a line
  kNeedMore,  ///< no further line in the bytes fed so far
  kInvalid,   ///< a line longer than the longest; its bytes were discarded and counted
};

/// One step of a LineFramer.
struct Frame {
  Framing framing = Framing::kNeedMore;
  std::string_view text;         ///< the line without its delimiter; valid until the next Feed()
  std::size_t bytes_behind = 0;  ///< fed bytes that lie behind this line's delimiter
};

/// Cuts bytes into lines, however the transport happened to split them.
///
/// The lines depend on the bytes alone, not on how they were fed. An empty line is skipped. A line
/// longer than `longest` is discarded up to and including its delimiter and reported once as
/// kInvalid, so garbage costs at most `longest` bytes of memory.
class LineFramer {
 public:
  /// `longest`: characters of the longest legal line without its delimiter.
  LineFramer(Delimiter delimiter, std::size_t longest);

  /// Appends bytes. Call Next() until it says kNeedMore before feeding again.
  void Feed(std::string_view bytes);

  /// The next line. O(bytes) over all calls together.
  [[nodiscard]] Frame Next();

  /// Forgets the bytes that wait, as when the port is flushed; returns how many they were.
  std::size_t Reset();

  /// Bytes of an unfinished line that wait for its end; 0 inside an overlong line.
  [[nodiscard]] std::size_t waiting_bytes() const { return buffer_.size() - line_begin_; }
  /// Bytes thrown away in overlong lines so far.
  [[nodiscard]] std::uint64_t discarded_bytes() const { return discarded_bytes_; }

 private:
  Frame Finish(std::size_t end);
  void DropOverlongStart();

  char end_character_;
  std::size_t longest_;
  std::string buffer_;
  std::size_t line_begin_ = 0;   ///< where the unfinished line starts in buffer_
  std::size_t searched_ = 0;     ///< how far buffer_ has been searched for a delimiter
  bool overlong_ = false;        ///< inside a line that is being discarded
  bool skip_line_feed_ = false;  ///< the last byte was a CR that ended a line
  std::uint64_t discarded_bytes_ = 0;
};

}  // namespace haptometer::acquire
