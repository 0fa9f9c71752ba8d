#include "trial/import/table_cells.h"

#include <fmt/core.h>

#include <algorithm>

#include "trial/import/printed_number.h"

namespace haptometer::trial {
namespace {

// where the cell at the beginning of `line` ends: at a separator outside of quotes
std::size_t CellEnd(std::string_view line, char separator) {
  const std::size_t end = line.find(separator);
  if (end == std::string_view::npos) return end;
  const std::size_t open = line.find_first_not_of(" \t");
  if (open >= end || line[open] != '"') return end;
  const std::size_t close = line.find('"', open + 1);
  // a quote that nothing closes is a character like others
  return close == std::string_view::npos ? end : line.find(separator, close + 1);
}

bool HasOutsideQuotes(std::string_view line, char wanted) {
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == wanted && !is_quoted) return true;
  }
  return false;
}

std::string_view WithoutQuotes(std::string_view cell) {
  const bool is_quoted = cell.size() >= 2 && cell.starts_with('"') && cell.ends_with('"');
  return is_quoted ? Trimmed(cell.substr(1, cell.size() - 2)) : cell;
}

// where the cell at the beginning of `line` ends: at blanks outside of quotes and brackets
std::size_t CellEndAtBlanks(std::string_view line) {
  bool is_quoted = false;
  int open = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') is_quoted = !is_quoted;
    if (c == '(' || c == '[') ++open;
    if (c == ')' || c == ']') --open;
    if ((c != ' ' && c != '\t') || is_quoted || open > 0) continue;
    const std::size_t next = line.find_first_not_of(" \t", i);
    if (next == std::string_view::npos) return i;
    if (i == 0 || (line[next] != '(' && line[next] != '[')) return i;
  }
  return std::string_view::npos;
}

void SplitAtBlanks(std::string_view line, std::vector<std::string_view>* cells) {
  line = Trimmed(line);
  do {
    const std::size_t end = CellEndAtBlanks(line);
    cells->push_back(WithoutQuotes(line.substr(0, end)));
    line = end == std::string_view::npos ? "" : Trimmed(line.substr(end));
  } while (!line.empty());
}

// at most so many cells, whichever of the separators it is split at
std::size_t MostCells(std::string_view line) {
  if (line.size() < kMostColumns) return line.size() + 1;
  std::size_t cells = 0;
  for (const char separator : {',', ';', '\t'}) {
    const auto separators = static_cast<std::size_t>(std::ranges::count(line, separator));
    cells = std::max(cells, separators + 1);
  }
  return cells;
}

}  // namespace

Result<void> CheckLines(std::string_view text, const std::string& name) {
  std::size_t comments = 0;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const auto refuse = [&](std::string what) -> Result<void> {
      return CannotAnswer(fmt::format("{}: line {}", name, number), std::move(what),
                          "is it a table of measurements?");
    };
    if (line.size() > kMostLineBytes) {
      return refuse(fmt::format("is longer than {} MiB", kMostLineBytes >> 20));
    }
    if (MostCells(line) > kMostColumns) {
      return refuse(fmt::format("has more than {} columns", kMostColumns));
    }
    if (line.starts_with('#') && ++comments > kMostHeaderLines) {
      return refuse(fmt::format("is the last of more than {} comments", kMostHeaderLines));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

std::string_view LineWithTabs(std::string_view line) {
  constexpr std::string_view kBlanks = " \r";
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

void SplitCells(std::string_view line, char separator, std::vector<std::string_view>* cells) {
  cells->clear();
  if (separator == ' ') {
    SplitAtBlanks(line, cells);
    return;
  }
  for (;;) {
    const std::size_t end = CellEnd(line, separator);
    cells->push_back(WithoutQuotes(Trimmed(line.substr(0, end))));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

std::vector<std::string_view> SplitCells(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  SplitCells(line, separator, &cells);
  return cells;
}

TableCells CellsOf(std::string_view line) {
  if (HasOutsideQuotes(line, ';')) return {';', SplitCells(line, ';')};
  if (HasOutsideQuotes(line, '\t')) return {'\t', SplitCells(line, '\t')};
  TableCells by_commas{',', SplitCells(line, ',')};
  const bool has_blanks = Trimmed(line).find(' ') != std::string_view::npos;
  if (!has_blanks || IsNumbers(by_commas.cells)) return by_commas;
  TableCells by_blanks{' ', SplitCells(line, ' ')};
  const bool is_row = by_blanks.cells.size() > 1 && IsNumbers(by_blanks.cells);
  return is_row ? by_blanks : by_commas;
}

std::string_view NameOfSeparator(char separator) {
  if (separator == ';') return "semicolons";
  if (separator == '\t') return "tabs";
  return separator == ' ' ? "blanks" : "commas";
}

bool IsNumbers(const std::vector<std::string_view>& cells) {
  bool has_number = false;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool is_number = ReadNumberWithComma(cells[i]) || (i == 0 && ReadClock(cells[i]));
    if (!is_number && !ReadNoNumber(cells[i])) return false;
    has_number = has_number || is_number;
  }
  return has_number;
}

}  // namespace haptometer::trial
