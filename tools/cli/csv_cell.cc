#include "tools/cli/csv_cell.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace haptometer::cli {
namespace {

constexpr std::string_view kBlanks = " \t\r";

bool IsNumber(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return NumberFrom<double>(text).has_value();
}

// whether a spreadsheet would read `text` as a formula, behind its apostrophes if any
bool BeginsFormula(std::string_view text) {
  // with the full-width forms, which spreadsheets accept too
  constexpr std::array<std::string_view, 8> kSigns{"=", "+", "-", "@", "＝", "＋", "－", "＠"};
  text.remove_prefix(std::min(text.find_first_not_of('\''), text.size()));
  return std::ranges::any_of(kSigns, [&](std::string_view sign) { return text.starts_with(sign); });
}

// separators of both dialects, quotes, and blanks that a reader would cut
bool NeedsQuotes(std::string_view cell) {
  return !cell.empty() && (cell.find_first_of(",;\"") != std::string_view::npos ||
                           cell.front() == ' ' || cell.back() == ' ');
}

// a cell while its line is read
struct Cell {
  std::string text;
  std::size_t quoted = 0;  // length up to the last closing quote: blanks in it are kept

  // blanks before an opening quote are not part of the cell
  void Open() {
    if (quoted == 0 && text.find_first_not_of(kBlanks) == std::string::npos) text.clear();
  }
  std::string Finished() {
    while (text.size() > quoted && kBlanks.find(text.back()) != std::string_view::npos) {
      text.pop_back();
    }
    if (quoted == 0) text.erase(0, text.find_first_not_of(kBlanks));
    // the apostrophe that CellOf() puts before a formula
    if (text.starts_with('\'') && BeginsFormula(text)) text.erase(0, 1);
    return std::move(text);
  }
};

}  // namespace

std::string CellOf(std::string_view text) {
  std::string cell = Printable(text);
  // a negative number begins with '-' and is no formula
  if (BeginsFormula(cell) && !IsNumber(cell)) cell.insert(0, 1, '\'');
  if (!NeedsQuotes(cell)) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

std::vector<std::string> CellsOf(std::string_view line) {
  std::vector<std::string> cells;
  Cell cell;
  bool in_quotes = false;
  for (std::size_t at = 0; at < line.size(); ++at) {
    const char c = line[at];
    // a doubled quote within quotes is one quote (RFC 4180, 2.7)
    if (c == '"' && in_quotes && at + 1 < line.size() && line[at + 1] == '"') {
      cell.text += line[++at];
    } else if (c == '"') {
      in_quotes = !in_quotes;
      if (in_quotes) {
        cell.Open();
      } else {
        cell.quoted = cell.text.size();
      }
    } else if (c == ',' && !in_quotes) {
      cells.push_back(cell.Finished());
      cell = {};
    } else {
      cell.text += c;
    }
  }
  cells.push_back(cell.Finished());
  return cells;
}

}  // namespace haptometer::cli
