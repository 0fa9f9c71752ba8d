#include "tools/acquire/trial_name.h"

#include <algorithm>
#include <filesystem>

#include "tools/new_trial_path.h"

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

}  // namespace

bool IsDirectoryName(const std::string& output) {
  std::error_code ignored;
  return output.ends_with('/') || fs::is_directory(output, ignored);
}

std::string NewTrialName(const std::string& directory, const std::string& utc_start,
                         const std::string& sensor,
                         const std::map<std::string, std::string>& labels) {
  std::string stem = CompactUtc(utc_start) + "_" + Plain(sensor);
  for (const auto& [key, value] : labels) stem += "_" + Plain(key) + "-" + Plain(value);
  stem.resize(std::min(stem.size(), kLongestStem));
  return FirstFreePath((fs::path(directory) / (stem + ".bin")).string(), '_');
}

}  // namespace haptometer::tools
