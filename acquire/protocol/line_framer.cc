#include "acquire/protocol/line_framer.h"

#include "base/error.h"
#include "base/names.h"

namespace haptometer::acquire {

std::string_view Bytes(Delimiter delimiter) {
  constexpr Names<Delimiter, 3> kBytes{{"\r", "\n", "\r\n"}};
  return kBytes.Of(delimiter);
}

LineFramer::LineFramer(Delimiter delimiter, std::size_t longest)
    // lines of CR LF end at the LF, and the CR before it is removed
    : end_character_(delimiter == Delimiter::kCr ? '\r' : '\n'), longest_(longest) {
  HAPTOMETER_CHECK(longest > 0, "longest = {}", longest);
}

void LineFramer::Feed(std::string_view bytes) {
  // what is left of the last feed is one unfinished line at most: move it to the front
  buffer_.erase(0, line_begin_);
  searched_ -= line_begin_;
  line_begin_ = 0;
  buffer_.append(bytes);
}

// discards an unfinished line; returns its bytes
std::size_t LineFramer::Reset() {
  const std::size_t forgotten = buffer_.size() - line_begin_;
  if (forgotten == 0) return 0;  // between two lines: a LF may still belong to the last one
  buffer_.clear();
  line_begin_ = 0;
  searched_ = 0;
  overlong_ = false;
  skip_line_feed_ = false;
  return forgotten;
}

Frame LineFramer::Next() {
  while (true) {
    // the LF behind a CR that ended a line belongs to that line
    if (skip_line_feed_ && line_begin_ < buffer_.size()) {
      if (buffer_[line_begin_] == '\n') ++line_begin_;
      searched_ = line_begin_;
      skip_line_feed_ = false;
    }
    const std::size_t end = buffer_.find(end_character_, searched_);
    if (end == std::string::npos) {
      searched_ = buffer_.size();
      DropOverlongStart();
      return {};
    }
    const Frame frame = Finish(end);
    if (frame.framing == Framing::kInvalid || !frame.text.empty()) return frame;
  }
}

void LineFramer::DropOverlongStart() {
  // one character more than the longest line may wait: it can be the CR before a LF
  const std::size_t waiting = buffer_.size() - line_begin_;
  if (!overlong_ && waiting <= longest_ + 1) return;
  overlong_ = true;
  discarded_bytes_ += waiting;
  line_begin_ = buffer_.size();
}

Frame LineFramer::Finish(std::size_t end) {
  std::string_view text = std::string_view(buffer_).substr(line_begin_, end - line_begin_);
  line_begin_ = searched_ = end + 1;
  // the LF of a CR LF may come with the next bytes
  skip_line_feed_ = end_character_ == '\r';
  Frame frame{Framing::kValid, text, buffer_.size() - line_begin_};
  if (end_character_ == '\n' && frame.text.ends_with('\r')) frame.text.remove_suffix(1);
  // an overlong line is reported without its text; its bytes count as discarded
  if (overlong_ || frame.text.size() > longest_) {
    discarded_bytes_ += text.size() + 1;
    overlong_ = false;
    frame.framing = Framing::kInvalid;
    frame.text = {};
  }
  return frame;
}

}  // namespace haptometer::acquire
