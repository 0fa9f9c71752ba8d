#include "tools/study/manifest.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <regex>
#include <set>
#include <string_view>
#include <utility>

#include "base/mapped.h"
#include "base/text.h"
#include "base/toml.h"
#include "tools/cli/recording_files.h"

namespace haptometer::tools {
namespace {

// a group of files with labels or a pattern of its own
TrialGroup ReadGroup(TomlTable& table) {
  TrialGroup group;
  group.files = table.Text("files").value_or("");
  group.pattern = table.Text("pattern").value_or("");
  group.subject = table.Text("subject").value_or("");
  group.condition = table.Text("condition").value_or("");
  group.repeat = table.Text("repeat").value_or("");
  if (group.files.empty()) table.Refuse("files", "is missing", R"(add it, as files = "*.bin")");
  return group;
}

}  // namespace

std::vector<PlannedContrast> ReadContrasts(TomlTable& table) {
  // pairs [treatment, control]
  std::vector<PlannedContrast> contrasts;
  for (const auto& pair : table.TextLists("contrasts")) {
    if (pair.size() != 2 || pair[0].empty() || pair[1].empty() || pair[0] == pair[1]) {
      table.Refuse("contrasts", "holds something other than pairs of two conditions",
                   R"(write it as [["ia1", "stock"]])");
      break;
    }
    contrasts.push_back({pair[0], pair[1]});
  }
  return contrasts;
}

Result<Manifest> ReadManifest(const std::string& path) {
  HAPTOMETER_LET(auto table, TomlTable::ParseFile(path));
  Manifest manifest;
  manifest.pattern = table.Text("pattern").value_or("");
  manifest.conditions = table.TextList("conditions");
  manifest.band = table.Text("band").value_or("");
  manifest.order = table.Integer("order");
  manifest.corner = table.Choice("corner", {"whole", "each"}).value_or("");
  manifest.floor = table.Text("floor").value_or("");
  manifest.groups =
      Mapped(table.Tables("trials"), [](TomlTable* group) { return ReadGroup(*group); });
  manifest.contrasts = ReadContrasts(table);
  // unknown keys and wrong types are reported together at the end
  HAPTOMETER_TRY(table.Finish());
  return manifest;
}

namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kLabels{"subject", "condition", "repeat"};

// a pattern as regular expression, and the label of each of its groups
struct Compiled {
  std::regex expression;
  std::vector<std::string> labels;
};

Compiled Compile(const std::string& pattern) {
  // characters with a meaning in regular expressions are escaped
  static const std::regex special(R"([.^$|()\[\]*+?\\])");
  static const std::regex label(R"(\{([a-z]*)\})");
  Compiled compiled;
  // the pattern describes the end of a path; folders before it are free
  std::string expression = "(?:.*/)?";
  auto begin = pattern.begin();
  for (std::sregex_iterator at(pattern.begin(), pattern.end(), label), end; at != end; ++at) {
    const auto literal_end = pattern.begin() + at->position();
    expression += std::regex_replace(std::string(begin, literal_end), special, R"(\$&)");
    // a label is the shortest text without a slash
    expression += "([^/]+?)";
    compiled.labels.push_back((*at)[1]);
    begin = literal_end + at->length();
  }
  expression += std::regex_replace(std::string(begin, pattern.end()), special, R"(\$&)");
  compiled.expression = std::regex(expression);
  return compiled;
}

// labels from the file's name; a name that does not fit is an error of this file alone
TrialFile Labelled(const std::string& path, const std::string& pattern) {
  TrialFile file{.path = path};
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
  // a wildcard finds folders too
  std::erase_if(paths, [](const std::string& path) {
    std::error_code ignored;  // what cannot be read is an error of this file alone
    return fs::is_directory(path, ignored);
  });
  if (paths.empty()) return CannotAnswer(pattern, "finds no file", "correct files in the manifest");
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
  // without the ending, with / on every system
  const std::string name = fs::path(path).replace_extension().generic_string();
  std::smatch match;
  if (!std::regex_match(name, match, compiled.expression)) return std::nullopt;
  std::map<std::string, std::string> labels;
  for (std::size_t i = 0; i < compiled.labels.size(); ++i) {
    // a label from a name may be any text: made printable
    labels[compiled.labels[i]] = Printable(match[i + 1].str());
  }
  return labels;
}

Result<std::vector<TrialFile>> FilesInFolder(const std::string& folder,
                                             const std::string& pattern) {
  HAPTOMETER_LET(const auto found, cli::RecordingsIn(folder));
  return Mapped(found, [&](const cli::RecordingFile& file) {
    return file.is_table ? TrialFile{.path = file.path, .is_table = true}
                         : Labelled(file.path, pattern);
  });
}

// groups of files in the manifest's folder; without groups the folder itself
Result<std::vector<TrialFile>> FilesOfManifest(const std::string& path, const Manifest& manifest) {
  const fs::path folder = fs::path(path).parent_path();
  if (manifest.groups.empty()) {
    return FilesInFolder(folder.empty() ? "." : folder.string(), manifest.pattern);
  }
  std::vector<TrialFile> files;
  std::set<std::string> of_others;
  for (const TrialGroup& group : manifest.groups) {
    HAPTOMETER_LET(const auto paths, Expand((folder / group.files).string()));
    std::set<std::string> seen;
    for (const std::string& found : paths) {
      // however its path is spelled, and whatever links lead to it
      std::error_code error;
      const fs::path same = fs::canonical(found, error);
      const std::string file = error ? found : same.string();
      if (!seen.insert(file).second) continue;
      if (of_others.contains(file)) {
        return CannotAnswer(found, "is in two groups of trials", "name it once in the manifest");
      }
      files.push_back(Labelled(found, group.pattern.empty() ? manifest.pattern : group.pattern));
      // labels of the group override those of the pattern
      auto& labels = files.back().labels;
      if (!group.subject.empty()) labels["subject"] = group.subject;
      if (!group.condition.empty()) labels["condition"] = group.condition;
      if (!group.repeat.empty()) labels["repeat"] = group.repeat;
    }
    of_others.merge(seen);
  }
  return files;
}

std::string NameOf(const PlannedContrast& contrast) {
  return fmt::format("{} against {}", contrast.treatment, contrast.control);
}

Result<PlannedContrast> ParseContrast(const std::string& word) {
  const std::size_t colon = word.find(':');
  PlannedContrast contrast{word.substr(0, colon),
                           colon == std::string::npos ? "" : word.substr(colon + 1)};
  if (contrast.treatment.empty() || contrast.control.empty() ||
      contrast.treatment == contrast.control) {
    return Usage("--contrast", fmt::format("'{}' is not a pair of conditions", word),
                 "write TREATMENT:CONTROL, as ia1:stock");
  }
  return contrast;
}

Result<std::vector<PlannedContrast>> ParseContrasts(const std::vector<std::string>& words) {
  std::vector<PlannedContrast> contrasts;
  contrasts.reserve(words.size());
  for (const std::string& word : words) {
    HAPTOMETER_LET(auto contrast, ParseContrast(word));
    contrasts.push_back(std::move(contrast));
  }
  return contrasts;
}

// contrasts without a plan: each condition against the first
std::vector<PlannedContrast> AllAgainstTheFirst(const std::vector<std::string>& conditions) {
  std::vector<PlannedContrast> planned;
  planned.reserve(conditions.size());
  for (std::size_t c = 1; c < conditions.size(); ++c) {
    planned.push_back({conditions[c], conditions[0]});
  }
  return planned;
}

namespace {

Result<void> CheckConditions(const PlannedContrast& planned,
                             const std::vector<std::string>& conditions) {
  for (const std::string* name : {&planned.treatment, &planned.control}) {
    if (std::ranges::find(conditions, *name) != conditions.end()) continue;
    const std::string nearest = Nearest(*name, conditions);
    return Usage(*name, "is the condition of no trial",
                 nearest.empty() ? fmt::format("the trials have {}", fmt::join(conditions, ", "))
                                 : fmt::format("did you mean {}?", nearest));
  }
  return {};
}

}  // namespace

Result<void> CheckContrasts(const std::vector<PlannedContrast>& planned,
                            const std::vector<std::string>& conditions) {
  std::set<std::set<std::string>> pairs;
  for (const PlannedContrast& contrast : planned) {
    HAPTOMETER_TRY(CheckConditions(contrast, conditions));
    if (pairs.insert({contrast.treatment, contrast.control}).second) continue;
    return Usage(NameOf(contrast), "is a pair of conditions that is planned twice",
                 "write each pair once");
  }
  return {};
}

}  // namespace haptometer::tools
