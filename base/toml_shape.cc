#include "base/toml_shape.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

namespace haptometer {
namespace {

// the length of the string that begins `text` with a quote, or of what is left of it
std::size_t StringLength(std::string_view text) {
  const char quote = text[0];
  const bool has_escapes = quote == '"';
  const bool is_multi_line = text.size() > 2 && text[1] == quote && text[2] == quote;
  std::size_t at = is_multi_line ? 3 : 1;
  while (at < text.size()) {
    if (has_escapes && text[at] == '\\') {
      at += 2;
    } else if (!is_multi_line && text[at] == '\n') {
      return at;  // the parser refuses it
    } else if (!is_multi_line && text[at] == quote) {
      return at + 1;
    } else if (is_multi_line && text.substr(at).starts_with(text.substr(0, 3))) {
      // one or two quotes more belong to the string
      const std::size_t end = text.find_first_not_of(quote, at);
      return std::min({end, text.size(), at + 5});
    } else {
      ++at;
    }
  }
  return text.size();
}

// Walks a text outside of its strings and comments.
class ShapeReader {
 public:
  // takes one character in; whether the text is still within its bounds
  bool Take(char c) {
    if (c == '[' || c == '{') ++open_;
    if (c == ']' || c == '}') open_ = std::max(open_ - 1, 0);
    if (c == '.') {
      ++parts_;
    } else if (std::string_view("\n=,[]{}").contains(c)) {
      parts_ = 1;
    }
    return open_ <= kMostTomlLevels && parts_ <= kMostTomlLevels;
  }
  [[nodiscard]] bool is_key() const { return parts_ > kMostTomlLevels; }

 private:
  int open_ = 0;   // brackets
  int parts_ = 1;  // of what may be a key
};

}  // namespace

Result<void> CheckTomlShape(std::string_view text, std::string_view where) {
  if (text.size() > kMostTomlBytes) {
    return CannotAnswer(std::string(where),
                        fmt::format("is larger than {} MiB", kMostTomlBytes >> 20),
                        "is it a TOML file of this program?");
  }
  ShapeReader shape;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at += StringLength(text.substr(at));
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (!shape.Take(c)) {
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::int64_t>(at), '\n');
      return CannotAnswer(fmt::format("{}:{}", where, line),
                          shape.is_key()
                              ? fmt::format("names a key of more than {} parts", kMostTomlLevels)
                              : fmt::format("opens more than {} brackets", kMostTomlLevels),
                          "mend the TOML there");
    }
    ++at;
  }
  return {};
}

}  // namespace haptometer
