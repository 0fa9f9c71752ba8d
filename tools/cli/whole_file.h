#pragma once

#include <string>
#include <string_view>

#include "base/result.h"

namespace haptometer::cli {

/// A file that is written under another name beside its place and takes its own name only when it
/// is whole, so that a full disk costs no older file.
class WholeFile {
 public:
  /// Errors (Cause::kUsage): `path` exists and `replace` is false, or is no regular file, or its
  /// directory does not exist.
  [[nodiscard]] static Result<WholeFile> Begin(const std::string& path, bool replace);

  WholeFile(WholeFile&& other) noexcept;
  WholeFile& operator=(WholeFile&&) = delete;
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  /// Removes what was not finished.
  ~WholeFile();

  /// Where to write: a name in the same directory, unlike that of any other program running.
  [[nodiscard]] const std::string& part() const { return part_; }

  /// Syncs the part and gives it its name. Errors: Cause::kFailed when the disk fails;
  /// Cause::kUsage when a file has come to be at the path meanwhile that may not be replaced.
  [[nodiscard]] Result<void> Finish();

 private:
  WholeFile(std::string path, bool replace);

  std::string path_;
  std::string part_;
  bool replace_;
};

/// Writes `content` to `path` as a WholeFile, in the place of an older file.
/// Errors: as Begin with `replace`, and Finish.
[[nodiscard]] Result<void> WriteWholeFile(const std::string& path, std::string_view content);

}  // namespace haptometer::cli
