#pragma once

#include <string>
#include <string_view>

namespace haptometer::plot {

/// A file that exists in memory only, as long as this object does.
class MemoryFile {
 public:
  /// With `content`, at its start.
  explicit MemoryFile(std::string_view content = {});
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  [[nodiscard]] int descriptor() const { return descriptor_; }
  /// Under which a program that we start can open it.
  [[nodiscard]] std::string path() const;
  [[nodiscard]] std::string Content() const;

 private:
  int descriptor_;
};

}  // namespace haptometer::plot
