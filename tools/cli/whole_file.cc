#include "tools/cli/whole_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace haptometer::cli {
namespace {

namespace fs = std::filesystem;

std::unexpected<Error> Exists(const std::string& path) {
  return Usage(path, "already exists", "name another file, or say --overwrite");
}

bool SyncFile(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_synced = fsync(descriptor) == 0;
  close(descriptor);
  return is_synced;
}

}  // namespace

Result<WholeFile> WholeFile::Begin(const std::string& path, bool replace) {
  std::error_code ignored;
  const fs::path directory = fs::path(path).parent_path();
  if (!directory.empty() && !fs::is_directory(directory, ignored)) {
    return Usage(path, "lies in a directory that does not exist", "make it, or name another");
  }
  if (fs::exists(fs::symlink_status(path, ignored))) {
    if (!replace) return Exists(path);
    if (!fs::is_regular_file(path, ignored)) {
      return Usage(path, "is there and is no file", "name another");
    }
  }
  return WholeFile(path, replace);
}

WholeFile::WholeFile(std::string path, bool replace)
    : path_(std::move(path)),
      part_(fmt::format("{}.{}.part", path_, getpid())),
      replace_(replace) {}

WholeFile::WholeFile(WholeFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_(std::exchange(other.part_, {})),
      replace_(other.replace_) {}

WholeFile::~WholeFile() {
  if (!part_.empty()) unlink(part_.c_str());
}

Result<void> WholeFile::Finish() {
  if (!SyncFile(part_))
    return Failed(path_, std::string("is not written: ") + std::strerror(errno));
  const unsigned flags = replace_ ? 0 : RENAME_NOREPLACE;
  if (renameat2(AT_FDCWD, part_.c_str(), AT_FDCWD, path_.c_str(), flags) == 0) {
    part_.clear();
    return {};
  }
  if (errno == EEXIST) return Exists(path_);
  return Failed(path_, std::string("cannot take its name: ") + std::strerror(errno),
                "name a file on another disk");
}

Result<void> WriteWholeFile(const std::string& path, std::string_view content) {
  auto file = WholeFile::Begin(path, true);
  if (!file) return std::unexpected(file.error());
  std::FILE* const stream = std::fopen(file->part().c_str(), "we");
  if (stream == nullptr) {
    return Failed(path, std::string("cannot be written: ") + std::strerror(errno));
  }
  const bool is_written = std::fwrite(content.data(), 1, content.size(), stream) == content.size();
  const int failure = errno;
  if (std::fclose(stream) != 0 || !is_written) {
    return Failed(path,
                  std::string("cannot be written: ") + std::strerror(is_written ? errno : failure));
  }
  return file->Finish();
}

}  // namespace haptometer::cli
