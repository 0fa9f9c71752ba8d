#include "trial/import/table_beginning.h"

#include <algorithm>
#include <utility>

#include "trial/import/printed_number.h"

namespace haptometer::trial {
namespace {

// no preamble is longer, so that a book is not searched for numbers
constexpr std::size_t kMostLinesAbove = 1000;

// the lines of a text that are not blank, one after another
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  std::optional<TableLine> Next() {
    while (at_ < text_.size() && number_ < kMostLinesAbove) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      TableLine line{
          .text = LineWithTabs(text_.substr(at_, end - at_)), .offset = at_, .number = number_};
      at_ = end + 1;
      ++number_;
      if (!Trimmed(line.text).empty()) return line;
    }
    return std::nullopt;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
};

void Keep(TableLine line, char separator, TableBeginning* found) {
  line.key = ReadTableKey(line.text, separator);
  if (line.key) {
    line.key->line = line.number + 1;
    found->keys.push_back(*line.key);
  }
  if (line.text.starts_with('#')) {
    found->comments.push_back(line.text);
  } else {
    found->above.push_back(std::move(line));
  }
}

}  // namespace

std::vector<std::string_view> TableBeginning::Above(std::size_t back) const {
  if (back > above.size()) return {};
  auto cells = SplitCells(above[above.size() - back].text, rows[0].separator);
  while (cells.size() > width() && cells.back().empty()) cells.pop_back();
  return cells;
}

std::optional<TableBeginning> FindTableBeginning(std::string_view text) {
  TableBeginning found;
  std::optional<TableLine> last;  // a line of numbers whose like has not come yet
  Lines lines(text);
  while (auto line = lines.Next()) {
    TableCells cells = CellsOf(line->text);
    if (line->text.starts_with('#') || !IsNumbers(cells.cells)) {
      if (last) Keep(*std::exchange(last, std::nullopt), cells.separator, &found);
      Keep(*std::move(line), cells.separator, &found);
      continue;
    }
    if (last && found.rows[0].separator == cells.separator &&
        found.rows[0].cells.size() == cells.cells.size()) {
      found.rows[1] = std::move(cells);
      found.offset = last->offset;
      found.line = last->number;
      return found;
    }
    if (last) Keep(*last, cells.separator, &found);
    last = *line;
    found.rows[0] = std::move(cells);
  }
  return std::nullopt;
}

std::optional<TableBeginning> FindSideTable(std::string_view text, std::size_t first) {
  TableBeginning found;
  Lines lines(text);
  for (std::size_t n = 0; n < 32; ++n) {
    const auto line = lines.Next();
    if (!line) break;
    TableCells cells = CellsOf(line->text);
    const bool is_row = cells.cells.size() > first + 1 && ReadNumberWithComma(cells.cells[first]);
    if (!is_row && n < 2) return std::nullopt;
    if (n < 2) found.rows[n] = cells;
    if (!is_row || cells.cells[0].empty() || cells.cells[1].empty()) continue;
    found.keys.push_back({cells.cells[0], {cells.cells[1]}, line->number + 1});
  }
  if (found.rows[1].cells.size() != found.width()) return std::nullopt;
  return found;
}

}  // namespace haptometer::trial
