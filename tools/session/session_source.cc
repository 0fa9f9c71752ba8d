#include "tools/session/session_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <ctime>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/clock.h"
#include "tools/cli/options.h"
#include "tools/cli/shared_options.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

cli::VerbText SourceText(std::string_view verb) {
  return {.name = verb, .summary = "Options of acquire behind --.", .examples = {"", "", ""}};
}

constexpr std::string_view kFromFolder = "--from-folder";
constexpr std::string_view kScene = "scene:";

// the first option that the plan or the log decides, or that a session does not have
const char* Decided(const RecordingOptions& recording) {
  return !recording.output.empty()      ? "-o"
         : recording.overwrite          ? "--overwrite"
         : !recording.labels.empty()    ? "--label"
         : recording.samples            ? "--samples"
         : recording.duration_s         ? "--duration"
         : !recording.until.empty()     ? "--until"
         : !recording.reconnect.empty() ? "--reconnect"
         : recording.tare               ? "--tare"
                                        : nullptr;
}

// false: the words were reported as wrong
bool ParseWords(cli::Options& options, const SessionPlan& plan) {
  std::vector<const char*> words{"session"};
  words.reserve(plan.source.size() + 1);
  for (const std::string& word : plan.source) words.push_back(word.c_str());
  return !options.Parse(static_cast<int>(words.size()), words.data());
}

Result<FolderSource> ReadFolder(const SessionPlan& plan, std::string_view verb) {
  FolderSource source;
  cli::ImportWords import;
  cli::Options options(SourceText(verb));
  options.Text(kFromFolder, &source.folder, "DIR", "Folder that another program writes into");
  options.Text("--pattern", &source.pattern, "PATTERN", "Of the files' names: '*.csv'");
  options.Number("--unchanged", &source.unchanged_s, Dimension::kTime, cli::Within(0.1, 3600),
                 "A file that has not changed for this time is complete");
  cli::DeclareImport(&options, &import);
  if (!ParseWords(options, plan)) return Usage("", "");
  if (source.folder.empty()) {
    return Usage(std::string(kFromFolder), "has no folder", "name the folder that is written into");
  }
  HAPTOMETER_LET(source.import, cli::ImportOf(import, {}));
  return source;
}

bool IsFolder(const SessionPlan& plan) {
  return std::ranges::any_of(plan.source, [](const std::string& word) {
    return std::string_view(word).substr(0, word.find('=')) == kFromFolder;
  });
}

Result<void> CheckFolder(const FolderSource& source, const std::string& session_folder) {
  std::error_code error;
  if (!fs::is_directory(source.folder, error)) {
    return Usage(source.folder, "is not a folder", "make it, or name the one that is written into");
  }
  // its log would be imported
  if (fs::equivalent(source.folder, session_folder, error)) {
    return Usage(source.folder, "is the session's own folder", "name another one for its source");
  }
  return {};
}

// the part of `word` from `at` on as a full path
void MakeFull(std::string& word, std::size_t at) {
  std::error_code error;
  const fs::path full = fs::absolute(word.substr(at), error).lexically_normal();
  if (!error) word.replace(at, std::string::npos, full.string());
}

}  // namespace

std::vector<std::string> WithFullPaths(std::vector<std::string> words) {
  constexpr std::array<std::string_view, 4> kOfFiles{kFromFolder, "--port", "--profile",
                                                     "--calibration"};
  std::error_code error;
  std::string_view option;  // the word before
  for (std::string& word : words) {
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string::npos;
    const std::size_t begin = equals == std::string::npos ? 0 : equals + 1;
    if (begin > 0) option = std::string_view(word).substr(0, equals);
    if (std::string_view(word).substr(begin).starts_with(kScene)) {
      MakeFull(word, begin + kScene.size());
    } else if (std::ranges::find(kOfFiles, option) != kOfFiles.end() &&
               fs::exists(word.substr(begin), error)) {
      MakeFull(word, begin);
    }
    option = begin > 0 ? std::string_view() : std::string_view(word);
  }
  return words;
}

std::string SceneOf(const SessionPlan& plan) {
  for (const std::string& word : plan.source) {
    const std::size_t begin = word.starts_with("--") ? word.find('=') + 1 : 0;
    if (word.compare(begin, kScene.size(), kScene) == 0) return word.substr(begin + kScene.size());
  }
  return {};
}

Result<SessionSource> ReadSource(const SessionPlan& plan, std::string_view verb) {
  SessionSource source;
  if (IsFolder(plan)) {
    HAPTOMETER_LET(source.folder, ReadFolder(plan, verb));
    return source;
  }
  RecordingOptions recording;
  cli::Options options(SourceText(verb));
  DeclareSensor(options, source.sensor);
  DeclareRecording(options, recording);
  if (!ParseWords(options, plan)) return Usage("", "");
  if (const char* decided = Decided(recording)) {
    return Usage(decided, "is not an option of a session's source", "leave it out");
  }
  HAPTOMETER_TRY(CheckSensor(source.sensor));
  HAPTOMETER_LET(source.plan, PlanRecording(recording, source.sensor, std::time(nullptr)));
  source.plan.limits.duration_ns = NsFromSeconds(plan.duration_s);
  return source;
}

Result<void> CheckSource(const SessionSource& source, const std::string& session_folder) {
  if (source.folder) return CheckFolder(*source.folder, session_folder);
  // a device may be connected later; a file is there or not
  if (!FindSensorKind(source.sensor.sensor)->is_played) return {};
  SystemClock clock;
  HAPTOMETER_TRY(OpenSensor(source.sensor, clock));
  return {};
}

std::string NameOf(const SessionSource& source) {
  if (source.folder)
    return fmt::format("folder {}, {}", source.folder->folder, source.folder->pattern);
  if (source.sensor.is_scene()) return "scene " + PortName(source.sensor);
  return source.sensor.sensor + " " + PortName(source.sensor);
}

}  // namespace haptometer::tools
