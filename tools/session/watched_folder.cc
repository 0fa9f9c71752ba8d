#include "tools/session/watched_folder.h"

#include <fmt/core.h>
#include <fnmatch.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "tools/document/provenance.h"

namespace haptometer::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHash = "SHA-256 ";
constexpr std::string_view kBytes = " bytes, modified ";
constexpr std::string_view kBetween = ", ";
constexpr std::size_t kHashDigits = 64;

// the number before `end`, which is removed with it; nothing where there is none
template <typename Number>
std::optional<Number> TakeNumber(std::string_view& text, std::string_view end) {
  const std::size_t at = text.find(end);
  if (at == std::string_view::npos) return std::nullopt;
  const auto number = NumberFrom<Number>(text.substr(0, at));
  text.remove_prefix(at + end.size());
  return number;
}

// the same name, size and time of modification
bool IsSame(const FolderFile& one, const FolderFile& other) {
  return one.bytes == other.bytes && one.modified_ns == other.modified_ns &&
         Printable(one.name) == Printable(other.name);
}

// what a finished attempt was imported from
struct Imported {
  FolderFile file;
  SessionCell cell;
};

std::vector<Imported> ImportedFiles(const SessionState& state) {
  std::vector<Imported> imported;
  for (const SessionAttempt& attempt : state.attempts) {
    if (!attempt.verdict) continue;
    if (auto file = ReadFolderFile(attempt.origin)) {
      imported.push_back({*std::move(file), attempt.cell});
    }
  }
  return imported;
}

// the cell of an earlier file whose content is the beginning of this one
std::optional<SessionCell> ContinuedCell(const FolderFile& file, const std::string& path,
                                         const std::vector<Imported>& imported) {
  for (const Imported& earlier : imported) {
    const bool is_longer = earlier.file.bytes < file.bytes;
    if (!is_longer || earlier.file.name != Printable(file.name)) continue;
    const std::string begin = document::Sha256Of(path, earlier.file.bytes);
    if (!begin.empty() && begin == earlier.file.sha256) return earlier.cell;
  }
  return std::nullopt;
}

}  // namespace

std::string TextOf(const FolderFile& file) {
  const std::string hash =
      file.sha256.empty() ? std::string() : fmt::format("{}{}{}", kHash, file.sha256, kBetween);
  return fmt::format("{}{}{}{}{}{}", hash, file.bytes, kBytes, file.modified_ns, kBetween,
                     Printable(file.name));
}

std::optional<FolderFile> ReadFolderFile(std::string_view text) {
  FolderFile file;
  if (text.starts_with(kHash)) {
    text.remove_prefix(kHash.size());
    file.sha256 = text.substr(0, kHashDigits);
    const bool is_hex = file.sha256.find_first_not_of("0123456789abcdef") == std::string::npos;
    text.remove_prefix(file.sha256.size());
    if (file.sha256.size() != kHashDigits || !is_hex || !text.starts_with(kBetween)) return {};
    text.remove_prefix(kBetween.size());
  }
  const auto bytes = TakeNumber<std::uint64_t>(text, kBytes);
  if (!bytes) return std::nullopt;
  const auto modified_ns = TakeNumber<std::int64_t>(text, kBetween);
  if (!modified_ns || text.empty()) return std::nullopt;
  file.bytes = *bytes;
  file.modified_ns = *modified_ns;
  file.name = Printable(text);
  return file;
}

Result<std::vector<FolderFile>> FilesIn(const FolderSource& source) {
  std::vector<FolderFile> files;
  std::error_code error;
  for (fs::directory_iterator at(source.folder, error), end; !error && at != end;
       at.increment(error)) {
    const std::string name = at->path().filename().string();
    struct stat status{};
    // one that was removed meanwhile has no state
    if (fnmatch(source.pattern.c_str(), name.c_str(), FNM_PERIOD) != 0 ||
        stat(at->path().c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
      continue;
    }
    files.push_back({.name = name,
                     .bytes = static_cast<std::uint64_t>(status.st_size),
                     .modified_ns = status.st_mtim.tv_sec * kNsPerS + status.st_mtim.tv_nsec});
  }
  if (error) {
    return CannotAnswer(source.folder, "cannot be read: " + error.message(),
                        "check the folder and its permissions");
  }
  std::ranges::sort(files, {},
                    [](const FolderFile& file) { return std::tuple(file.modified_ns, file.name); });
  return files;
}

WatchedFolder::WatchedFolder(const FolderSource& source, const SessionPlan& plan)
    : source_(source) {
  // CheckPlan() has read each of them
  for (const std::string& text : plan.files_before) {
    if (auto file = ReadFolderFile(text)) ignored_.push_back(*std::move(file));
  }
}

std::string WatchedFolder::PathOf(const FolderFile& file) const {
  return fs::path(source_.folder) / file.name;
}

bool WatchedFolder::IsComplete(const FolderFile& file, MonotonicNs now_ns) {
  const auto [seen, is_new] = seen_.emplace(file.name, Seen{file, now_ns});
  if (!is_new && !IsSame(seen->second.file, file)) seen->second = {file, now_ns};
  return now_ns - seen->second.since_ns >= NsFromSeconds(source_.unchanged_s);
}

Result<std::optional<NewFile>> WatchedFolder::Examine(const SessionState& state,
                                                      MonotonicNs now_ns) {
  HAPTOMETER_LET(const auto files, FilesIn(source_));
  const std::vector<Imported> imported = ImportedFiles(state);
  pending_.clear();
  for (FolderFile file : files) {
    const auto is_same = [&](const FolderFile& other) { return IsSame(file, other); };
    if (std::ranges::any_of(ignored_, is_same) ||
        std::ranges::any_of(imported, is_same, &Imported::file)) {
      continue;
    }
    if (file.bytes == 0) {
      pending_ = Printable(file.name) + " is empty";
      continue;
    }
    // the first that is new decides: those behind it were written later
    if (!IsComplete(file, now_ns)) {
      pending_ = Printable(file.name) + " is still changing";
      return std::optional<NewFile>();
    }
    file.sha256 = document::Sha256Of(PathOf(file));
    const bool is_touched = std::ranges::any_of(imported, [&](const Imported& earlier) {
      return earlier.file.bytes == file.bytes && !file.sha256.empty() &&
             earlier.file.sha256 == file.sha256 && earlier.file.name == Printable(file.name);
    });
    if (is_touched) {
      ignored_.push_back(std::move(file));
      continue;
    }
    auto continued = ContinuedCell(file, PathOf(file), imported);
    return NewFile{.file = std::move(file), .continued = std::move(continued)};
  }
  return std::optional<NewFile>();
}

}  // namespace haptometer::tools
