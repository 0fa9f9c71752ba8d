#include "tools/reproduce/passing_file.h"

#include <cstdio>
#include <span>

namespace haptometer::tools {
namespace {

class PassingFile : public trial::ByteSink {
 public:
  explicit PassingFile(const std::string& path)
      : path_(path), file_(std::fopen(path.c_str(), "wbx"), &std::fclose) {}

  Result<std::size_t> WriteSome(std::span<const std::byte> bytes) override {
    if (!file_) return Failed(path_, "could not be made", "is there room for temporary files?");
    const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), file_.get());
    if (written == 0) return Failed(path_, "could not be written", "is there room?");
    return written;
  }

  Result<void> Sync() override {
    if (file_ && std::fflush(file_.get()) == 0) return {};
    return Failed(path_, "could not be written", "is there room for temporary files?");
  }

 private:
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

}  // namespace

std::unique_ptr<trial::ByteSink> MakePassingFile(const std::string& path) {
  return std::make_unique<PassingFile>(path);
}

}  // namespace haptometer::tools
