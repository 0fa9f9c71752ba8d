#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "tools/session/session_log.h"
#include "tools/session/session_source.h"

namespace haptometer::tools {

/// A file of another program, as it was found.
struct FolderFile {
  std::string name;  ///< within the folder
  std::uint64_t bytes = 0;
  std::int64_t modified_ns = 0;  ///< since 1970, by the file system
  std::string sha256{};          ///< 64 hexadecimal digits; empty: not computed
};

/// "SHA-256 HEX, 12345 bytes, modified NS, NAME", without the hash where it is not known. One
/// printable line.
[[nodiscard]] std::string TextOf(const FolderFile& file);
/// The same read; nothing of any other text. The name is as it is printed.
[[nodiscard]] std::optional<FolderFile> ReadFolderFile(std::string_view text);

/// The regular files of the folder whose names match the pattern, by time of modification, then by
/// name. Errors (Cause::kCannotAnswer): the folder cannot be read.
[[nodiscard]] Result<std::vector<FolderFile>> FilesIn(const FolderSource& source);

/// How long one examination of a folder is apart from the next.
inline constexpr MonotonicNs kExamineEveryNs = kNsPerS / 5;

/// A file that is complete and was not imported before.
struct NewFile {
  FolderFile file;
  /// It begins with all of an imported file of its name, which was not complete: a new attempt of
  /// that one's cell.
  std::optional<SessionCell> continued{};
};

/// Finds the files of a folder that are to become trials, each of them once.
///
/// Not taken: what was there when the session was made (SessionPlan::files_before), and what a
/// finished attempt was imported from: the same name and size with the same time of modification or
/// the same SHA-256. A file is complete when size and time of modification have not changed for
/// FolderSource::unchanged_s of the monotonic clock; an empty one is not. The first in the order of
/// FilesIn() is waited for, so files get their cells in the order in which they were written.
class WatchedFolder {
 public:
  WatchedFolder(const FolderSource& source, const SessionPlan& plan);

  /// Examines the folder; nothing where no file is complete. `state` has the attempts so far.
  /// Cost: one stat a file; reads a complete file once. Errors: as FilesIn.
  [[nodiscard]] Result<std::optional<NewFile>> Examine(const SessionState& state,
                                                       MonotonicNs now_ns);

  /// What no trial can be made of yet, in words: "run1.csv is still changing", or that it is empty;
  /// empty where there is nothing.
  [[nodiscard]] const std::string& pending() const { return pending_; }
  [[nodiscard]] const FolderSource& source() const { return source_; }

 private:
  struct Seen {
    FolderFile file;
    MonotonicNs since_ns = 0;
  };

  [[nodiscard]] bool IsComplete(const FolderFile& file, MonotonicNs now_ns);
  [[nodiscard]] std::string PathOf(const FolderFile& file) const;

  FolderSource source_;
  std::vector<FolderFile> ignored_;   // there before the session, or imported under another time
  std::map<std::string, Seen> seen_;  // by name
  std::string pending_;
};

}  // namespace haptometer::tools
