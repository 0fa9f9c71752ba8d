#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/error.h"

namespace haptometer::trial {

/// Where a trial's bytes go; injected, so that full disks and short writes are tested in memory.
class ByteSink {
 public:
  virtual ~ByteSink() = default;

  /// Appends some of `bytes` (at least one) and returns how many; fewer than given is no error.
  /// Errors: Cause::kFailed ("could not be written: No space left on device").
  [[nodiscard]] virtual Result<std::size_t> WriteSome(std::span<const std::byte> bytes) = 0;

  /// Returns when what was written survives a loss of power. Errors: Cause::kFailed.
  [[nodiscard]] virtual Result<void> Sync() = 0;

  /// What was written so far is whole.
  virtual void Keep() {}
  /// Takes away what was written since Keep(), as the part of a block that met a full disk.
  virtual void CutToKept() {}
  /// The path of the file where it is no longer at the one it was opened by; empty where it is.
  [[nodiscard]] virtual std::string MovedTo() const { return {}; }
};

/// Whether an existing file is an error or loses its content.
enum class IfExists { kRefuse, kReplace };

/// Opens what is at `path` for appending; `name` stands for it in messages. A pipe that no program
/// reads is refused, where open() would wait for its reader.
///
/// Errors: Cause::kUsage for such a pipe, Cause::kFailed where it cannot be opened.
[[nodiscard]] Result<int> OpenForAppending(const std::string& path, const std::string& name);

/// What WriteSome() and Sync() of a file on disk also refuse (Cause::kFailed): a file that another
/// program has cut or deleted since. Nothing is appended behind a cut, where no reader would find
/// its beginning.

/// A new file at `path`, locked (flock) against a second writer as long as the sink lives.
///
/// Errors: Cause::kUsage when it exists and may not be replaced, or is a pipe that no program
/// reads; Cause::kFailed when it cannot be made, or is being written by another program.
[[nodiscard]] Result<std::unique_ptr<ByteSink>> CreateFileSink(const std::string& path,
                                                               IfExists if_exists);

/// The end of the existing file at `path`, locked in the same way.
///
/// Errors: Cause::kCannotAnswer when it cannot be opened for writing; Cause::kFailed when another
/// program is writing it.
[[nodiscard]] Result<std::unique_ptr<ByteSink>> OpenFileSinkAtEnd(const std::string& path);

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

/// CRC-32 as in zlib, PNG and Ethernet (polynomial 0xEDB88320, start and final xor 0xFFFFFFFF).
///
/// Of 64 bytes and more, from AVX2 on (base/instruction_set.h), the message is folded modulo the
/// polynomial (V. Gopal et al., Fast CRC Computation for Generic Polynomials Using
/// PCLMULQDQ Instruction, Intel 2009), of 256 bytes and more in lanes four times as wide where it
/// can; zlib does the rest, and everything elsewhere. Cost: 15 or 70 ps a byte from the cache,
/// zlib's 150 ps.
[[nodiscard]] std::uint32_t Crc32(std::span<const std::byte> bytes);

}  // namespace haptometer::trial
