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
      // empty cells alone are a blank line, too
      if (line.text.find_first_not_of(" \t;,") != std::string_view::npos) return line;
    }
    return std::nullopt;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t number_ = 0;
};

// the parts of `words` between two blanks or more
std::vector<std::string_view> SplitAtWideBlanks(std::string_view words) {
  std::vector<std::string_view> cells;
  for (words = Trimmed(words); !words.empty();) {
    const std::size_t end = words.find("  ");
    cells.push_back(Trimmed(words.substr(0, end)));
    words = end == std::string_view::npos ? "" : Trimmed(words.substr(end));
  }
  return cells;
}

void Keep(TableLine line, char separator, TableBeginning* found) {
  line.key = ReadTableKey(line.text, separator);
  if (line.key) {
    line.key->line = line.number + 1;
    found->keys.push_back(*line.key);
  }
  if (line.text.starts_with('#')) {
    found->comments.push_back(line.text);
    found->ends_in_comment = true;
  } else {
    found->ends_in_comment = false;
    found->above.push_back(std::move(line));
  }
}

}  // namespace

std::vector<std::string_view> TableBeginning::CellsOfWords(std::string_view words) const {
  auto cells = SplitCells(words, rows[0].separator);
  // above numbers between blanks names may have blanks of their own
  if (rows[0].separator == ' ' && cells.size() != width()) {
    for (const char other : {'\t', ';', ','}) {
      if (auto split = SplitCells(words, other); split.size() == width()) return split;
    }
    if (auto split = SplitAtWideBlanks(words); split.size() == width()) return split;
  }
  while (cells.size() > width() && cells.back().empty()) cells.pop_back();
  return cells;
}

std::vector<std::string_view> TableBeginning::Above(std::size_t back) const {
  if (back > above.size()) return {};
  return CellsOfWords(above[above.size() - back].text);
}

std::vector<std::string_view> TableBeginning::LastComment() const {
  if (comments.empty() || !ends_in_comment) return {};
  const std::size_t first = comments.back().find_first_not_of("# \t");
  return first == std::string_view::npos ? std::vector<std::string_view>{}
                                         : CellsOfWords(comments.back().substr(first));
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
  // a text without lines has no table
  if (found.width() == 0 || found.rows[1].cells.size() != found.width()) return std::nullopt;
  return found;
}

}  // namespace haptometer::trial
