#include "tools/cli/key_values.h"

#include <fmt/core.h>

namespace haptometer::cli {

Result<std::map<std::string, std::string>> ReadKeyValues(const std::vector<std::string>& words,
                                                         std::string_view option) {
  std::map<std::string, std::string> values;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos || equals == 0) {
      return Usage(std::string(option), fmt::format("'{}' is not KEY=VALUE", word),
                   "write e.g. subject=3");
    }
    values[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return values;
}

}  // namespace haptometer::cli
