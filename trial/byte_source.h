#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/error.h"

namespace haptometer::trial {

/// Bytes that are read from any place; injected, so that every cut and every flipped bit is tested
/// in memory.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Size when it was opened.
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Fills `into` from `offset` as far as there are bytes, and returns how many.
  /// Errors: Cause::kCannotAnswer (the disk cannot be read).
  [[nodiscard]] virtual Result<std::size_t> ReadAt(std::uint64_t offset,
                                                   std::span<std::byte> into) const = 0;
};

/// The regular file at `path`, read with pread: a file that shrinks meanwhile gives fewer bytes,
/// where a mapped one would kill the reader.
/// Errors (Cause::kCannotAnswer): missing, a directory, not a regular file, empty, unreadable.
[[nodiscard]] Result<std::unique_ptr<ByteSource>> OpenFileSource(const std::string& path);

/// Bytes in memory, copied.
[[nodiscard]] std::unique_ptr<ByteSource> MakeMemorySource(std::string bytes);

}  // namespace haptometer::trial
