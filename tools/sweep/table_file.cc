#include "tools/sweep/table_file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

#include "tools/cli/output_file.h"
#include "tools/sweep/table_reader.h"

namespace haptometer::tools {
namespace {

constexpr MonotonicNs kSyncNs = kNsPerS;

// Whether the file ends within its header: then nothing was computed yet.
bool IsBegunOnly(const std::string& path, const std::string& header) {
  std::ifstream file(path, std::ios::binary);
  std::string begin(header.size(), '\0');
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(file.gcount()));
  return begin.size() < header.size() && header.starts_with(begin);
}

Result<void> CheckQuestion(const TableReader& reader, const TableHeader& header) {
  const std::string difference = DifferenceOf(reader.header(), header);
  if (!difference.empty()) {
    return Usage(reader.path(), "was begun with " + difference,
                 "name another file, or say --overwrite");
  }
  const auto said = [](const std::string& shard) { return shard.empty() ? "no" : shard; };
  if (reader.header().shard == header.shard) return {};
  return Usage(reader.path(),
               fmt::format("was begun with {} --shard, not {}", said(reader.header().shard),
                           said(header.shard)),
               "name another file, or say --overwrite");
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
                   "was it edited? name another file, or say --overwrite");
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
                 "remove it and all rows below, then go on with --resume");
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
    return Usage(path, "is there and is no file", "name another");
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
      error.remedy = "go on with it by --resume, name another file, or say --overwrite";
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
  if (IsBegunOnly(path, header.Text())) return Begin(path, header, true);
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
  return Failed(path_, std::string("cannot be mended: ") + std::strerror(errno),
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
                    "make room, then go on with --resume");
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
                "make room, then go on with --resume");
}

}  // namespace haptometer::tools
