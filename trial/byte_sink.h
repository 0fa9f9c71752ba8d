#pragma once

#include <cstddef>
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

/// What WriteSome() and Sync() of a file on disk also refuse (Cause::kFailed): a file that another
/// program has cut or deleted since. Nothing is appended behind a cut, where no reader would find
/// its beginning.

/// A new file at `path`, locked (flock) against a second writer as long as the sink lives.
///
/// Errors: Cause::kUsage when it exists and may not be replaced; Cause::kFailed when it cannot be
/// made, or is being written by another program.
[[nodiscard]] Result<std::unique_ptr<ByteSink>> CreateFileSink(const std::string& path,
                                                               IfExists if_exists);

/// The end of the existing file at `path`, locked in the same way.
///
/// Errors: Cause::kCannotAnswer when it cannot be opened for writing; Cause::kFailed when another
/// program is writing it.
[[nodiscard]] Result<std::unique_ptr<ByteSink>> OpenFileSinkAtEnd(const std::string& path);

}  // namespace haptometer::trial
