#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "tools/document/document.h"
#include "tools/sweep/sweep_table.h"

namespace haptometer::tools {

/// Which row is the best one.
struct BestWish {
  std::string column = "skin_rms_m";
  bool least = false;  ///< the smallest number instead of the largest
};

/// Reads "skin_rms_m" or "power_w:least". Errors (Cause::kUsage): no such column of answers.
[[nodiscard]] Result<BestWish> ReadBestWish(const std::string& word);

/// The best row of a table.
struct BestRow {
  double value = 0;
  std::uint64_t point = 0;          ///< from 1
  std::vector<std::string> values;  ///< of the varied keys
};

/// What a table comes to.
struct SweepSummary {
  std::string table;
  TableHeader header;
  BestWish wish;
  std::uint64_t rows = 0;
  std::uint64_t answered = 0;     ///< rows with at least one number
  std::uint64_t compared = 0;     ///< rows with a number in the wished column
  std::string first_remark{};     ///< of a row that is not answered, with its point
  std::optional<BestRow> best{};  ///< the first of equals; nothing where the column is empty
  std::uint64_t mended = 0;       ///< rows that did not match their checksums
  std::string plot{};             ///< path; empty: none
};

/// Reads the table again, row by row. Errors: as TableReader.
[[nodiscard]] Result<SweepSummary> Summarise(const std::string& table, const BestWish& wish);

/// The summary as a document; a refusal where no point is answered.
[[nodiscard]] document::Document SweepDocument(const SweepSummary& summary);

/// Whether a sweep can be drawn: one or two varied keys, the whole and not a shard, and a path that
/// a plot can be written to. Errors (Cause::kUsage), to be asked before the work.
[[nodiscard]] Result<void> CheckPicture(const std::string& path, const TableHeader& header);

/// Draws `column` of the table at `table` over its varied keys: one key as a curve; two of a grid
/// as curves, one for each value of the key that has fewer, up to 8, else as a map by colour where
/// both are evenly spaced numbers (else 8 of the curves); sampled ones as points over each key.
/// Memory: two numbers a point. Errors: as plot::DrawPanels; Cause::kCannotAnswer where nothing is
/// answered.
[[nodiscard]] Result<void> DrawSweep(const std::string& path, const std::string& table,
                                     const std::string& column);

}  // namespace haptometer::tools
