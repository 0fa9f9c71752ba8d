#include "base/input_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>

namespace haptometer {
namespace {

// files that the command has read, so that no output overwrites one of them
struct InputList {
  std::mutex mutex;
  std::vector<NotedInput> files;

  [[nodiscard]] auto Find(const struct stat& status) const {
    // device and inode: the same file under any name
    return std::ranges::find_if(files, [&](const NotedInput& file) {
      return file.status.st_dev == status.st_dev && file.status.st_ino == status.st_ino;
    });
  }
  [[nodiscard]] bool Has(const struct stat& status) const { return Find(status) != files.end(); }
};

InputList& Noted() {
  static InputList noted;
  return noted;
}

}  // namespace

void NoteInput(const std::string& path) {
  struct stat status{};
  // only regular files can be overwritten
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return;
  const std::scoped_lock lock(Noted().mutex);
  if (!Noted().Has(status)) Noted().files.push_back({path, status});
}

bool IsNotedInput(const struct stat& status) {
  const std::scoped_lock lock(Noted().mutex);
  return Noted().Has(status);
}

std::vector<NotedInput> NotedInputs() {
  const std::scoped_lock lock(Noted().mutex);
  return Noted().files;
}

void ForgetInput(const std::string& path) {
  struct stat status{};
  if (stat(path.c_str(), &status) != 0) return;
  const std::scoped_lock lock(Noted().mutex);
  if (const auto found = Noted().Find(status); found != Noted().files.end()) {
    Noted().files.erase(found);
  }
}

void ForgetInputs() {
  const std::scoped_lock lock(Noted().mutex);
  Noted().files.clear();
}

Result<std::string> ReadInputFile(const std::string& path, std::uint64_t limit_bytes) {
  namespace fs = std::filesystem;
  std::error_code failure;
  // std::ifstream does not distinguish these two errors
  const fs::file_status status = fs::status(path, failure);
  if (status.type() == fs::file_type::not_found) {
    return CannotAnswer(path, "no such file", "check the path");
  }
  if (status.type() == fs::file_type::directory) {
    return CannotAnswer(path, "is a directory", "name a file in it");
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return CannotAnswer(path, std::strerror(errno), "check its permissions");
  NoteInput(path);
  // in pieces, because pipes and /dev files have no size to ask for
  std::string content;
  char piece[1 << 16];
  while (file.read(piece, sizeof piece) || file.gcount() > 0) {
    content.append(piece, static_cast<std::size_t>(file.gcount()));
    if (content.size() > limit_bytes) {
      return CannotAnswer(
          path, fmt::format("is larger than {} MiB", limit_bytes >> 20),
          "is it the file that was meant? give a recording as trial.bin, which is read in parts");
    }
  }
  if (file.bad()) return CannotAnswer(path, "could not be read to its end", "check the disk");
  if (content.empty()) return CannotAnswer(path, "is empty", "was it written to its end?");
  return content;
}

}  // namespace haptometer
