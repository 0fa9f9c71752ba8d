#include "tools/reproduce/temporary_folder.h"

#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

namespace haptometer::tools {

namespace fs = std::filesystem;

Result<TemporaryFolder> TemporaryFolder::Make() {
  std::error_code failure;
  const fs::path parent = fs::temp_directory_path(failure);
  std::string name = parent / "haptometer-XXXXXX";
  if (failure || mkdtemp(name.data()) == nullptr) {
    return Failed(parent, "no temporary folder could be made", "is there room, or set TMPDIR");
  }
  return TemporaryFolder(name);
}

TemporaryFolder::TemporaryFolder(fs::path path) : path_(std::move(path)) {}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace haptometer::tools
