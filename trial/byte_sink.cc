#include "trial/byte_sink.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace haptometer::trial {
namespace {

class FileSink final : public ByteSink {
 public:
  explicit FileSink(int descriptor) : descriptor_(descriptor) {}
  ~FileSink() override { close(descriptor_); }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    // a signal (Ctrl-C) may interrupt a write before its first byte
    ssize_t written = -1;
    do {
      written = write(descriptor_, bytes.data(), bytes.size());
    } while (written < 0 && errno == EINTR);
    if (written <= 0) return Failed("", std::strerror(written < 0 ? errno : ENOSPC));
    return static_cast<std::size_t>(written);
  }

  Result<void> Sync() override {
    // pipes and character devices (/dev/null) cannot be synced and need not be
    if (fdatasync(descriptor_) == 0 || errno == EINVAL || errno == EROFS) return {};
    return Failed("", std::strerror(errno));
  }

 private:
  int descriptor_;
};

// keeps other writers out; the lock ends with the descriptor, also when the process is killed
Result<std::unique_ptr<ByteSink>> Locked(int descriptor, const std::string& path) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(descriptor);
    return Failed(path, "is being recorded by another program",
                  "wait for it to finish, or name another file");
  }
  return std::make_unique<FileSink>(descriptor);
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
  // emptied only once it is ours
  auto sink = Locked(opened, path);
  if (sink && ftruncate(opened, 0) != 0 && errno != EINVAL) {
    return Failed(path, std::string("cannot be emptied: ") + std::strerror(errno),
                  "name another file");
  }
  return sink;
}

Result<std::unique_ptr<ByteSink>> OpenFileSinkAtEnd(const std::string& path) {
  const int descriptor = open(path.c_str(), kAppendFlags);
  if (descriptor >= 0) return Locked(descriptor, path);
  return CannotAnswer(path, std::string("cannot be opened for writing: ") + std::strerror(errno),
                      "check the path and its permissions");
}

}  // namespace haptometer::trial
