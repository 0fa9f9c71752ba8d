#include "tools/plot/memory_file.h"

#include <fmt/core.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>

namespace haptometer::plot {

MemoryFile::MemoryFile(std::string_view content) : descriptor_(memfd_create("plot", MFD_CLOEXEC)) {
  while (!content.empty()) {
    const ssize_t put = write(descriptor_, content.data(), content.size());
    if (put <= 0) break;  // no memory: what is missing shows in the plot's absence
    content.remove_prefix(static_cast<std::size_t>(put));
  }
  lseek(descriptor_, 0, SEEK_SET);
}

MemoryFile::~MemoryFile() { close(descriptor_); }

std::string MemoryFile::path() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), descriptor_);
}

std::string MemoryFile::Content() const {
  std::string content;
  std::array<char, 4096> part{};
  for (off_t at = 0;;) {
    const ssize_t got = pread(descriptor_, part.data(), part.size(), at);
    if (got <= 0) return content;
    content.append(part.data(), static_cast<std::size_t>(got));
    at += got;
  }
}

}  // namespace haptometer::plot
