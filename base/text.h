#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace haptometer {

/// What `word` was meant to be, for "did you mean": the candidate that one letter of difference
/// makes of it, else up to three that begin or end with it as a word of their own ("--moving-mass
/// or --case-mass" for --mass), else the one with the smallest edit distance (Levenshtein); empty
/// when all are further away than half of the word.
[[nodiscard]] std::string Nearest(std::string_view word,
                                  const std::vector<std::string>& candidates);

/// The number that `text` is from end to end, as std::from_chars reads it; nothing of any other
/// text.
template <typename Number>
[[nodiscard]] std::optional<Number> NumberFrom(std::string_view text) {
  Number number = 0;
  const auto [stop, failure] = std::from_chars(text.begin(), text.end(), number);
  if (failure != std::errc{} || stop != text.end()) return std::nullopt;
  return number;
}

/// Text of files, devices, names and command lines, as it may be shown.
///
/// A character is printable where it stands for itself on one line: valid UTF-8, no control
/// character (U+0000 to U+001F, U+007F to U+009F), no line or paragraph separator (U+2028, U+2029),
/// no embedding, override or isolate of the writing direction (U+202A to U+202E, U+2066 to U+2069),
/// which can show a text in another order than it is in, and no U+FFFE or U+FFFF, which XML
/// forbids. What is new (headers, labels, output paths) is refused where it is not printable; what
/// is old is shown escaped.

/// The bytes of the character that `text` begins with; 0 where they are no UTF-8 (too long a form,
/// a surrogate, beyond U+10FFFF) or `text` is empty.
[[nodiscard]] std::size_t Utf8CharacterBytes(std::string_view text);

[[nodiscard]] bool IsPrintable(std::string_view text);

/// `text` with all that is not printable escaped: `\n`, `\t`, `\r`, `\x1b`, `\u007f`, `\u2028`;
/// bytes that are no UTF-8 as `\xff`. One line, which any terminal, XML or HTML takes. A backslash
/// stays as it is, so the result of the result is the same. O(n).
[[nodiscard]] std::string Printable(std::string_view text);

/// The same for a text of several lines: line ends and tabs stay. A JSON document, in which others
/// than these cannot be below U+007F, stays one of the same content.
[[nodiscard]] std::string PrintableLines(std::string_view text);

/// Refuses a new text that is not printable (Cause::kUsage); `where` says what it is.
[[nodiscard]] Result<void> CheckPrintable(std::string where, std::string_view text);

}  // namespace haptometer
