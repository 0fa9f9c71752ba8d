// The DL-RS1A's bytes: any split gives the same lines, every line is a reply or none, and what was
// understood is written back as it was read.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/dl_rs1a.h"
#include "acquire/protocol/line_framer.h"

namespace {

using namespace haptometer::acquire;

void Require(bool condition) {
  if (!condition) std::abort();
}

std::vector<std::string> Lines(std::string_view bytes, std::size_t piece) {
  LineFramer framer(Delimiter::kCrLf, dl_rs1a::kLongestLine);
  std::vector<std::string> lines;
  while (!bytes.empty()) {
    framer.Feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    for (Frame frame = framer.Next(); frame.framing != Framing::kNeedMore; frame = framer.Next()) {
      lines.emplace_back(frame.framing == Framing::kValid ? frame.text : "\n");
    }
  }
  return lines;
}

// M0 has one spelling; the sign of zero and of an error is all that its values do not keep
void CheckReply(const std::string& line) {
  const auto reply = dl_rs1a::ParseReply(line);
  if (!reply) return;
  Require(reply->units <= dl_rs1a::kMostUnits);
  if (reply->kind != dl_rs1a::ReplyKind::kM0) return;
  const std::string again = dl_rs1a::FormatM0Reply(std::span(reply->values).first(reply->units));
  const auto twice = dl_rs1a::ParseReply(std::string_view(again).substr(0, again.size() - 2));
  Require(twice && twice->units == reply->units && twice->values == reply->values);
}

void CheckRequest(const std::string& line) {
  const auto parsed = dl_rs1a::ParseRequest(line);
  if (!parsed.request) return;
  const std::string again = dl_rs1a::FormatRequest(*parsed.request);
  Require(again == line + std::string(dl_rs1a::kLineEnd));
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
    CheckRequest(line);
  }
  return 0;
}
