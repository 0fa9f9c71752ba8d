#include "tools/sweep/merge_tables.h"

#include <fmt/core.h>

#include <functional>
#include <queue>
#include <utility>

#include "tools/cli/output_file.h"
#include "tools/sweep/table_reader.h"

namespace haptometer::tools {
namespace {

// the next row of a table
struct Head {
  std::uint64_t point = 0;
  std::size_t table = 0;
  std::string row;

  bool operator>(const Head& other) const { return point > other.point; }
};

using Heads = std::priority_queue<Head, std::vector<Head>, std::greater<>>;

Result<std::vector<TableReader>> OpenAll(const std::vector<std::string>& tables) {
  std::vector<TableReader> readers;
  readers.reserve(tables.size());
  for (const std::string& path : tables) {
    auto reader = TableReader::Open(path);
    if (!reader) return std::unexpected(reader.error());
    if (!readers.empty()) {
      const std::string difference = DifferenceOf(reader->header(), readers.front().header());
      if (!difference.empty()) {
        return Usage(path, fmt::format("asks another question than {}: {}", tables[0], difference),
                     "merge the shards of one sweep");
      }
    }
    readers.push_back(*std::move(reader));
  }
  return readers;
}

// Brings the next row of a table into line.
Result<void> Advance(std::vector<TableReader>& readers, std::size_t table, Heads& heads) {
  TableReader& reader = readers[table];
  auto row = reader.Next();
  if (reader.ends_amid_row()) {
    return CannotAnswer(reader.path(), "ends amid a row", "go on with it by --resume first");
  }
  if (!row) return {};
  const auto point = PointOfRow(*row);
  if (!point || *point > reader.header().points || !reader.IsRow(*row)) {
    return CannotAnswer(reader.path(),
                        fmt::format("holds a row that was changed or is none: '{:.40}'", *row),
                        "go on with it by --resume, which computes such a row again");
  }
  heads.push({*point, table, *std::move(row)});
  return {};
}

Result<void> Missing(std::uint64_t point, const TableReader& reader) {
  return CannotAnswer(
      {}, fmt::format("point {} of {} is in none of the tables", point, reader.header().points),
      "give every shard, each gone on with to its end");
}

// All rows in their order, each point once.
Result<void> WriteRows(std::vector<TableReader>& readers, cli::OutputFile& whole) {
  constexpr std::size_t kPieceBytes = 1U << 16;
  std::string rows;
  Heads heads;
  for (std::size_t table = 0; table < readers.size(); ++table) {
    if (auto begun = Advance(readers, table, heads); !begun) return begun;
  }
  const std::uint64_t points = readers.front().header().points;
  std::uint64_t expected = 1;
  std::size_t last_table = 0;
  while (!heads.empty()) {
    const Head head = heads.top();
    heads.pop();
    if (head.point < expected) {
      return Usage(
          readers[head.table].path(),
          fmt::format("holds point {}, which {} holds too", head.point, readers[last_table].path()),
          "give every shard once");
    }
    if (head.point > expected) return Missing(expected, readers.front());
    rows += head.row + '\n';
    if (rows.size() >= kPieceBytes) {
      if (auto written = whole.Write(rows); !written) return written;
      rows.clear();
    }
    ++expected;
    last_table = head.table;
    if (auto next = Advance(readers, head.table, heads); !next) return next;
  }
  return expected > points ? whole.Write(rows) : Missing(expected, readers.front());
}

}  // namespace

Result<void> MergeTables(const std::vector<std::string>& tables, const std::string& output,
                         bool replace) {
  auto readers = OpenAll(tables);
  if (!readers) return std::unexpected(readers.error());
  auto file = cli::OutputFile::Begin(output, cli::kSweepTableOutput, replace);
  if (!file) return std::unexpected(file.error());
  TableHeader header = readers->front().header();
  header.shard.clear();
  if (auto written = file->Write(header.Text()); !written) return written;
  if (auto written = WriteRows(*readers, *file); !written) return written;
  return file->Finish();
}

}  // namespace haptometer::tools
