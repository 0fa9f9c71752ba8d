#include "tools/daemon/trial_pattern.h"

#include <fmt/core.h>

#include <filesystem>

#include "tools/new_trial_path.h"

namespace haptometer::tools {
namespace {

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

}  // namespace

Result<void> CheckPattern(std::string_view file, std::size_t sensors, std::string_view where) {
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
  if (sensors > 1 && !file.contains("{name}")) {
    return Usage(std::string(where), fmt::format("\"{}\" names all sensors' trials the same", file),
                 "write {name} in it");
  }
  return {};
}

std::string NextTrialPath(const TrialPattern& pattern, std::string_view name, std::string_view utc,
                          std::uint64_t part) {
  const std::string file = Filled(pattern.file, name, CompactUtc(utc), part);
  return FirstFreePath((std::filesystem::path(pattern.directory) / file).string(), '-');
}

}  // namespace haptometer::tools
