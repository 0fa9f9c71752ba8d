// A DL-EN1's line: a reply, a request or neither, and what was understood is written back as it was
// read.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "acquire/protocol/keyence/dl_en1.h"
#include "fuzz/require.h"

namespace {

using namespace haptometer::acquire;
using namespace haptometer::fuzz;

std::string_view WithoutEnd(const std::string& line) {
  return std::string_view(line).substr(0, line.size() - dl::kLineEnd.size());
}

std::string Format(const dl::Reply& reply) {
  const auto values = std::span(reply.values).first(reply.units);
  switch (reply.kind) {
    case dl::ReplyKind::kM0:
      return dl::FormatM0Reply(dl_en1::Spelling(), values);
    case dl::ReplyKind::kMs:
      return dl::FormatMsReply(dl_en1::Spelling(), std::span(reply.outputs).first(reply.units),
                               values);
    case dl::ReplyKind::kSr:
      return dl::FormatDataReply(dl::Command::kSr, reply.unit, reply.number, reply.data);
    case dl::ReplyKind::kFr:
      return dl::FormatDataReply(dl::Command::kFr, reply.unit, reply.number, reply.data);
    case dl::ReplyKind::kSw:
      return dl::FormatWriteReply(
          {.command = dl::Command::kSw, .unit = reply.unit, .number = reply.number});
    case dl::ReplyKind::kError:
      return dl::FormatErrorReply(dl_en1::Spelling(), {reply.data, reply.number});
    default:
      return {};  // DR is never sent by us, AW never by a DL-EN1
  }
}

// the sign of zero, and one digit of an output or two, are all that a reply does not keep
void CheckReply(std::string_view line) {
  const auto reply = dl::ParseReply(dl_en1::Spelling(), line);
  if (!reply) return;
  Require(reply->units <= dl::kMostUnits && reply->kind != dl::ReplyKind::kAw);
  if (reply->kind == dl::ReplyKind::kDr) return;
  const std::string again = Format(*reply);
  const auto twice = dl::ParseReply(dl_en1::Spelling(), WithoutEnd(again));
  Require(twice && twice->kind == reply->kind && twice->units == reply->units &&
          twice->values == reply->values && twice->outputs == reply->outputs &&
          twice->unit == reply->unit && twice->number == reply->number &&
          twice->data == reply->data);
  for (std::size_t i = 0; i < reply->units; ++i) (void)dl_en1::WithIlSpecials(reply->values[i]);
}

void CheckRequest(std::string_view line) {
  const auto parsed = dl::ParseRequest(dl_en1::Spelling(), line);
  if (!parsed.request) return;
  Require(WithoutEnd(dl::FormatRequest(*parsed.request)) == line);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  CheckReply(line);
  CheckRequest(line);
  if (!line.empty()) (void)dl_en1::WithPort(line);
  return 0;
}
