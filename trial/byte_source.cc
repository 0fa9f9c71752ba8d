#include "trial/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/input_file.h"

namespace haptometer::trial {
namespace {

class FileSource final : public ByteSource {
 public:
  FileSource(int descriptor, std::uint64_t size, std::string path)
      : descriptor_(descriptor), size_(size), path_(std::move(path)) {}
  ~FileSource() override { close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  std::uint64_t size() const override { return size_; }

  Result<std::size_t> ReadAt(std::uint64_t offset, std::span<std::byte> into) const override {
    std::size_t done = 0;
    while (done < into.size()) {
      const ssize_t got = pread(descriptor_, into.data() + done, into.size() - done,
                                static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) {
        return CannotAnswer(path_, std::string("cannot be read: ") + std::strerror(errno),
                            "check the disk");
      }
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return done;
  }

 private:
  int descriptor_;
  std::uint64_t size_;
  std::string path_;
};

class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::string bytes) : bytes_(std::move(bytes)) {}

  std::uint64_t size() const override { return bytes_.size(); }

  Result<std::size_t> ReadAt(std::uint64_t offset, std::span<std::byte> into) const override {
    if (offset >= bytes_.size() || into.empty()) return std::size_t{0};
    const std::size_t count = std::min<std::size_t>(into.size(), bytes_.size() - offset);
    std::memcpy(into.data(), bytes_.data() + offset, count);
    return count;
  }

 private:
  std::string bytes_;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> OpenFileSource(const std::string& path) {
  // not blocking, so that a named pipe without a writer is refused rather than waited for
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) {
    if (errno == ENOENT) return CannotAnswer(path, "no such file", "check the path");
    return CannotAnswer(path, std::strerror(errno), "check its permissions");
  }
  struct stat status{};
  auto refuse = [&](const char* what, const char* remedy) {
    close(descriptor);
    return CannotAnswer(path, what, remedy);
  };
  if (fstat(descriptor, &status) != 0) return refuse("cannot be examined", "check the disk");
  if (S_ISDIR(status.st_mode)) return refuse("is a directory", "name a file in it");
  if (!S_ISREG(status.st_mode)) return refuse("is not a regular file", "save it to a file first");
  if (status.st_size == 0) return refuse("is empty", "was the recording interrupted?");
  NoteInput(path);
  return std::make_unique<FileSource>(descriptor, static_cast<std::uint64_t>(status.st_size), path);
}

std::unique_ptr<ByteSource> MakeMemorySource(std::string bytes) {
  return std::make_unique<MemorySource>(std::move(bytes));
}

}  // namespace haptometer::trial
