#include "base/text.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>

namespace haptometer {
namespace {

// one row of the dynamic programme at a time
std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  // row[j]: distance of the empty text to the first j characters of b
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    // entry (i, j), from which a substitution starts
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string_view WithoutDashes(std::string_view name) {
  return name.substr(std::min(name.find_first_not_of('-'), name.size()));
}

// whether a name begins or ends with a word of its own
bool IsPartOf(std::string_view part, std::string_view name) {
  constexpr std::string_view kBetween = "-_";
  if (name.size() <= part.size()) return false;
  return (name.starts_with(part) && kBetween.contains(name[part.size()])) ||
         (name.ends_with(part) && kBetween.contains(name[name.size() - part.size() - 1]));
}

}  // namespace

std::string Nearest(std::string_view word, const std::vector<std::string>& candidates) {
  std::string nearest;
  // at most half of the letters may differ; of equals the first is chosen
  std::size_t least = word.size() / 2 + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = EditDistance(word, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  if (!nearest.empty() && least <= 1) return nearest;
  // "mass" for --moving-mass, "load" for load_ohm: many letters apart, but a part of the name
  const std::string_view part = WithoutDashes(word);
  std::vector<std::string_view> wholes;
  for (const std::string& candidate : candidates) {
    if (!part.empty() && IsPartOf(part, WithoutDashes(candidate))) wholes.emplace_back(candidate);
  }
  // of many none was meant in particular
  constexpr std::size_t kFew = 3;
  const bool is_few = !wholes.empty() && wholes.size() <= kFew;
  return is_few ? fmt::format("{}", fmt::join(wholes, " or ")) : nearest;
}

namespace {

unsigned Byte(char c) { return static_cast<unsigned char>(c); }

// the code point of the character of `bytes` bytes that `text` begins with
std::uint32_t CodePoint(std::string_view text, std::size_t bytes) {
  // value bits in the first byte of a character of 1 to 4 bytes (UTF-8, RFC 3629)
  constexpr std::uint32_t kBitsOfFirst[] = {0, 0x7f, 0x1f, 0x0f, 0x07};
  std::uint32_t code = Byte(text[0]) & kBitsOfFirst[bytes];
  for (std::size_t i = 1; i < bytes; ++i) code = code << 6U | (Byte(text[i]) & 0x3fU);
  return code;
}

// all but C0 and C1 controls, line and paragraph separators, bidirectional marks, noncharacters
bool IsPrintable(std::uint32_t code) {
  const auto within = [code](std::uint32_t first, std::uint32_t last) {
    return code >= first && code <= last;
  };
  return !within(0, 0x1f) && !within(0x7f, 0x9f) && !within(0x2028, 0x202e) &&
         !within(0x2066, 0x2069) && !within(0xfffe, 0xffff);
}

void AppendEscaped(std::uint32_t code, std::string* text) {
  auto out = std::back_inserter(*text);
  if (code == '\n') {
    *text += "\\n";
  } else if (code == '\t') {
    *text += "\\t";
  } else if (code == '\r') {
    *text += "\\r";
  } else if (code < 0x20) {
    fmt::format_to(out, "\\x{:02x}", code);
  } else {
    fmt::format_to(out, "\\u{:04x}", code);
  }
}

// `kept` are the control characters that stay
std::string Escaped(std::string_view text, std::string_view kept) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const std::size_t bytes = Utf8CharacterBytes(text);
    // a byte that is no UTF-8 is shown as \xNN
    if (bytes == 0) {
      fmt::format_to(std::back_inserter(shown), "\\x{:02x}", Byte(text[0]));
      text.remove_prefix(1);
      continue;
    }
    const std::uint32_t code = CodePoint(text, bytes);
    if (IsPrintable(code) || kept.find(text[0]) != std::string_view::npos) {
      shown += text.substr(0, bytes);
    } else {
      AppendEscaped(code, &shown);
    }
    text.remove_prefix(bytes);
  }
  return shown;
}

}  // namespace

// length in bytes of the first character; 0 where it is no valid UTF-8
std::size_t Utf8CharacterBytes(std::string_view text) {
  if (text.empty()) return 0;
  const unsigned first = Byte(text[0]);
  // 0x80 to 0xc1 begin no character: continuation bytes and overlong forms
  const std::size_t bytes = first < 0x80   ? 1
                            : first < 0xc2 ? 0
                            : first < 0xe0 ? 2
                            : first < 0xf0 ? 3
                            : first < 0xf5 ? 4
                                           : 0;
  if (bytes > text.size()) return 0;
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((Byte(text[i]) & 0xc0U) != 0x80) return 0;
  }
  // overlong forms, surrogates (U+D800 to U+DFFF), above U+10FFFF
  const unsigned second = bytes > 2 ? Byte(text[1]) : 0x80;
  const bool is_wrong = (first == 0xe0 && second < 0xa0) || (first == 0xed && second > 0x9f) ||
                        (first == 0xf0 && second < 0x90) || (first == 0xf4 && second > 0x8f);
  return is_wrong ? 0 : bytes;
}

bool IsPrintable(std::string_view text) {
  while (!text.empty()) {
    const std::size_t bytes = Utf8CharacterBytes(text);
    if (bytes == 0 || !IsPrintable(CodePoint(text, bytes))) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

std::string Printable(std::string_view text) { return Escaped(text, ""); }

std::string PrintableLines(std::string_view text) { return Escaped(text, "\n\t"); }

Result<void> CheckPrintable(std::string where, std::string_view text) {
  if (IsPrintable(text)) return {};
  return Usage(std::move(where),
               fmt::format("'{}' holds a character that cannot be printed", Printable(text)),
               "write it without control characters, on one line, in UTF-8");
}

}  // namespace haptometer
