#include "base/input_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <utility>

#include "base/mapped.h"

namespace haptometer {
namespace {

// files that the command has read, so that no output overwrites one of them
struct InputList {
  // device and inode: the same file under any name
  using Key = std::pair<dev_t, ino_t>;
  struct Numbered {
    std::size_t number = 0;  // in the order in which they were noted
    NotedInput file;
  };
  std::mutex mutex;
  std::size_t noted = 0;
  std::map<Key, Numbered> files;

  static Key KeyOf(const struct stat& status) { return {status.st_dev, status.st_ino}; }
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
  InputList& list = Noted();
  if (list.files.try_emplace(InputList::KeyOf(status), list.noted, NotedInput{path, status})
          .second) {
    ++list.noted;
  }
}

bool IsNotedInput(const struct stat& status) {
  const std::scoped_lock lock(Noted().mutex);
  return Noted().files.contains(InputList::KeyOf(status));
}

std::vector<NotedInput> NotedInputs() {
  const std::scoped_lock lock(Noted().mutex);
  std::vector<std::pair<std::size_t, NotedInput>> numbered;
  for (const auto& [key, one] : Noted().files) numbered.emplace_back(one.number, one.file);
  std::ranges::sort(numbered, {}, &std::pair<std::size_t, NotedInput>::first);
  return Mapped(numbered, &std::pair<std::size_t, NotedInput>::second);
}

void ForgetInput(const std::string& path) {
  struct stat status{};
  if (stat(path.c_str(), &status) != 0) return;
  const std::scoped_lock lock(Noted().mutex);
  Noted().files.erase(InputList::KeyOf(status));
}

void ForgetInputs() {
  const std::scoped_lock lock(Noted().mutex);
  Noted().files.clear();
}

std::unexpected<Error> DoesNotOpen(const std::string& path, int error_number) {
  const bool is_loop = error_number == ELOOP;
  return CannotAnswer(path, std::strerror(error_number),
                      is_loop ? "remove the link" : "check its permissions");
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
  if (!file) return DoesNotOpen(path, errno);
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
