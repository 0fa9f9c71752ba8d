#include "tools/cli/command_line.h"

#include <fmt/core.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "base/text.h"

namespace haptometer::cli {
namespace {

// means itself to every shell
bool IsPlain(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
         std::string_view("_-+=:,./@%").find(c) != std::string_view::npos;
}

// $'...' with all that is not plain in octal
std::string DollarQuoted(const std::string& word) {
  std::string quoted = "$'";
  for (const char c : word) {
    if (IsPlain(c) || c == ' ') {
      quoted += c;
    } else {
      fmt::format_to(std::back_inserter(quoted), "\\{:03o}", static_cast<unsigned char>(c));
    }
  }
  return quoted + "'";
}

std::string Quoted(const std::string& word) {
  if (!word.empty() && std::ranges::all_of(word, IsPlain)) return word;
  if (!IsPrintable(word)) return DollarQuoted(word);
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string(R"('\'')") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

std::string CommandLine(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + Quoted(word);
  return line;
}

}  // namespace haptometer::cli
