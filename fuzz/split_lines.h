#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/line_framer.h"
#include "fuzz/require.h"

namespace haptometer::fuzz {

/// The lines in `bytes`, given to a framer `piece` bytes at a time. Where bytes are no line, the
/// delimiter stands, which is in none.
inline std::vector<std::string> LinesInPieces(acquire::Delimiter delimiter, std::size_t longest,
                                              std::string_view bytes, std::size_t piece) {
  acquire::LineFramer framer(delimiter, longest);
  std::vector<std::string> lines;
  while (!bytes.empty()) {
    framer.Feed(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    for (acquire::Frame frame = framer.Next(); frame.framing != acquire::Framing::kNeedMore;
         frame = framer.Next()) {
      lines.emplace_back(frame.framing == acquire::Framing::kValid ? frame.text : "\r\n");
    }
  }
  return lines;
}

/// The lines in a fuzzer's input, whose first byte says how it is split: into any pieces they are
/// the same.
inline std::vector<std::string> SplitLines(acquire::Delimiter delimiter, std::size_t longest,
                                           std::span<const std::uint8_t> input) {
  if (input.size() < 2) return {};
  const std::size_t piece = 1 + input[0] % 16;
  const std::string_view bytes(reinterpret_cast<const char*>(input.data()) + 1, input.size() - 1);
  const auto lines = LinesInPieces(delimiter, longest, bytes, bytes.size());
  Require(lines == LinesInPieces(delimiter, longest, bytes, piece));
  return lines;
}

}  // namespace haptometer::fuzz
