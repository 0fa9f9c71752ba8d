#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "acquire/protocol/line_framer.h"
#include "acquire/transport/transport.h"
#include "base/clock.h"

namespace haptometer::acquire {

/// What LineLink::Read found.
enum class LinkState : std::uint8_t {
  kLine,      ///< a line
  kOverlong,  ///< a line longer than the longest, thrown away
  kNothing,   ///< no whole line before the deadline
  kGone,      ///< the other end hung up
};

struct LinkLine {
  LinkState state = LinkState::kNothing;
  std::string_view text;         ///< valid until the next call
  MonotonicNs chunk_ns = 0;      ///< when the bytes that ended it were taken from the port
  std::size_t bytes_behind = 0;  ///< bytes taken with it that lie behind it
};

/// Lines of a transport, with what was thrown away counted.
class LineLink {
 public:
  /// `clock` must outlive the link and be the one of the transport's deadlines.
  LineLink(std::unique_ptr<Transport> transport, Clock& clock, Delimiter delimiter,
           std::size_t longest_line);

  /// The next line; waits for bytes until `deadline`, or until a signal. Bytes that form no line do
  /// not prolong the wait, however many come.
  [[nodiscard]] LinkLine Read(MonotonicNs deadline);

  /// Throws away what is there now, counts it, and returns how many bytes it was. Where it was any,
  /// the next line may be cut.
  std::size_t Flush();

  /// Counts `bytes` as thrown away: a line that the caller could not use.
  void CountDiscarded(std::size_t bytes) { discarded_bytes_ += bytes; }

  /// Bytes that were taken from the port and not handed out yet.
  [[nodiscard]] std::size_t waiting_bytes() const { return framer_.waiting_bytes(); }
  [[nodiscard]] std::uint64_t discarded_bytes() const {
    return discarded_bytes_ + framer_.discarded_bytes();
  }
  /// When bytes last came.
  [[nodiscard]] MonotonicNs last_bytes_ns() const { return chunk_ns_; }
  /// Where the lines come from, for a trial's metadata. What calls itself emulated is no device,
  /// whatever the port.
  [[nodiscard]] std::string Source(bool is_emulated) const;
  [[nodiscard]] Transport& transport() { return *transport_; }
  [[nodiscard]] const Transport& transport() const { return *transport_; }

 private:
  // one read of a terminal gives 4095 bytes at most, a socket's more
  static constexpr std::size_t kChunkBytes = 16'384;

  std::unique_ptr<Transport> transport_;
  Clock& clock_;
  LineFramer framer_;
  std::array<char, kChunkBytes> chunk_{};
  MonotonicNs chunk_ns_ = 0;
  std::uint64_t discarded_bytes_ = 0;
};

}  // namespace haptometer::acquire
