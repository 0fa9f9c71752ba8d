#include "tools/study/trial_files.h"

#include <fmt/core.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <set>
#include <string_view>

#include "base/text.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kLabels{"subject", "condition", "repeat"};

bool IsRecording(const fs::path& path) {
  const std::string ending = path.extension();
  return ending == ".bin" || ending == ".csv" || ending == ".lvm";
}

// the pattern as a regular expression, and the labels of its groups
struct Compiled {
  std::regex expression;
  std::vector<std::string> labels;
};

Compiled Compile(const std::string& pattern) {
  static const std::regex special(R"([.^$|()\[\]*+?\\])");
  static const std::regex label(R"(\{([a-z]*)\})");
  Compiled compiled;
  std::string expression = "(?:.*/)?";
  auto begin = pattern.begin();
  for (std::sregex_iterator at(pattern.begin(), pattern.end(), label), end; at != end; ++at) {
    const auto literal_end = pattern.begin() + at->position();
    expression += std::regex_replace(std::string(begin, literal_end), special, R"(\$&)");
    expression += "([^/]+?)";
    compiled.labels.push_back((*at)[1]);
    begin = literal_end + at->length();
  }
  expression += std::regex_replace(std::string(begin, pattern.end()), special, R"(\$&)");
  compiled.expression = std::regex(expression);
  return compiled;
}

TrialFile Labelled(const std::string& path, const std::string& pattern) {
  TrialFile file{.path = path, .labels = {}, .error = {}};
  if (pattern.empty()) return file;
  if (auto labels = LabelsOf(path, pattern)) {
    file.labels = *std::move(labels);
  } else {
    file.error = Error{Cause::kCannotAnswer, path,
                       fmt::format("has a name that does not fit the pattern {}", pattern),
                       "rename it, or leave it out of the files"};
  }
  return file;
}

Result<std::vector<std::string>> Expand(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> paths;
  const int failure = ::glob(pattern.c_str(), 0, nullptr, &found);
  if (failure == 0) paths.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  std::erase_if(paths, [](const std::string& path) { return fs::is_directory(path); });
  if (paths.empty()) return CannotAnswer(pattern, "finds no file", "mend files in the manifest");
  return paths;
}

}  // namespace

Result<void> CheckPattern(const std::string& pattern) {
  const std::vector<std::string> labels = Compile(pattern).labels;
  std::set<std::string> seen;
  for (const std::string& label : labels) {
    if (std::ranges::find(kLabels, label) == kLabels.end()) {
      return Usage("pattern", fmt::format("{{{}}} is not a label", label),
                   "use {subject}, {condition} and {repeat}");
    }
    if (!seen.insert(label).second) {
      return Usage("pattern", fmt::format("{{{}}} stands in it twice", label), "keep one");
    }
  }
  if (seen.empty()) {
    return Usage("pattern", fmt::format("'{}' holds no label", pattern),
                 "write it as '{subject}_{condition}_{repeat}'");
  }
  return {};
}

std::optional<std::map<std::string, std::string>> LabelsOf(const std::string& path,
                                                           const std::string& pattern) {
  const Compiled compiled = Compile(pattern);
  const std::string name = fs::path(path).replace_extension().generic_string();
  std::smatch match;
  if (!std::regex_match(name, match, compiled.expression)) return std::nullopt;
  std::map<std::string, std::string> labels;
  for (std::size_t i = 0; i < compiled.labels.size(); ++i) {
    labels[compiled.labels[i]] = Printable(match[i + 1].str());
  }
  return labels;
}

Result<std::vector<TrialFile>> FilesInFolder(const std::string& folder,
                                             const std::string& pattern) {
  std::vector<std::string> paths;
  std::error_code error;
  for (auto at = fs::recursive_directory_iterator(folder, error);
       at != fs::recursive_directory_iterator() && !error; at.increment(error)) {
    std::error_code ignored;
    if (at->is_regular_file(ignored) && IsRecording(at->path())) paths.push_back(at->path());
  }
  if (paths.empty()) {
    return CannotAnswer(folder, "holds no recording", "recordings end in .bin, .csv or .lvm");
  }
  std::ranges::sort(paths);
  std::vector<TrialFile> files;
  files.reserve(paths.size());
  for (const std::string& path : paths) files.push_back(Labelled(path, pattern));
  return files;
}

Result<std::vector<TrialFile>> FilesOfManifest(const std::string& path, const Manifest& manifest) {
  const fs::path folder = fs::path(path).parent_path();
  if (manifest.groups.empty()) {
    return FilesInFolder(folder.empty() ? "." : folder.string(), manifest.pattern);
  }
  std::vector<TrialFile> files;
  std::set<std::string> seen;
  for (const TrialGroup& group : manifest.groups) {
    const auto paths = Expand((folder / group.files).string());
    if (!paths) return std::unexpected(paths.error());
    for (const std::string& found : *paths) {
      if (!seen.insert(found).second) {
        return CannotAnswer(found, "is in two groups of trials", "name it once in the manifest");
      }
      files.push_back(Labelled(found, group.pattern.empty() ? manifest.pattern : group.pattern));
      auto& labels = files.back().labels;
      if (!group.subject.empty()) labels["subject"] = group.subject;
      if (!group.condition.empty()) labels["condition"] = group.condition;
      if (!group.repeat.empty()) labels["repeat"] = group.repeat;
    }
  }
  return files;
}

}  // namespace haptometer::tools
