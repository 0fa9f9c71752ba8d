// An LK-G3001's bytes: any split gives the same lines, every line is a reply or none, and what was
// understood is written back as it was read.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "acquire/protocol/keyence/lkg.h"
#include "fuzz/split_lines.h"

namespace {

using namespace haptometer::acquire;
using namespace haptometer::fuzz;

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
  for (const std::string& line :
       SplitLines(Delimiter::kCr, lkg::kLongestLine, std::span(data, size))) {
    CheckReply(line);
    (void)lkg::ParseRequest(line);
  }
  return 0;
}
