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
  const bool is_known = header_.points > 0 && header_.columns.size() > header_.varied + 1 &&
                        header_.columns.front() == "point" && header_.columns.back() == "remark";
  if (!is_known) return unknown();
  return {};
}

std::optional<std::string> TableReader::Next() {
  std::string line;
  if (!std::getline(file_, line)) return std::nullopt;
  if (file_.eof()) {  // without a line end
    ends_amid_row_ = true;
    return std::nullopt;
  }
  read_bytes_ += line.size() + 1;
  return line;
}

std::optional<std::uint64_t> PointOfRow(std::string_view row) {
  const auto point = LeadingCount(row);
  if (point == std::uint64_t{0}) return std::nullopt;
  return point;
}

}  // namespace haptometer::tools
