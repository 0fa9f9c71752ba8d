#include "tools/daemon/trial_name.h"

#include <fmt/core.h>

#include <filesystem>
#include <system_error>

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

void Replace(std::string& text, std::string_view placeholder, std::string_view by) {
  for (std::size_t at = 0; (at = text.find(placeholder, at)) != std::string::npos;) {
    text.replace(at, placeholder.size(), by);
    at += by.size();
  }
}

std::string Filled(std::string_view pattern, std::string_view name, std::string_view utc,
                   std::uint64_t part) {
  std::string text(pattern);
  Replace(text, "{name}", name);
  Replace(text, "{utc}", utc);
  Replace(text, "{part}", fmt::format("{:04}", part));
  return text;
}

// 2026-03-01T12:00:00.000Z -> 20260301T120000Z
std::string Compact(std::string_view utc) {
  std::string text(utc.substr(0, utc.find('.')));
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  return text + "Z";
}

}  // namespace

Result<void> CheckPattern(std::string_view file, std::string_view where) {
  constexpr const char* kRemedy = "write a name with {name}, {utc} and {part} in it";
  if (file.empty()) return Usage(std::string(where), "is empty", kRemedy);
  const std::string filled = Filled(file, "n", "u", 1);
  if (filled.find_first_of(std::string_view("/\0", 2)) != std::string::npos) {
    return Usage(std::string(where), "is a path", "name the directory under `directory`");
  }
  if (filled.find_first_of("{}") != std::string::npos) {
    return Usage(std::string(where), fmt::format("\"{}\" has a brace that means nothing", file),
                 kRemedy);
  }
  return {};
}

std::string NextTrialPath(const TrialPattern& pattern, std::string_view name, std::string_view utc,
                          std::uint64_t part) {
  const fs::path path =
      fs::path(pattern.directory) / Filled(pattern.file, name, Compact(utc), part);
  fs::path free = path;
  std::error_code error;
  for (int attempt = 2; fs::exists(fs::symlink_status(free, error)); ++attempt) {
    free = path.parent_path() /
           fmt::format("{}-{}{}", path.stem().string(), attempt, path.extension().string());
  }
  return free;
}

}  // namespace haptometer::tools
