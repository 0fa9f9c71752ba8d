#include "tools/new_trial_path.h"

#include <fmt/core.h>

#include <filesystem>
#include <system_error>

namespace haptometer::tools {

std::string CompactUtc(std::string_view utc) {
  std::string text(utc.substr(0, utc.find('.')));
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  return text + "Z";
}

std::string FirstFreePath(const std::string& path, char separator) {
  namespace fs = std::filesystem;
  const fs::path wanted(path);
  fs::path free = wanted;
  std::error_code ignored;
  for (int number = 2; fs::exists(fs::symlink_status(free, ignored)); ++number) {
    free = wanted.parent_path() / fmt::format("{}{}{}{}", wanted.stem().string(), separator, number,
                                              wanted.extension().string());
  }
  return free.string();
}

}  // namespace haptometer::tools
