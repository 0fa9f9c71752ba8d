#include "tools/study/text_table.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "base/input_file.h"
#include "base/mapped.h"
#include "base/quantity.h"
#include "base/text.h"
#include "tools/cli/csv_cell.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::tools {
namespace {

std::string AsText(std::string_view cell) { return std::string(cell); }

// 16 MiB and 4096 columns: limits of what is read into memory
constexpr std::uint64_t kMostBytes = 1ULL << 24;
constexpr std::size_t kMostNames = 4096;

// cells of a user's file may contain control characters: made printable
std::vector<std::string> PrintableCellsOf(std::string_view line, char separator) {
  std::vector<std::string> cells = cli::CellsOf(line);
  if (separator != ',') cells = Mapped<std::string>(trial::SplitCells(line, separator), AsText);
  for (std::string& cell : cells) cell = Printable(cell);
  return cells;
}

Result<void> TakeNames(const std::vector<std::string>& names, TextTable* table) {
  for (const std::string& name : names) {
    if (!table->columns.emplace(name, std::vector<std::string>{}).second) {
      return CannotAnswer(table->name, fmt::format("has two columns {}", name), "rename one");
    }
  }
  return {};
}

Result<void> TakeRow(const std::vector<std::string>& names, std::string_view line,
                     std::size_t number, TextTable* table) {
  std::vector<std::string> cells = PrintableCellsOf(line, table->separator);
  if (cells.size() != names.size()) {
    return CannotAnswer(fmt::format("{}:{}", table->name, number),
                        fmt::format("has {} cells, the header {}", cells.size(), names.size()),
                        "correct that line");
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    table->columns[names[i]].push_back(std::move(cells[i]));
  }
  table->lines.push_back(number);
  return {};
}

// required columns, with the most similar name for typing errors
Result<void> CheckColumns(const TextTable& table, const std::vector<std::string>& names,
                          const std::vector<std::string>& required) {
  for (const std::string& column : required) {
    if (table.columns.contains(column)) continue;
    const std::string nearest = Nearest(column, names);
    // the same quantity: rms_um for rms_m
    if (nearest.contains('_') &&
        nearest.substr(0, nearest.rfind('_')) == column.substr(0, column.rfind('_'))) {
      return CannotAnswer(table.name, fmt::format("has no column {}", column),
                          fmt::format("convert its column {} to the unit of {}, and call it that",
                                      nearest, column));
    }
    return CannotAnswer(table.name, fmt::format("has no column {}", column),
                        nearest.empty()
                            ? fmt::format("its header needs {}", fmt::join(required, ","))
                            : fmt::format("is it the column {}?", nearest));
  }
  return {};
}

}  // namespace

Result<TextTable> ReadTextTable(const std::string& path, const std::vector<std::string>& required) {
  HAPTOMETER_LET(const auto text, ReadInputFile(path, kMostBytes));
  TextTable table;
  table.name = path;
  std::vector<std::string> names;
  std::string storage;
  std::string_view rest = trial::Utf8Text(text, &storage);
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string_view whole = rest.substr(0, rest.find('\n'));
    // a tab at the beginning separates an empty cell
    const std::string_view line =
        table.separator == '\t' ? trial::LineWithTabs(whole) : trial::Trimmed(whole);
    rest.remove_prefix(std::min(rest.size(), rest.find('\n')));
    if (!rest.empty()) rest.remove_prefix(1);
    // empty lines and comments count as lines of the file, so that errors name the right one
    if (line.starts_with('#') && names.empty()) table.comments.push_back(Printable(line));
    if (trial::Trimmed(line).empty() || line.starts_with('#')) continue;
    const auto is_separator = [](char c) { return c == ',' || c == ';' || c == '\t'; };
    if (static_cast<std::size_t>(std::ranges::count_if(line, is_separator)) > kMostNames) {
      return CannotAnswer(fmt::format("{}:{}", path, number),
                          fmt::format("has more than {} columns", kMostNames),
                          "is it a table of one row a line?");
    }
    // the first line is the header
    if (names.empty()) {
      table.separator = trial::CellsOf(line).separator;
      names = PrintableCellsOf(line, table.separator);
      HAPTOMETER_TRY(TakeNames(names, &table));
      continue;
    }
    HAPTOMETER_TRY(TakeRow(names, line, number, &table));
  }
  HAPTOMETER_TRY(CheckColumns(table, names, required));
  if (table.lines.empty()) return CannotAnswer(path, "holds no row", "give a line a trial");
  return table;
}

// whether all numbers of a column that have a point would be thousands too: "1.234" or "-12.000"
bool HasThousands(const std::vector<std::string>& cells) {
  const auto is_thousands = [](std::string_view cell) {
    if (cell.starts_with('-') || cell.starts_with('+')) cell.remove_prefix(1);
    const std::size_t point = cell.find('.');
    return point >= 1 && point <= 3 && !cell.starts_with('0') && cell.size() - point == 4;
  };
  const auto has_point = [](const std::string& cell) { return cell.contains('.'); };
  return std::ranges::any_of(cells, has_point) &&
         std::ranges::all_of(cells, [&](const std::string& cell) {
           return !has_point(cell) || is_thousands(cell);
         });
}

// Where a comma is the decimal sign, a point is none: refused is a column with both, and one whose
// points may separate thousands beside another with commas.
Result<void> CheckDecimals(const TextTable& table, const std::string& column) {
  const std::vector<std::string>& cells = table.columns.at(column);
  const auto with = [](const std::vector<std::string>& of, char sign) {
    return std::ranges::find_if(of, [&](const std::string& cell) { return cell.contains(sign); });
  };
  const auto point = with(cells, '.');
  if (point == cells.end()) return {};
  const bool has_comma = with(cells, ',') != cells.end();
  const bool is_beside = std::ranges::any_of(table.columns, [&](const auto& other) {
    return with(other.second, ',') != other.second.end();
  });
  // where commas separate cells, those of another column may stand in a text in quotes
  const bool may_be_thousands = table.separator != ',' && is_beside && HasThousands(cells);
  if (!has_comma && !may_be_thousands) return {};
  const std::size_t line = table.lines[static_cast<std::size_t>(point - cells.begin())];
  return CannotAnswer(fmt::format("{}:{}", table.name, line),
                      fmt::format("{} '{}' has a point beside decimal commas, which may separate "
                                  "thousands",
                                  column, *point),
                      "write numbers without separators of thousands, all with one decimal sign");
}

// numbers of a column, finite and within the range of quantities
Result<std::vector<double>> NumbersOf(const TextTable& table, const std::string& column) {
  HAPTOMETER_TRY(CheckDecimals(table, column));
  const std::vector<std::string>& cells = table.columns.at(column);
  std::vector<double> numbers(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    // in quotes between commas, "1,02" has a decimal comma; "1,234" may have grouped thousands
    const bool may_group = table.separator == ',' && trial::MayGroupThousands(cells[i], ',');
    const auto number = may_group ? std::nullopt : trial::ReadNumberWithComma(cells[i]);
    numbers[i] = number.value_or(std::nan(""));
    if (!std::isfinite(numbers[i])) {
      return CannotAnswer(fmt::format("{}:{}", table.name, table.lines[i]),
                          fmt::format("{} '{}' is not a number", column, cells[i]),
                          "correct that cell");
    }
    if (!PossibleQuantity({numbers[i], 0}, Dimension::kNone, column)) {
      return CannotAnswer(fmt::format("{}:{}", table.name, table.lines[i]),
                          fmt::format("{} '{}' is beyond any measurement", column, cells[i]),
                          "correct that cell");
    }
  }
  return numbers;
}

Result<std::optional<std::vector<double>>> FindColumn(const TextTable& table,
                                                      std::span<const KnownColumn> known) {
  std::optional<std::vector<double>> found;
  std::string_view name;
  for (const KnownColumn& column : known) {
    if (!table.columns.contains(std::string(column.name))) continue;
    if (found) {
      return CannotAnswer(table.name, fmt::format("has both {} and {}", name, column.name),
                          "leave one out");
    }
    HAPTOMETER_LET(auto numbers, NumbersOf(table, std::string(column.name)));
    for (double& number : numbers) number *= column.factor;
    found = std::move(numbers);
    name = column.name;
  }
  return found;
}

}  // namespace haptometer::tools
