// The DL-RS1A's bytes: any split gives the same lines, every line is a reply or none, and what was
// understood is written back as it was read.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "acquire/protocol/keyence/dl_rs1a.h"
#include "fuzz/split_lines.h"

namespace {

using namespace haptometer::acquire;
using namespace haptometer::fuzz;

// M0 has one spelling; the sign of zero and of an error is all that its values do not keep
void CheckReply(const std::string& line) {
  const auto reply = dl::ParseReply(dl_rs1a::Spelling(), line);
  if (!reply) return;
  Require(reply->units <= dl_rs1a::kMostUnits);
  if (reply->kind != dl::ReplyKind::kM0) return;
  const std::string again =
      dl::FormatM0Reply(dl_rs1a::Spelling(), std::span(reply->values).first(reply->units));
  const auto twice =
      dl::ParseReply(dl_rs1a::Spelling(), std::string_view(again).substr(0, again.size() - 2));
  Require(twice && twice->units == reply->units && twice->values == reply->values);
}

void CheckRequest(const std::string& line) {
  const auto parsed = dl::ParseRequest(dl_rs1a::Spelling(), line);
  if (!parsed.request) return;
  const std::string again = dl::FormatRequest(*parsed.request);
  Require(again == line + std::string(dl::kLineEnd));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  for (const std::string& line :
       SplitLines(Delimiter::kCrLf, dl_rs1a::kLongestLine, std::span(data, size))) {
    CheckReply(line);
    CheckRequest(line);
  }
  return 0;
}
