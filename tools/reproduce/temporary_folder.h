#pragma once

#include <filesystem>

#include "base/error.h"

namespace haptometer::tools {

/// A folder of its own below the system's for temporary files, which goes with all it holds.
class TemporaryFolder {
 public:
  /// Errors (Cause::kFailed): it cannot be made.
  [[nodiscard]] static Result<TemporaryFolder> Make();

  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::filesystem::path path);

  std::filesystem::path path_;  // empty: handed on
};

}  // namespace haptometer::tools
