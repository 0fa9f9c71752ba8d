#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/clock.h"
#include "base/error.h"
#include "tools/sweep/sweep_table.h"

namespace haptometer::tools {

/// The table of a sweep while it is written: whole rows in their order, so that at any moment the
/// file is the beginning of the finished one, perhaps with a part of a row behind it, and a run
/// that was ended, by whatever means, can be gone on with.
class TableFile {
 public:
  /// Begins a table with its header as a cli::OutputFile, so that an older one goes (if `replace`)
  /// once the new one is there. Errors: as cli::OutputFile.
  [[nodiscard]] static Result<TableFile> Begin(const std::string& path, const TableHeader& header,
                                               bool replace);

  /// Goes on with the table at `path`, or begins it where there is none or not a whole header. What
  /// stands behind its last whole row is cut off. A row that does not match its checksum is
  /// computed again and put in its place.
  /// Errors: as Begin; Cause::kUsage for a table of another question or shard, with the difference,
  /// and for rows that this question does not make, or that were changed in their length.
  [[nodiscard]] static Result<TableFile> Resume(const std::string& path, const TableHeader& header,
                                                const SweepQuestion& question);

  TableFile(TableFile&& other) noexcept;
  TableFile& operator=(TableFile&&) = delete;
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;
  ~TableFile();

  /// Rows that were there.
  [[nodiscard]] std::uint64_t rows() const { return rows_; }

  /// Of them those that did not match their checksums and were computed again.
  [[nodiscard]] std::uint64_t mended_rows() const { return mended_rows_; }

  /// Writes whole rows, and syncs the disk about once a second. Errors (Cause::kFailed): the
  /// disk's; what was written of `rows` is cut off again.
  [[nodiscard]] Result<void> Append(std::string_view rows);

  /// Syncs what was written. Errors (Cause::kFailed): the disk's.
  [[nodiscard]] Result<void> Finish();

 private:
  TableFile(std::string path, int descriptor);
  [[nodiscard]] static Result<TableFile> Open(const std::string& path);
  [[nodiscard]] Result<void> CutAt(std::uint64_t bytes);
  [[nodiscard]] Result<void> PutAt(std::uint64_t begin, std::string_view row);

  std::string path_;
  int descriptor_;
  std::uint64_t rows_ = 0;
  std::uint64_t mended_rows_ = 0;
  SystemClock clock_;
  MonotonicNs synced_ns_;
};

}  // namespace haptometer::tools
