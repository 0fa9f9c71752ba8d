#include <fcntl.h>
#include <fmt/core.h>
#include <fmt/ranges.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/input_file.h"
#include "tools/cli/csv_cell.h"
#include "tools/cli/output_file.h"
#include "tools/sweep/sweep.h"

namespace haptometer::tools {
namespace {

// time between two syncs: a power failure loses about a second of rows
constexpr MonotonicNs kSyncNs = kNsPerS;

// whether the file ends within its header, of any command line: then no row was computed
bool IsBegunOnly(const std::string& path, TableHeader header) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  // a pipe would be waited for
  std::error_code none;
  if (std::filesystem::is_other(path, none)) return false;
  // provenance differs from run to run and is ignored in the comparison
  header.provenance.clear();
  const std::string whole = header.Text();
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  std::string begin;
  for (std::string_view left = text; !left.empty();) {
    // the file is compared line by line, without its lines of provenance
    const std::size_t end = left.find('\n');
    const std::string_view line = left.substr(0, end == left.npos ? end : end + 1);
    left.remove_prefix(line.size());
    // the last line may be incomplete
    const bool is_cut = end == std::string_view::npos;
    if (!line.starts_with(kProvenance) && !(is_cut && kProvenance.starts_with(line))) begin += line;
  }
  // shorter than a whole header: no row exists
  return begin.size() < whole.size() && whole.starts_with(begin);
}

// the same question (scene, keys, points, columns), then the same shard
Result<void> CheckQuestion(const TableReader& reader, const TableHeader& header) {
  const std::string difference = DifferenceOf(reader.header(), header);
  if (!difference.empty()) {
    return Usage(reader.path(), "was begun with " + difference,
                 "name another file, or give --overwrite");
  }
  const auto said = [](const std::string& shard) { return shard.empty() ? "no" : shard; };
  if (reader.header().shard == header.shard) return {};
  return Usage(reader.path(),
               fmt::format("was begun with {} --shard, not {}", said(reader.header().shard),
                           said(header.shard)),
               "name another file, or give --overwrite");
}

// a row that does not match its checksum
struct ChangedRow {
  std::uint64_t row = 0;    // from 0
  std::uint64_t begin = 0;  // its first byte in the file
  std::size_t length = 0;   // with its line end
};

// rows of a table that --resume continues
struct OldRows {
  std::uint64_t count = 0;
  std::vector<ChangedRow> changed;
};

// the rows of the table: each must be as this question makes it, or fail its checksum
Result<OldRows> ReadOldRows(TableReader& reader, const SweepQuestion& question) {
  const std::uint64_t rows = question.shard.RowsOf(question.points.size());
  OldRows old;
  std::uint64_t begin = reader.read_bytes();
  for (auto line = reader.Next(); line; line = reader.Next(), ++old.count) {
    // row k of a shard is the point shard.PointOf(k) of the sweep
    const std::uint64_t point = question.shard.PointOf(old.count);
    // point and varied values are compared; the numbers of the answer are protected by the checksum
    const bool is_ours = old.count < rows && reader.IsRow(*line) &&
                         line->starts_with(RowBegin(point, question.points.At(point)));
    // a checksum that does not match: damaged or edited, computed again
    const bool is_changed = old.count < rows && !MatchesChecksum(*line);
    if (!is_ours && !is_changed) {
      return Usage(reader.path(), fmt::format("row {} is not what this sweep makes", old.count + 1),
                   "was it edited? name another file, or give --overwrite");
    }
    if (!is_ours) old.changed.push_back({old.count, begin, line->size() + 1});
    begin = reader.read_bytes();
  }
  return old;
}

// the changed rows, computed again; each has to fit into its place
Result<std::vector<std::string>> RowsAgain(const std::vector<ChangedRow>& changed,
                                           const SweepQuestion& question, const std::string& path) {
  std::vector<std::string> rows;
  rows.reserve(changed.size());
  for (const ChangedRow& old : changed) {
    rows.push_back(RowOf(question, question.shard.PointOf(old.row)));
    // in place: another length would shift all rows behind it
    if (rows.back().size() == old.length) continue;
    return Usage(path, fmt::format("row {} was changed and has another length", old.row + 1),
                 "remove it and all rows below, then continue with --resume");
  }
  return rows;
}

constexpr std::string_view kVary = "# vary = ";
constexpr std::string_view kPoints = "# points = ";
constexpr std::string_view kShard = "# shard = ";
constexpr std::string_view kComputedBy = "# computed_by = ";

// longest row that is read: a file without line ends does not exhaust memory
constexpr std::size_t kMostRowBytes = std::size_t{1} << 20;

std::optional<std::uint64_t> LeadingCount(std::string_view text) {
  std::uint64_t count = 0;
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (failure != std::errc{}) return std::nullopt;
  return count;
}

// a table that is merged, with its next row
struct MergedTable {
  TableReader reader;
  std::string row{};
  std::uint64_t point = 0;  // of the row; 0: behind the last

  // the next row, which must be whole and of the table's sweep
  Result<void> Advance() {
    auto next = reader.Next();
    if (reader.ends_amid_row()) {
      return CannotAnswer(reader.path(), "ends within a row", "continue it with --resume first");
    }
    point = 0;
    if (!next) return {};
    row = *std::move(next);
    point = PointOfRow(row).value_or(0);
    if (point > 0 && point <= reader.header().points && reader.IsRow(row)) return {};
    return CannotAnswer(reader.path(),
                        fmt::format("holds a row that was changed or is none: '{:.40}'", row),
                        "continue it with --resume, which computes such a row again");
  }
};

// all tables must be of one question
Result<std::vector<MergedTable>> OpenAll(const std::vector<std::string>& paths,
                                         bool is_mixed_allowed) {
  std::vector<MergedTable> tables;
  tables.reserve(paths.size());
  for (const std::string& path : paths) {
    HAPTOMETER_LET(auto reader, TableReader::Open(path));
    if (!tables.empty()) {
      const std::string difference = DifferenceOf(reader.header(), tables.front().reader.header());
      if (!difference.empty()) {
        return Usage(path,
                     fmt::format("belongs to another sweep than {}: {}", paths[0], difference),
                     "merge the shards of one sweep");
      }
      const std::string& program = reader.header().computed_by;
      const std::string& first = tables.front().reader.header().computed_by;
      if (program != first && !is_mixed_allowed) {
        return Usage(path,
                     fmt::format("was computed by {}, but {} by {}", program, paths[0], first),
                     "compute all shards with one program, or give --allow-mixed");
      }
    }
    NoteInput(path);
    tables.push_back({.reader = std::move(reader)});
    HAPTOMETER_TRY(tables.back().Advance());
  }
  return tables;
}

// writes all rows in the order of the points, each point once
Result<void> WriteRows(std::vector<MergedTable>& tables, cli::OutputFile& whole) {
  constexpr std::size_t kPieceBytes = 1U << 16;
  std::string rows;
  const std::uint64_t points = tables.front().reader.header().points;
  const MergedTable* last = &tables.front();  // that of the point before
  for (std::uint64_t point = 1;; ++point) {
    // the table whose next row is the lowest
    const auto next = std::ranges::min_element(
        tables, {}, [](const MergedTable& table) { return table.point - 1; });
    if (next->point == 0 && point > points) return whole.Write(rows);
    // below the expected point: the same shard twice
    if (next->point > 0 && next->point < point) {
      return Usage(
          next->reader.path(),
          fmt::format("holds point {}, which {} holds too", next->point, last->reader.path()),
          "give every shard once");
    }
    // above it: a shard is missing or incomplete
    if (next->point != point) {
      return CannotAnswer({}, fmt::format("point {} of {} is in none of the tables", point, points),
                          "give every shard, each run to its end");
    }
    rows += next->row + '\n';
    if (rows.size() >= kPieceBytes) {
      HAPTOMETER_TRY(whole.Write(rows));
      rows.clear();
    }
    last = &*next;
    HAPTOMETER_TRY(next->Advance());
  }
}

}  // namespace

TableFile::TableFile(std::string path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor), synced_ns_(clock_.Now()) {}

TableFile::TableFile(TableFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      rows_(other.rows_),
      mended_rows_(other.mended_rows_),
      synced_ns_(other.synced_ns_) {}

TableFile::~TableFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

Result<TableFile> TableFile::Open(const std::string& path) {
  // O_RDWR: a pipe without a reader is not waited for
  TableFile file(path, open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (file.descriptor_ < 0) {
    return Usage(path, std::string("cannot be written: ") + std::strerror(errno), "name another");
  }
  struct stat status{};
  if (fstat(file.descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    return Usage(path, "exists and is not a file", "name another");
  }
  // one writer at a time; the lock ends with the descriptor
  if (flock(file.descriptor_, LOCK_EX | LOCK_NB) != 0) {
    return Usage(path, "is being written by another run", "wait for it, or name another file");
  }
  return file;
}

Result<void> TableFile::CutAt(std::uint64_t bytes) {
  const auto end = static_cast<off_t>(bytes);
  if (ftruncate(descriptor_, end) == 0 && lseek(descriptor_, end, SEEK_SET) == end) return {};
  return Failed(path_, std::string("cannot be cut: ") + std::strerror(errno));
}

Result<TableFile> TableFile::Begin(const std::string& path, const TableHeader& header,
                                   bool replace) {
  // an older table is replaced only when the header of the new one is complete
  const std::string text = header.Text();
  auto begun = cli::OutputFile::Begin(path, cli::kSweepTableOutput, replace);
  if (!begun) {
    Error error = begun.error();
    if (error.what == "already exists") {
      error.remedy = "continue it with --resume, name another file, or give --overwrite";
    }
    return std::unexpected(std::move(error));
  }
  // rows are appended to it, and read again for the summary
  HAPTOMETER_TRY(begun->PathForLibrary());
  auto written = begun->Write(text);
  if (written) written = begun->Finish();
  if (!written) return std::unexpected(written.error());
  // reopened under the lock, because OutputFile renames a temporary file
  HAPTOMETER_LET(auto file, Open(path));
  HAPTOMETER_TRY(file.CutAt(text.size()));
  return file;
}

// order: lock, check, recompute changed rows, then cut an incomplete last row
Result<TableFile> TableFile::Resume(const std::string& path, const TableHeader& header,
                                    const SweepQuestion& question, bool is_mixed_allowed) {
  if (IsBegunOnly(path, header)) return Begin(path, header, true);
  auto file = Open(path);  // locked before it is read
  if (!file) return file;
  HAPTOMETER_LET(auto reader, TableReader::Open(path));
  HAPTOMETER_TRY(CheckQuestion(reader, header));
  if (!is_mixed_allowed && reader.header().computed_by != header.computed_by) {
    return Usage(path,
                 fmt::format("was computed by {}, this is {}", reader.header().computed_by,
                             header.computed_by),
                 "continue it with that program, or give --allow-mixed");
  }
  HAPTOMETER_LET(const auto old, ReadOldRows(reader, question));
  HAPTOMETER_LET(const auto rows, RowsAgain(old.changed, question, path));
  // before the cut and before new rows, so that a second interruption leaves a valid table
  for (std::size_t k = 0; k < rows.size(); ++k) {
    HAPTOMETER_TRY(file->PutAt(old.changed[k].begin, rows[k]));
  }
  file->rows_ = old.count;
  file->mended_rows_ = old.changed.size();
  HAPTOMETER_TRY(file->CutAt(reader.read_bytes()));
  return file;
}

// at a fixed offset, without a change of the append position
Result<void> TableFile::PutAt(std::uint64_t begin, std::string_view row) {
  const auto written = pwrite(descriptor_, row.data(), row.size(), static_cast<off_t>(begin));
  if (written == static_cast<ssize_t>(row.size())) return {};
  return Failed(path_, std::string("cannot be repaired: ") + std::strerror(errno),
                "try again with --resume");
}

Result<void> TableFile::Append(std::string_view rows) {
  const off_t end = lseek(descriptor_, 0, SEEK_CUR);
  while (!rows.empty()) {
    const ssize_t written = write(descriptor_, rows.data(), rows.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int failure = errno;
      // an incomplete row is removed
      if (ftruncate(descriptor_, end) != 0) { /* --resume cuts it off */
      }
      return Failed(path_, std::string("cannot be written: ") + std::strerror(failure),
                    "make room, then continue with --resume");
    }
    rows.remove_prefix(static_cast<std::size_t>(written));
  }
  const MonotonicNs now_ns = clock_.Now();
  if (now_ns - synced_ns_ < kSyncNs) return {};
  // at most one sync per second
  synced_ns_ = now_ns;
  return Finish();
}

Result<void> TableFile::Finish() {
  if (fdatasync(descriptor_) == 0) return {};
  return Failed(path_, std::string("is not safe on the disk: ") + std::strerror(errno),
                "make room, then continue with --resume");
}

TableReader::TableReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {}

Result<TableReader> TableReader::Open(const std::string& path) {
  std::error_code none;
  if (!std::filesystem::exists(path, none)) return CannotAnswer(path, "no such file");
  TableReader reader(path);
  HAPTOMETER_TRY(reader.ReadHeader());
  return reader;
}

Result<void> TableReader::ReadHeader() {
  const auto unknown = [&] {
    return CannotAnswer(path_, "is not a table of haptometer sweep", "give one that it wrote");
  };
  auto line = Next();
  if (!line || !line->starts_with(kTableTitle)) return unknown();
  // comment lines: provenance and shard belong to a run, all others to the question
  for (; line && line->starts_with('#'); line = Next()) {
    if (line->starts_with(kProvenance)) {
      header_.provenance += *line + '\n';
      continue;
    }
    if (line->starts_with(kShard)) {
      header_.shard = line->substr(kShard.size());
      continue;
    }
    if (line->starts_with(kComputedBy)) {
      header_.computed_by = line->substr(kComputedBy.size());
      continue;
    }
    if (line->starts_with(kVary)) ++header_.varied;
    if (line->starts_with(kPoints)) {
      header_.points = LeadingCount(line->substr(kPoints.size())).value_or(0);
    }
    header_.question.push_back(*std::move(line));
  }
  if (!line) return unknown();
  if (header_.computed_by.empty()) header_.computed_by = "a program that its table does not name";
  header_.columns = cli::CellsOf(*line);
  const std::size_t columns = header_.columns.size();
  // point, varied keys, at least one number, checksum
  const bool is_known =
      header_.points > 0 && columns > header_.varied + 2 && header_.columns.front() == kPointColumn;
  // tables of older versions end with "remark"
  if (is_known && header_.columns.back() == "remark") {
    return CannotAnswer(path_, "was made by an older version, without checksums of its rows",
                        "make it again");
  }
  if (!is_known || header_.columns.back() != kChecksumColumn) return unknown();
  return {};
}

std::optional<std::string> TableReader::Next() {
  std::string line;
  std::uint64_t bytes = 0;
  for (int c = file_.get(); c != std::ifstream::traits_type::eof(); c = file_.get()) {
    ++bytes;
    if (c == '\n') {
      read_bytes_ += bytes;
      return line;
    }
    // only the beginning of a longer line is stored; it has no valid checksum
    if (line.size() < kMostRowBytes) line += static_cast<char>(c);
  }
  ends_amid_row_ = !line.empty();
  return std::nullopt;
}

bool TableReader::IsRow(const std::string& row) const {
  return cli::CellsOf(row).size() == header_.columns.size() && MatchesChecksum(row);
}

std::optional<std::uint64_t> PointOfRow(std::string_view row) {
  const auto point = LeadingCount(row);
  if (point == std::uint64_t{0}) return std::nullopt;
  return point;
}

Result<void> MergeTables(const std::vector<std::string>& tables, const SweepWords& words) {
  HAPTOMETER_LET(auto merged, OpenAll(tables, words.is_mixed_allowed));
  HAPTOMETER_LET(auto file,
                 cli::OutputFile::Begin(words.output, cli::kSweepTableOutput, words.overwrite));
  // the merged table has no shard, all programs, and the provenance of this command
  TableHeader header = merged.front().reader.header();
  header.shard.clear();
  std::vector<std::string> programs;
  for (const MergedTable& table : merged) {
    const std::string& program = table.reader.header().computed_by;
    if (std::ranges::count(programs, program) == 0) programs.push_back(program);
  }
  header.computed_by = fmt::format("{}", fmt::join(programs, "; "));
  header.provenance = document::CommentOf(document::CollectProvenance(words.command), kProvenance);
  HAPTOMETER_TRY(file.Write(header.Text()));
  HAPTOMETER_TRY(WriteRows(merged, file));
  return file.Finish();
}

}  // namespace haptometer::tools
