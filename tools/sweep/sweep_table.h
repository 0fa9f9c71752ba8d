#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// What stands before the names of columns that `simulate --json` has under `run`.
inline constexpr std::string_view kOfRun = "run_";

/// A number of a scene's answer as a column of a sweep's table.
struct AnswerColumn {
  std::string name;                                        ///< the key, behind kOfRun of a run
  std::optional<double> (*of)(const SceneAnswer& answer);  ///< empty: not in this answer
};

/// All columns of answers, in the order of the table.
[[nodiscard]] const std::vector<AnswerColumn>& AnswerColumns();

/// What a row says although its point is answered; empty: nothing.
[[nodiscard]] std::string AnswerRemark(const SceneAnswer& answer);

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
/// A thread takes as many rows at a time as last about 5 ms (one at first, 256 at most) and goes on
/// without waiting for slower ones, up to 16 384 rows ahead of the first that is missing. What is
/// written depends neither on `threads` nor on the clock. Errors: of `write`; then no more is made.
[[nodiscard]] Result<std::uint64_t> MakeRowsInOrder(const RowWork& work);

}  // namespace haptometer::tools
