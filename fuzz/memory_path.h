#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <string_view>

#include "fuzz/require.h"

namespace haptometer::fuzz {

/// A file in memory, for code that reads a path; gone with this object.
class MemoryPath {
 public:
  explicit MemoryPath(std::string_view content) : descriptor_(memfd_create("fuzz", MFD_CLOEXEC)) {
    Require(descriptor_ >= 0);
    while (!content.empty()) {
      const ssize_t written = write(descriptor_, content.data(), content.size());
      Require(written > 0);
      content.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  ~MemoryPath() { close(descriptor_); }
  MemoryPath(const MemoryPath&) = delete;
  MemoryPath& operator=(const MemoryPath&) = delete;

  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace haptometer::fuzz
