#include "tools/acquire/trial_name.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestStem = 200;  // file systems take 255 bytes

std::string Plain(std::string text) {
  std::ranges::replace_if(
      text,
      [](char c) {
        const bool is_plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
                              (c >= 'A' && c <= 'Z') || c == '.' || c == '-';
        return !is_plain;
      },
      '_');
  return text;
}

// "2026-03-01T12:00:00.000Z" as "20260301T120000Z"
std::string Compact(const std::string& utc) {
  std::string text = utc.substr(0, utc.find('.'));
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  return text + "Z";
}

}  // namespace

bool IsDirectoryName(const std::string& output) {
  std::error_code ignored;
  return output.ends_with('/') || fs::is_directory(output, ignored);
}

std::string NewTrialName(const std::string& directory, const std::string& utc_start,
                         const std::string& sensor,
                         const std::map<std::string, std::string>& labels) {
  std::string stem = Compact(utc_start) + "_" + Plain(sensor);
  for (const auto& [key, value] : labels) stem += "_" + Plain(key) + "-" + Plain(value);
  stem.resize(std::min(stem.size(), kLongestStem));
  const fs::path base = fs::path(directory) / stem;
  std::string path = base.string() + ".bin";
  std::error_code ignored;
  for (int number = 2; fs::exists(fs::symlink_status(path, ignored)); ++number) {
    path = fmt::format("{}_{}.bin", base.string(), number);
  }
  return path;
}

}  // namespace haptometer::tools
