#include "tools/sweep/table_reader.h"

#include <charconv>
#include <filesystem>

#include "base/input_file.h"
#include "tools/cli/csv_cell.h"

namespace haptometer::tools {
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
  NoteInput(path);
  TableReader reader(path);
  if (auto read = reader.ReadHeader(); !read) return std::unexpected(read.error());
  return reader;
}

Result<void> TableReader::ReadHeader() {
  const auto unknown = [&] {
    return CannotAnswer(path_, "is no table of haptometer sweep", "give one that it wrote");
  };
  auto line = Next();
  if (!line || !line->starts_with(kTitle)) return unknown();
  for (; line && line->starts_with('#'); line = Next()) {
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
      header_.points > 0 && columns > header_.varied + 2 && header_.columns.front() == "point";
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

}  // namespace haptometer::tools
