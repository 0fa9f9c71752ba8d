#include "tools/sweep/table_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "tools/cli/csv_cell.h"
#include "tools/cli/output_file.h"

namespace haptometer::tools {
namespace {

constexpr MonotonicNs kSyncNs = kNsPerS;

// Whether the file ends within its header, in whichever command wrote it: then nothing was computed
// yet.
bool IsBegunOnly(const std::string& path, TableHeader header) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  header.provenance.clear();
  const std::string whole = header.Text();
  std::ifstream file(path, std::ios::binary);
  std::string text(kMostBytes, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  std::string begin;
  for (std::string_view left = text; !left.empty();) {
    const std::size_t end = left.find('\n');
    const std::string_view line = left.substr(0, end == left.npos ? end : end + 1);
    left.remove_prefix(line.size());
    // the last one may be cut
    const bool is_cut = end == std::string_view::npos;
    if (!line.starts_with(kProvenance) && !(is_cut && kProvenance.starts_with(line))) begin += line;
  }
  return begin.size() < whole.size() && whole.starts_with(begin);
}

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

// What stands in a table that is gone on with.
struct OldRows {
  std::uint64_t count = 0;
  std::vector<ChangedRow> changed;
};

// The rows that stand there, each as this question makes it, or changed since.
Result<OldRows> ReadOldRows(TableReader& reader, const SweepQuestion& question) {
  const std::uint64_t rows = question.shard.RowsOf(question.points.size());
  OldRows old;
  std::uint64_t begin = reader.read_bytes();
  for (auto line = reader.Next(); line; line = reader.Next(), ++old.count) {
    const std::uint64_t point = question.shard.PointOf(old.count);
    const bool is_ours = old.count < rows && reader.IsRow(*line) &&
                         line->starts_with(RowBegin(point, question.points.At(point)));
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

// The changed rows, computed again; each has to fit into its place.
Result<std::vector<std::string>> RowsAgain(const std::vector<ChangedRow>& changed,
                                           const SweepQuestion& question, const std::string& path) {
  std::vector<std::string> rows;
  for (const ChangedRow& old : changed) {
    rows.push_back(RowOf(question, question.shard.PointOf(old.row)));
    if (rows.back().size() == old.length) continue;
    return Usage(path, fmt::format("row {} was changed and has another length", old.row + 1),
                 "remove it and all rows below, then continue with --resume");
  }
  return rows;
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
  TableFile file(path, open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (file.descriptor_ < 0) {
    return Usage(path, std::string("cannot be written: ") + std::strerror(errno), "name another");
  }
  struct stat status{};
  if (fstat(file.descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    return Usage(path, "exists and is not a file", "name another");
  }
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
  // an older table keeps its place until the new one has begun
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
  if (auto part = begun->PathForLibrary(); !part) return std::unexpected(part.error());
  auto written = begun->Write(text);
  if (written) written = begun->Finish();
  if (!written) return std::unexpected(written.error());
  auto file = Open(path);
  if (!file) return file;
  if (auto cut = file->CutAt(text.size()); !cut) return std::unexpected(cut.error());
  return file;
}

Result<TableFile> TableFile::Resume(const std::string& path, const TableHeader& header,
                                    const SweepQuestion& question) {
  if (IsBegunOnly(path, header)) return Begin(path, header, true);
  auto file = Open(path);  // locked before it is read
  if (!file) return file;
  auto reader = TableReader::Open(path);
  if (!reader) return std::unexpected(reader.error());
  if (auto same = CheckQuestion(*reader, header); !same) return std::unexpected(same.error());
  const auto old = ReadOldRows(*reader, question);
  if (!old) return std::unexpected(old.error());
  const auto rows = RowsAgain(old->changed, question, path);
  if (!rows) return std::unexpected(rows.error());
  for (std::size_t k = 0; k < rows->size(); ++k) {
    if (auto put = file->PutAt(old->changed[k].begin, (*rows)[k]); !put) {
      return std::unexpected(put.error());
    }
  }
  file->rows_ = old->count;
  file->mended_rows_ = old->changed.size();
  if (auto cut = file->CutAt(reader->read_bytes()); !cut) return std::unexpected(cut.error());
  return file;
}

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
      // no part of a row is left behind
      if (ftruncate(descriptor_, end) != 0) { /* --resume cuts it off */
      }
      return Failed(path_, std::string("cannot be written: ") + std::strerror(failure),
                    "make room, then continue with --resume");
    }
    rows.remove_prefix(static_cast<std::size_t>(written));
  }
  const MonotonicNs now_ns = clock_.Now();
  if (now_ns - synced_ns_ < kSyncNs) return {};
  synced_ns_ = now_ns;
  return Finish();
}

Result<void> TableFile::Finish() {
  if (fdatasync(descriptor_) == 0) return {};
  return Failed(path_, std::string("is not safe on the disk: ") + std::strerror(errno),
                "make room, then continue with --resume");
}

namespace {

constexpr std::string_view kTitle = "# haptometer sweep ";
constexpr std::string_view kVary = "# vary = ";
constexpr std::string_view kPoints = "# points = ";
constexpr std::string_view kShard = "# shard = ";

constexpr std::size_t kMostRowBytes = std::size_t{1} << 20;

std::optional<std::uint64_t> LeadingCount(std::string_view text) {
  std::uint64_t count = 0;
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (failure != std::errc{}) return std::nullopt;
  return count;
}

}  // namespace

TableReader::TableReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {}

Result<TableReader> TableReader::Open(const std::string& path) {
  std::error_code none;
  if (!std::filesystem::exists(path, none)) return CannotAnswer(path, "no such file");
  TableReader reader(path);
  if (auto read = reader.ReadHeader(); !read) return std::unexpected(read.error());
  return reader;
}

Result<void> TableReader::ReadHeader() {
  const auto unknown = [&] {
    return CannotAnswer(path_, "is not a table of haptometer sweep", "give one that it wrote");
  };
  auto line = Next();
  if (!line || !line->starts_with(kTitle)) return unknown();
  for (; line && line->starts_with('#'); line = Next()) {
    if (line->starts_with(kProvenance)) {
      header_.provenance += *line + '\n';
      continue;
    }
    if (line->starts_with(kShard)) {
      header_.shard = line->substr(kShard.size());
      continue;
    }
    if (line->starts_with(kVary)) ++header_.varied;
    if (line->starts_with(kPoints)) {
      header_.points = LeadingCount(line->substr(kPoints.size())).value_or(0);
    }
    header_.question.push_back(*std::move(line));
  }
  if (!line) return unknown();
  header_.columns = cli::CellsOf(*line);
  const std::size_t columns = header_.columns.size();
  const bool is_known =
      header_.points > 0 && columns > header_.varied + 2 && header_.columns.front() == kPointColumn;
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
    // of a longer line only the beginning, which is no row
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
        return Usage(path,
                     fmt::format("belongs to another sweep than {}: {}", tables[0], difference),
                     "merge the shards of one sweep");
      }
    }
    NoteInput(path);
    readers.push_back(*std::move(reader));
  }
  return readers;
}

// Brings the next row of a table into line.
Result<void> Advance(std::vector<TableReader>& readers, std::size_t table, Heads& heads) {
  TableReader& reader = readers[table];
  auto row = reader.Next();
  if (reader.ends_amid_row()) {
    return CannotAnswer(reader.path(), "ends within a row", "continue it with --resume first");
  }
  if (!row) return {};
  const auto point = PointOfRow(*row);
  if (!point || *point > reader.header().points || !reader.IsRow(*row)) {
    return CannotAnswer(reader.path(),
                        fmt::format("holds a row that was changed or is none: '{:.40}'", *row),
                        "continue it with --resume, which computes such a row again");
  }
  heads.push({*point, table, *std::move(row)});
  return {};
}

Result<void> Missing(std::uint64_t point, const TableReader& reader) {
  return CannotAnswer(
      {}, fmt::format("point {} of {} is in none of the tables", point, reader.header().points),
      "give every shard, each run to its end");
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
                         bool replace, const std::vector<std::string>& command) {
  auto readers = OpenAll(tables);
  if (!readers) return std::unexpected(readers.error());
  auto file = cli::OutputFile::Begin(output, cli::kSweepTableOutput, replace);
  if (!file) return std::unexpected(file.error());
  TableHeader header = readers->front().header();
  header.shard.clear();
  header.provenance = document::CommentOf(document::CollectProvenance(command), kProvenance);
  if (auto written = file->Write(header.Text()); !written) return written;
  if (auto written = WriteRows(*readers, *file); !written) return written;
  return file->Finish();
}

}  // namespace haptometer::tools
