#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "trial/trial_reader.h"

namespace haptometer::document {

using DataSource = trial::DataSource;  ///< of a recording by trial::SourcesOf()

/// A file that the command read.
struct InputFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::string sha256;  ///< 64 hexadecimal digits; empty: changed since it was read, or unreadable
};

/// How a result came about.
struct Provenance {
  std::string version{};
  std::string command{};  ///< as a shell takes it (tools/cli/terminal.h)
  std::string utc{};      ///< when the result was written, "2026-11-23T05:06:07Z"
  std::vector<InputFile> inputs{};
};

/// SHA-256 (FIPS 180-4) of bytes that come in pieces.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;
  void Add(std::string_view bytes);
  /// In hexadecimal, of all that was added; once.
  [[nodiscard]] std::string Hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// SHA-256 in hexadecimal of the file, or of its first bytes; empty where it cannot be
/// read or is shorter than a stated number of bytes. Some 0.5 s a GB.
[[nodiscard]] std::string Sha256Of(
    const std::string& path, std::uint64_t first_bytes = std::numeric_limits<std::uint64_t>::max());

/// Sha256Of a regular file, computed once for each state of it (device, inode, size, time of
/// change): CollectProvenance() takes it. Thread-safe.
[[nodiscard]] std::string HashOfInput(const std::string& path);

/// The same, where it is known from elsewhere of a file in this state.
void NoteHash(const struct stat& status, const std::string& sha256);

/// What computes: version, compiler, architecture, instruction set of the kernels, and the first 16
/// digits of the SHA-256 of the program or library that this code is in, read once.
[[nodiscard]] const std::string& ComputedBy();

/// Computes the SHA-256 of a regular file on a thread of its own, which ends before this object
/// does; CollectProvenance() takes the result. One at a time, in the thread that collects.
class HashAhead {
 public:
  explicit HashAhead(const std::string& path);
  ~HashAhead();
  HashAhead(const HashAhead&) = delete;
  HashAhead& operator=(const HashAhead&) = delete;
};

/// The provenance of what this process answers now: the inputs are those of base/input_file.h, in
/// the order in which they were noted. Reads each of them once more, some 0.5 s a GB.
[[nodiscard]] Provenance CollectProvenance(const std::vector<std::string>& command);

/// `provenance` as lines of a text, each behind `before`: version, UTC, command, a line for each
/// input.
[[nodiscard]] std::string CommentOf(const Provenance& provenance, std::string_view before);

}  // namespace haptometer::document
