#include "acquire/sensor/line_link.h"

#include <utility>

namespace haptometer::acquire {

LineLink::LineLink(std::unique_ptr<Transport> transport, Clock& clock, Delimiter delimiter,
                   std::size_t longest_line)
    : transport_(std::move(transport)), clock_(clock), framer_(delimiter, longest_line) {}

LinkLine LineLink::Read(MonotonicNs deadline) {
  bool is_last_look = false;
  while (true) {
    // lines that arrived with the last chunk come first
    const Frame frame = framer_.Next();
    if (frame.framing != Framing::kNeedMore) {
      const bool valid = frame.framing == Framing::kValid;
      return {.state = valid ? LinkState::kLine : LinkState::kOverlong,
              .text = frame.text,
              .chunk_ns = chunk_ns_,
              .bytes_behind = frame.bytes_behind};
    }
    // bytes that form no line may come without end: past the deadline one chunk is the last
    if (is_last_look) return {.state = LinkState::kNothing, .text = {}};
    const ReadOutcome outcome = transport_->Read(chunk_, deadline);
    if (outcome.state == ReadState::kGone) return {.state = LinkState::kGone, .text = {}};
    if (outcome.state == ReadState::kTimeout) return {.state = LinkState::kNothing, .text = {}};
    // arrival of the chunk; the time of a line follows from the bytes behind it
    chunk_ns_ = clock_.Now();
    is_last_look = chunk_ns_ >= deadline;
    framer_.Feed(std::string_view(chunk_.data(), outcome.bytes));
  }
}

std::size_t LineLink::Flush() {
  std::size_t thrown_away = framer_.Reset();
  // a device that sends without end must not prolong the flush: its buffers hold less than this
  constexpr int kMostChunks = 64;
  for (int i = 0; i < kMostChunks; ++i) {
    const ReadOutcome outcome = transport_->Read(chunk_, clock_.Now());
    if (outcome.state != ReadState::kBytes) break;
    thrown_away += outcome.bytes;
  }
  discarded_bytes_ += thrown_away;
  return thrown_away;
}

std::string LineLink::Source(bool is_emulated) const {
  constexpr std::string_view kDevice = "device: ";
  std::string source = transport_->Source();
  if (!is_emulated) return source;
  // the source of an emulator must not be mistaken for a device
  if (source.starts_with(kDevice)) source.erase(0, kDevice.size());
  return "emulated device: " + source;
}

}  // namespace haptometer::acquire
