#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "tools/simulate/scene_answer.h"
#include "tools/sweep/sweep_question.h"

namespace haptometer::tools {

/// The last column: CRC-32 of what stands before it in its row, without the comma between.
inline constexpr std::string_view kChecksumColumn = "row_crc32";

/// What stands above a table's rows: `# key = value` lines that name the question, and a line of
/// column names: point (from 1), the varied keys, the answer's numbers, remark, row_crc32.
struct TableHeader {
  std::vector<std::string> question;  ///< the lines without the shard's, in order
  std::string shard;                  ///< "2/7"; empty: the whole
  std::vector<std::string> columns;
  std::size_t varied = 0;    ///< columns of keys, behind the first
  std::uint64_t points = 0;  ///< of the whole sweep

  [[nodiscard]] std::string Text() const;
};

/// The header of the table that answers `question`. Equal for equal questions, whatever the
/// directory, the number of threads and the order of lines in the scene.
[[nodiscard]] TableHeader HeaderOf(const SweepQuestion& question);

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

}  // namespace haptometer::tools
