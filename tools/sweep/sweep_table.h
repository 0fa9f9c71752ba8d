#pragma once

#include <atomic>
#include <cstdint>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "tools/document/provenance.h"
#include "tools/simulate/scene_answer.h"
#include "tools/sweep/sweep_question.h"

namespace haptometer::tools {

/// The first column: the point's number, from 1.
inline constexpr std::string_view kPointColumn = "point";

/// The last column: CRC-32 of what stands before it in its row, without the comma between.
inline constexpr std::string_view kChecksumColumn = "row_crc32";

/// What each line with the table's provenance begins with.
inline constexpr std::string_view kProvenance = "# provenance: ";

/// What stands above a table's rows: `# key = value` lines that name the question, lines with the
/// provenance, and a line of column names: point (from 1), the varied keys, the answer's numbers,
/// remark, row_crc32.
struct TableHeader {
  std::vector<std::string> question;  ///< the lines without the shard's, in order
  std::string shard;                  ///< "2/7"; empty: the whole
  std::string provenance;             ///< whole lines; no part of the question
  std::vector<std::string> columns;
  std::size_t varied = 0;    ///< columns of keys, behind the first
  std::uint64_t points = 0;  ///< of the whole sweep

  [[nodiscard]] std::string Text() const;
};

/// The header of the table that answers `question`. Apart from the provenance equal for equal
/// questions, whatever the directory, the number of threads and the order of lines in the scene.
[[nodiscard]] TableHeader HeaderOf(const SweepQuestion& question,
                                   const document::Provenance& provenance);

/// Where two headers part: "vary = a=1:2:3, not a=1:2:4"; empty: they ask the same, in whichever
/// shard.
[[nodiscard]] std::string DifferenceOf(const TableHeader& there, const TableHeader& here);

/// The beginning of a row, with the comma behind it: the point and its values.
[[nodiscard]] std::string RowBegin(std::uint64_t point, const std::vector<sim::SweepValue>& values);

/// A whole row with its checksum and line end. A point that cannot be answered has empty cells and
/// a remark.
[[nodiscard]] std::string RowOf(const SweepQuestion& question, std::uint64_t point);

/// Whether the last cell of a row, without its line end, is the checksum of what stands before it.
[[nodiscard]] bool MatchesChecksum(std::string_view row);

/// A number of a scene's answer as a column of a sweep's table.
struct AnswerColumn {
  std::string name;                                        ///< the key, behind run_ of a run
  std::optional<double> (*of)(const SceneAnswer& answer);  ///< empty: not in this answer
};

/// All columns of answers, in the order of the table.
[[nodiscard]] const std::vector<AnswerColumn>& AnswerColumns();

/// Rows that several threads make and one file takes in order.
struct RowWork {
  std::uint64_t first = 0;  ///< rows before it are there
  std::uint64_t count = 0;  ///< rows in all
  int threads = 1;          ///< >= 1
  /// Makes a row; called by several threads at once.
  std::function<std::string(std::uint64_t row)> make;
  /// Takes whole rows, in order, one call at a time; `done` are there then.
  std::function<Result<void>(std::string_view rows, std::uint64_t done)> write;
  const std::atomic<bool>* stop = nullptr;  ///< once true no further row is begun
};

/// Makes and writes the rows; returns how many are there in the end: all, unless it was stopped.
///
/// A thread takes up to 64 rows at a time and goes on without waiting for slower ones, up to 16 384
/// rows ahead of the first that is missing. What is written does not depend on `threads`. Errors:
/// of `write`; then no more is made.
[[nodiscard]] Result<std::uint64_t> MakeRowsInOrder(const RowWork& work);

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

/// Reads a table that `sweep` wrote, row by row; memory of one row, which ends at 1 MiB.
class TableReader {
 public:
  /// Errors (Cause::kCannotAnswer): no file, or none that begins as such a table, whole header and
  /// all.
  [[nodiscard]] static Result<TableReader> Open(const std::string& path);

  [[nodiscard]] const TableHeader& header() const { return header_; }
  [[nodiscard]] const std::string& path() const { return path_; }

  /// The next whole row, without its line end; nothing behind the last.
  [[nodiscard]] std::optional<std::string> Next();

  /// Whether `row` is one as this table's rows are written: with a cell a column, and with the
  /// checksum of its cells.
  [[nodiscard]] bool IsRow(const std::string& row) const;

  /// Whether the file ends amid a row: its writer was ended there.
  [[nodiscard]] bool ends_amid_row() const { return ends_amid_row_; }

  /// Bytes up to the end of the last row that Next() gave, or of the header.
  [[nodiscard]] std::uint64_t read_bytes() const { return read_bytes_; }

 private:
  explicit TableReader(const std::string& path);
  [[nodiscard]] Result<void> ReadHeader();

  std::string path_;
  std::ifstream file_;
  TableHeader header_;
  std::uint64_t read_bytes_ = 0;
  bool ends_amid_row_ = false;
};

/// The point of a row, from 1; nothing where it begins with no number.
[[nodiscard]] std::optional<std::uint64_t> PointOfRow(std::string_view row);

/// Joins the tables of shards into the table that one run would have written, byte for byte but for
/// the provenance, which is that of `command`; memory of one row a table.
///
/// Errors, with no file left: as cli::OutputFile for `output` (replaced where `replace` says so);
/// as TableReader for a table; Cause::kUsage for tables of different questions, with the
/// difference, and for a point that two of them hold; Cause::kCannotAnswer for a point that none
/// holds or a table that ends amid a row.
[[nodiscard]] Result<void> MergeTables(const std::vector<std::string>& tables,
                                       const std::string& output, bool replace,
                                       const std::vector<std::string>& command);

}  // namespace haptometer::tools
