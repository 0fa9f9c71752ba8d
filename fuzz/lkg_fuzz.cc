// An LK-G3001's bytes: any split gives the same lines, every line is a reply or none, and what was
// understood is written back as it was read.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/line_framer.h"
#include "acquire/protocol/lkg.h"

namespace {

using namespace haptometer::acquire;

void Require(bool condition) {
  if (!condition) std::abort();
}

std::vector<std::string> Lines(std::string_view bytes, std::size_t piece) {
  LineFramer framer(Delimiter::kCr, lkg::kLongestLine);
  std::vector<std::string> lines;
  while (!bytes.empty()) {
    framer.Feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    for (Frame frame = framer.Next(); frame.framing != Framing::kNeedMore; frame = framer.Next()) {
      lines.emplace_back(frame.framing == Framing::kValid ? frame.text : "\r");
    }
  }
  return lines;
}

// what a reply does not keep: the case of its command, the sign of zero, and whether X's or dashes
// stood for no value
void CheckReply(const std::string& line) {
  const auto reply = lkg::ParseReply(line);
  if (!reply) return;
  Require(reply->outs <= lkg::kMostOuts);
  const auto values = std::span(reply->values).first(reply->outs);
  if (reply->kind == lkg::ReplyKind::kError) {
    Require(lkg::FormatErrorReply(reply->refused, reply->error) == line + lkg::kLineEnd);
  } else if (reply->kind == lkg::ReplyKind::kCommand) {
    const std::string again = lkg::FormatReply(reply->command, values);
    const auto twice = lkg::ParseReply(std::string_view(again).substr(0, again.size() - 1));
    Require(twice && twice->command == reply->command && twice->values == reply->values);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::size_t piece = 1 + data[0] % 16;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::vector<std::string> lines = Lines(bytes, bytes.size());
  Require(lines == Lines(bytes, piece));
  for (const std::string& line : lines) {
    CheckReply(line);
    (void)lkg::ParseRequest(line);
  }
  return 0;
}
