#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.h"

namespace haptometer {

/// The whole content of a regular file.
///
/// Errors (Cause::kCannotAnswer): missing, a directory, unreadable, empty, larger than
/// `limit_bytes` (default 2 GiB). Memory: the file's size.
[[nodiscard]] Result<std::string> ReadInputFile(const std::string& path,
                                                std::uint64_t limit_bytes = 2ULL << 30);

/// The error (Cause::kCannotAnswer) of a file that is there and does not open, by its errno.
[[nodiscard]] std::unexpected<Error> DoesNotOpen(const std::string& path, int error_number);

/// Whatever opens a file to read what a command works on says so here, so that no output of the
/// same command takes the file's place, under whatever name: a file is its device and inode. Paths
/// without a regular file are let pass. Thread-safe; one stat.
void NoteInput(const std::string& path);

/// Whether the file of `status` (stat) was noted. Thread-safe.
[[nodiscard]] bool IsNotedInput(const struct stat& status);

/// A file that was noted: the first path that it had, and its state then.
struct NotedInput {
  std::string path;
  struct stat status{};
};

/// All that were noted, in the order in which they were. Thread-safe.
[[nodiscard]] std::vector<NotedInput> NotedInputs();

/// Of a file that the command wrote and read again: it is no input. Thread-safe; one stat.
void ForgetInput(const std::string& path);

/// Begins with no inputs: what a command does before anything else, where a process runs several.
void ForgetInputs();

}  // namespace haptometer
