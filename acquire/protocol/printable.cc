#include "acquire/protocol/printable.h"

#include <algorithm>

namespace haptometer::acquire {

std::string Printable(std::string_view line) {
  constexpr std::size_t kMost = 24;
  std::string shown(line.substr(0, kMost));
  std::ranges::replace_if(shown, [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

}  // namespace haptometer::acquire
