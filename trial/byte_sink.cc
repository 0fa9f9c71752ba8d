#include "trial/byte_sink.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace haptometer::trial {
namespace {

class FileSink final : public ByteSink {
 public:
  FileSink(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {
    struct stat status{};
    is_regular_ = fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode);
    size_ = kept_ = is_regular_ ? status.st_size : 0;
  }
  ~FileSink() override { close(descriptor_); }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    if (auto whole = CheckWhole(); !whole) return std::unexpected(whole.error());
    // a signal (Ctrl-C) may interrupt a write before its first byte
    ssize_t written = -1;
    do {
      written = write(descriptor_, bytes.data(), bytes.size());
    } while (written < 0 && errno == EINTR);
    if (written <= 0) return Failed("", std::strerror(written < 0 ? errno : ENOSPC));
    size_ += written;
    return static_cast<std::size_t>(written);
  }

  Result<void> Sync() override {
    if (auto whole = CheckWhole(); !whole) return whole;
    // pipes and character devices (/dev/null) cannot be synced and need not be
    if (fdatasync(descriptor_) == 0 || errno == EINVAL || errno == EROFS) return {};
    return Failed("", std::strerror(errno));
  }

  void Keep() override { kept_ = size_; }

  void CutToKept() override {
    // never longer than it is: that would be a hole
    struct stat status{};
    if (!is_regular_ || fstat(descriptor_, &status) != 0 || status.st_size <= kept_) return;
    if (ftruncate(descriptor_, kept_) == 0) size_ = kept_;
  }

  std::string MovedTo() const override {
    struct stat ours{};
    struct stat there{};
    if (!is_regular_ || fstat(descriptor_, &ours) != 0) return {};
    const bool is_there = stat(path_.c_str(), &there) == 0 && there.st_ino == ours.st_ino &&
                          there.st_dev == ours.st_dev;
    if (is_there) return {};
    std::error_code error;
    const auto now =
        std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", descriptor_), error);
    return error ? "another place" : now.string();
  }

 private:
  // whether the file is still the one that was written, and as long
  Result<void> CheckWhole() {
    struct stat status{};
    if (!is_regular_ || fstat(descriptor_, &status) != 0) return {};
    if (status.st_nlink == 0) {
      return Failed("", "another program deleted or replaced the file",
                    "nothing of it is kept: record it again");
    }
    if (status.st_size < size_) {
      return Failed(
          "",
          fmt::format("another program cut the file from {} to {} bytes", size_, status.st_size),
          "only what lies before the cut is kept: record it again");
    }
    size_ = status.st_size;
    return {};
  }

  int descriptor_;
  std::string path_;
  bool is_regular_ = false;
  off_t size_ = 0;  ///< of the file, when it was last looked at or written
  off_t kept_ = 0;  ///< of it, what is whole
};

// keeps other writers out; the lock ends with the descriptor, also when the process is killed
Result<std::unique_ptr<ByteSink>> Locked(int descriptor, const std::string& path,
                                         bool is_emptied = false) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor);
    return Failed(path, "is being recorded by another program",
                  "wait for it to finish, or name another file");
  }
  // emptied only once it is ours
  if (is_emptied && ftruncate(descriptor, 0) != 0 && errno != EINVAL) {
    const int reason = errno;
    close(descriptor);
    return Failed(path, std::string("cannot be emptied: ") + std::strerror(reason),
                  "name another file");
  }
  return std::make_unique<FileSink>(descriptor, path);
}

constexpr int kAppendFlags = O_WRONLY | O_APPEND | O_CLOEXEC;

}  // namespace

Result<std::unique_ptr<ByteSink>> CreateFileSink(const std::string& path, IfExists if_exists) {
  // made exclusively first, so that nothing is lost between a look and the opening
  const int made = open(path.c_str(), kAppendFlags | O_CREAT | O_EXCL, 0666);
  if (made >= 0) return Locked(made, path);
  if (errno != EEXIST) {
    return Failed(path, std::string("cannot be created: ") + std::strerror(errno),
                  "name a file in a directory that exists and that you may write to");
  }
  if (if_exists == IfExists::kRefuse) {
    return Usage(path, "already exists", "name another file, or say --overwrite");
  }
  const int opened = open(path.c_str(), kAppendFlags);
  if (opened < 0) {
    return Failed(path, std::string("cannot be replaced: ") + std::strerror(errno),
                  "name another file");
  }
  return Locked(opened, path, true);
}

Result<std::unique_ptr<ByteSink>> OpenFileSinkAtEnd(const std::string& path) {
  const int descriptor = open(path.c_str(), kAppendFlags);
  if (descriptor >= 0) return Locked(descriptor, path);
  return CannotAnswer(path, std::string("cannot be opened for writing: ") + std::strerror(errno),
                      "check the path and its permissions");
}

}  // namespace haptometer::trial
