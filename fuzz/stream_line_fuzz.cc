// A stream's bytes in any drawn form: any split gives the same readings, and a reading is written
// back as the line that it came from.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/line_framer.h"
#include "acquire/protocol/stream_line.h"
#include "fuzz/require.h"

namespace {

using namespace haptometer::acquire;
using namespace haptometer::fuzz;

std::vector<std::optional<Value>> Readings(const StreamFormat& format, std::string_view bytes,
                                           std::size_t piece) {
  LineFramer framer(format.delimiter, 4 * LineBytes(format));
  std::vector<std::optional<Value>> readings;
  while (!bytes.empty()) {
    framer.Feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    for (Frame frame = framer.Next(); frame.framing != Framing::kNeedMore; frame = framer.Next()) {
      readings.push_back(ParseStreamLine(format, frame.text));
      const auto& value = readings.back();
      if (!value || !haptometer::trial::IsMeasurement(value->status)) continue;
      // a negative zero is the only number with two spellings
      const std::int64_t number = format.counter_digits > 0 ? LineCount(format, frame.text) : 0;
      const std::string again = FormatStreamLine(format, *value, number);
      const std::string line = std::string(frame.text).append(Bytes(format.delimiter));
      Require(again == line || value->counts == 0);
    }
  }
  return readings;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  // the first line of the input is the format; where it is none, the default stands in for it
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t end = std::min(text.find('\n'), text.size() - 1);
  const StreamFormat format = ParseStreamFormat(text.substr(0, end)).value_or(StreamFormat{});
  const std::string_view bytes = text.substr(end + 1);
  Require(Readings(format, bytes, 1 + data[0] % 16) ==
          Readings(format, bytes, std::max<std::size_t>(bytes.size(), 1)));
  return 0;
}
