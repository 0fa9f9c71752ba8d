#include "tools/plot/script.h"

#include <cstdint>

#include "base/text.h"

namespace haptometer::plot {
namespace {

constexpr std::size_t kMostCharacters = 1000;
constexpr std::size_t kMostTickBytes = 49;  // gnuplot's MAX_ID_LEN, 50, with the end
constexpr std::string_view kGoesOn = "…";

// the beginning of printable `text`, of so many characters and bytes, and a mark where it goes on
std::string Beginning(std::string_view text, std::size_t characters, std::size_t bytes) {
  std::size_t end = 0;        // of what there is room for
  std::size_t short_end = 0;  // of what there is room for beside the mark
  for (std::size_t count = 0; end < text.size() && count < characters; ++count) {
    const std::size_t next = end + Utf8CharacterBytes(text.substr(end));
    if (next > bytes) break;
    end = next;
    if (end + kGoesOn.size() <= bytes && count + 1 < characters) short_end = end;
  }
  if (end == text.size()) return std::string(text);
  return std::string(text.substr(0, short_end)) + std::string(kGoesOn);
}

// `text` with `replacement` for each `wanted`
std::string Replaced(std::string_view text, char wanted, std::string_view replacement) {
  std::string replaced;
  for (const char c : text) {
    if (c == wanted) {
      replaced += replacement;
    } else {
      replaced += c;
    }
  }
  return replaced;
}

// ends the quote, adds a quote in other quotes, and goes on; a doubled quote, which gnuplot 5.4
// knows too, it does not understand where a text begins with one
constexpr std::string_view kQuote = R"('."'".')";

}  // namespace

Quoted::Quoted(std::string_view text)
    : word_("'" + Replaced(Beginning(Printable(text), kMostCharacters, SIZE_MAX), '\'', kQuote) +
            "'") {}

Quoted Quoted::TickName(std::string_view text) {
  if (text.find('%') == std::string_view::npos) return Quoted(text);
  return Quoted(Replaced(Beginning(Printable(text), kMostCharacters, kMostTickBytes), '%', "%%"));
}

}  // namespace haptometer::plot
