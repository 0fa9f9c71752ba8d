#include "trial/import/table/foreign_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "trial/import/table/instrument_layouts.h"
#include "trial/import/table/named_columns.h"

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

// whether no bracket of "Position (x,y)" stands without its other half
bool HasWholeBrackets(std::string_view cell) {
  const auto is_one_of = [](std::string_view signs) {
    return [signs](char c) { return signs.contains(c); };
  };
  return std::ranges::count_if(cell, is_one_of("([")) ==
         std::ranges::count_if(cell, is_one_of(")]"));
}

// keeps a line above the numbers, as key, comment or line of words
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
  // names above numbers that are separated by blanks may contain blanks: another separator that
  // gives as many cells is the better one
  if (rows[0].separator == ' ') {
    for (const char other : {'\t', ';', ','}) {
      auto split = SplitCells(words, other);
      if (split.size() == width() && std::ranges::all_of(split, HasWholeBrackets)) return split;
    }
  }
  auto cells = SplitCells(words, rows[0].separator);
  if (rows[0].separator == ' ' && cells.size() != width()) {
    if (auto split = SplitAtWideBlanks(words); split.size() == width()) return split;
  }
  // separators at the end of a header line make no names
  while (cells.size() > width() && cells.back().empty()) cells.pop_back();
  return cells;
}

std::vector<std::string_view> TableBeginning::Above(std::size_t back) const {
  if (back > above.size()) return {};
  return CellsOfWords(above[above.size() - back].text);
}

// the last comment, if it stands directly above the numbers, without its #
std::vector<std::string_view> TableBeginning::LastComment() const {
  if (comments.empty() || !ends_in_comment) return {};
  const std::size_t first = comments.back().find_first_not_of("# \t");
  return first == std::string_view::npos ? std::vector<std::string_view>{}
                                         : CellsOfWords(comments.back().substr(first));
}

namespace {

// Whether a line is a header of column numbers, as pandas writes them where no names are given:
// 0, 1, 2, ... above a row of numbers that are not whole. Without a cell for the index before them
// they may be a reading: then they are a header only in the first line (`is_first`) and where a
// number below differs by 1 or more.
bool AreColumnNumbers(const TableCells& line, const TableCells& row, bool is_first) {
  const std::size_t first = line.cells[0].empty() ? 1 : 0;
  if (first == 0 && !is_first) return false;
  bool is_apart = first == 1 && line.cells.size() > 1;
  for (std::size_t i = first; i < line.cells.size(); ++i) {
    const bool is_whole = row.cells[i].find_first_not_of("+-0123456789") == std::string_view::npos;
    if (line.cells[i] != std::to_string(i - first) || is_whole) return false;
    const double number = static_cast<double>(i - first);
    is_apart |= std::abs(ReadNumberWithComma(row.cells[i]).value_or(number) - number) >= 1;
  }
  return is_apart;
}

}  // namespace

// a table begins at two lines of numbers with the same separator and the same number of cells
std::optional<TableBeginning> FindTableBeginning(std::string_view text) {
  TableBeginning found;
  std::optional<TableLine> last;  // a line of numbers whose like has not come yet
  Lines lines(text);
  while (auto line = lines.Next()) {
    TableCells cells = CellsOf(line->text);
    // a line of numbers without a like one below it belongs to the words above
    if (line->text.starts_with('#') || !IsNumbers(cells.cells)) {
      if (last) Keep(*std::exchange(last, std::nullopt), cells.separator, &found);
      Keep(*std::move(line), cells.separator, &found);
      continue;
    }
    if (last && found.rows[0].separator == cells.separator &&
        found.rows[0].cells.size() == cells.cells.size() &&
        !AreColumnNumbers(found.rows[0], cells, found.above.empty())) {
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

// a table with keys in its first columns and numbers from column `first` on
std::optional<TableBeginning> FindSideTable(std::string_view text, std::size_t first) {
  TableBeginning found;
  Lines lines(text);
  // keys are searched in the first 32 lines
  for (std::size_t n = 0; n < 32; ++n) {
    const auto line = lines.Next();
    if (!line) break;
    TableCells cells = CellsOf(line->text);
    const bool is_row = cells.cells.size() > first + 1 && ReadNumberWithComma(cells.cells[first]);
    if (!is_row && n < 2) return std::nullopt;
    // the first two lines must be rows; keys are taken from rows only
    if (n < 2) found.rows[n] = cells;
    if (!is_row || cells.cells[0].empty() || cells.cells[1].empty()) continue;
    found.keys.push_back({cells.cells[0], {cells.cells[1]}, line->number + 1});
  }
  // a text without lines has no table
  if (found.width() == 0 || found.rows[1].cells.size() != found.width()) return std::nullopt;
  return found;
}

namespace {

// a channel's name without case, blanks and underscores, as a user may type it
std::string Typed(std::string_view name) {
  std::string typed = LowerCase(name);
  std::erase_if(typed, [](char c) { return c == ' ' || c == '_'; });
  return typed;
}

// the names of the value columns, for messages
std::string NamesOf(const std::vector<CsvColumn>& columns) {
  std::string names;
  for (const CsvColumn& column : columns) {
    if (column.kind != CsvColumnKind::kValue) continue;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", column.name);
  }
  return names;
}

// the lines above that name no columns, as fields and notes
void KeepWords(const TableBeginning& beginning, std::size_t lines_used, ForeignTable* table) {
  for (std::size_t i = 0; i + lines_used < beginning.above.size(); ++i) {
    const TableLine& line = beginning.above[i];
    const bool is_pair = line.key && line.key->values.size() == 1 &&
                         line.key->key.find('=') == std::string_view::npos;
    // under a prefix, because a key of this program has another meaning
    if (is_pair) {
      table->fields["table." + std::string(line.key->key)] = line.key->values[0];
    } else {
      table->notes.emplace_back(line.text);
    }
  }
}

// sets role, SI unit and factor of the channels that a user's scale applies to
Result<void> ApplyScale(std::optional<double> scale, ChannelRole role,
                        std::vector<CsvColumn>* columns) {
  if (!scale) return {};
  const auto is_value = [](const CsvColumn& c) { return c.kind == CsvColumnKind::kValue; };
  // a scale for displacement is no reason to scale a voltage, except where it is the only channel
  const bool is_alone = std::ranges::count_if(*columns, is_value) == 1;
  bool is_used = false;
  for (CsvColumn& column : *columns) {
    // a single channel without a stated quantity is meant, too
    const bool is_meant = column.role == role || (is_alone && column.role == ChannelRole::kOther);
    if (!is_value(column) || !is_meant) continue;
    column.role = role;
    column.unit = role == ChannelRole::kVoltage ? "V" : "m";
    column.factor = *scale;
    is_used = true;
  }
  if (is_used) return {};
  return Usage("<scale>", fmt::format("is about a {}, and no column is one", Name(role)),
               fmt::format("say <columns> time_s,{}", Name(role)));
}

// finds table, columns and clock of a file of another program
class Finder {
 public:
  Finder(std::string_view text, const std::string& name, const ImportOptions& options)
      : text_(text), name_(name), options_(options) {
    table_.format = options.format.value_or(FindTableFormat(text));
  }

  Result<std::optional<ForeignTable>> Find() {
    // Tektronix TDS files have the keys beside the first rows, not above
    const bool is_beside = table_.format == TableFormat::kTektronixTds;
    constexpr std::size_t kSideColumns = 3;
    const auto beginning =
        is_beside ? FindSideTable(text_, kSideColumns) : FindTableBeginning(text_);
    if (!beginning) return NoTable();
    table_.offset = beginning->offset;
    table_.line = beginning->line;
    table_.separator = beginning->rows[0].separator;
    for (const TableKey& key : is_beside ? beginning->keys : std::vector<TableKey>{}) {
      table_.fields["table." + std::string(key.key)] = key.values[0];
    }
    HAPTOMETER_LET(auto read, ReadColumns(*beginning));
    // order: columns first, then what instruments state of them, then the user's selection
    NumberChannels(&table_.columns);
    KeepWords(*beginning, read, &table_);
    HAPTOMETER_TRY(AddInstrumentWords(*beginning, name_, &table_));
    HAPTOMETER_TRY(KeepChannel(options_, name_, &table_.columns));
    HAPTOMETER_TRY(Check());
    return std::move(table_);
  }

 private:
  // an error where an option needs a table, else nothing
  Result<std::optional<ForeignTable>> NoTable() const {
    if (options_.format) {
      return CannotAnswer(
          name_, fmt::format("is not a table of <format> {}", FactsOf(*options_.format).name),
          "leave <format> out, or name another");
    }
    if (options_.columns.empty()) return std::nullopt;
    return CannotAnswer(
        name_, "has no two lines of numbers for <columns> to name",
        "give a file with a row of numbers a line, separated by commas, semicolons, "
        "tabs or blanks");
  }

  // columns and clock; how many lines above were used for it
  Result<std::size_t> ReadColumns(const TableBeginning& beginning) {
    // a clock stated above the rows is found first: it determines the unit of unnamed times
    HAPTOMETER_LET(auto clock, FindStatedClock(beginning.keys, name_));
    table_.clock = std::move(clock);
    table_.stated_rows = FindStatedRows(beginning.keys);
    if (options_.columns.empty() && table_.format == TableFormat::kTektronixTds) {
      table_.columns = SideColumns(beginning);
      return std::size_t{0};
    }
    if (options_.columns.empty() && table_.format == TableFormat::kRigolSequence) {
      return ReadSequence(beginning, name_, &table_);
    }
    HAPTOMETER_LET(auto named,
                   ReadNamedColumns(beginning, {table_.format, table_.clock}, name_, options_));
    table_.columns = std::move(named.columns);
    table_.findings = std::move(named.findings);
    return named.lines_used;
  }

  // conditions for any source of the names
  Result<void> Check() {
    const auto times = std::ranges::count(table_.columns, CsvColumnKind::kTime, &CsvColumn::kind);
    const auto values = std::ranges::count(table_.columns, CsvColumnKind::kValue, &CsvColumn::kind);
    if (times > 1) return CannotAnswer(name_, "two columns are times", "say <columns>");
    // times come from a column, from the rate or from a stated interval
    if (times == 0 && !options_.rate_hz && !table_.clock) {
      return CannotAnswer(name_, "no column is a time and no line above states the sample interval",
                          "name one time_s (<columns>), or give the rows per second (<rate>)");
    }
    if (values == 0) {
      return CannotAnswer(name_, "no column beside the time holds values", "say <columns>");
    }
    // times state by themselves where rows are missing
    for (CsvColumn& column : table_.columns) {
      const bool is_number = column.kind == CsvColumnKind::kNumber;
      if (times > 0 && is_number) column.kind = CsvColumnKind::kLeftOut;
    }
    // a status column refers to a value column by its number
    for (const CsvColumn& column : table_.columns) {
      if (column.kind == CsvColumnKind::kStatus &&
          column.channel > static_cast<std::size_t>(values)) {
        return CannotAnswer(name_,
                            fmt::format("'{}' is about a channel that is not there", column.name));
      }
    }
    return ApplyScales(options_, &table_.columns);
  }

  std::string_view text_;
  const std::string& name_;
  const ImportOptions& options_;
  ForeignTable table_;
};

}  // namespace

Result<void> KeepChannel(const ImportOptions& options, const std::string& name,
                         std::vector<CsvColumn>* columns) {
  if (options.channel.empty()) return {};
  const std::string wanted = Typed(options.channel);
  const auto is_it = [&](const CsvColumn& column) {
    return column.kind == CsvColumnKind::kValue &&
           (Typed(column.name) == wanted || Typed(column.printed) == wanted);
  };
  const auto found = std::ranges::count_if(*columns, is_it);
  // exactly one channel must have the name
  if (found != 1) {
    return CannotAnswer(
        name,
        fmt::format("has {} called '{}' (its channels: {})",
                    found == 0 ? "no channel" : "several channels", options.channel,
                    NamesOf(*columns)),
        found == 0 ? "give <channel> with one of these" : "give <columns>, with - for the others");
  }
  const std::size_t number = std::ranges::find_if(*columns, is_it)->channel;
  for (CsvColumn& column : *columns) {
    const bool is_value = column.kind == CsvColumnKind::kValue;
    // the status column of the selected channel remains and refers to the only channel
    const bool is_status = column.kind == CsvColumnKind::kStatus && column.channel != 0;
    if ((is_value || is_status) && column.channel != number) {
      column = CsvColumn{.kind = CsvColumnKind::kLeftOut};
    } else if (is_status) {
      column.channel = 1;
    }
  }
  return {};
}

Result<void> ApplyScales(const ImportOptions& options, std::vector<CsvColumn>* columns) {
  HAPTOMETER_TRY(ApplyScale(options.scale_m, ChannelRole::kDisplacement, columns));
  return ApplyScale(options.scale_v, ChannelRole::kVoltage, columns);
}

Result<std::optional<ForeignTable>> FindForeignTable(std::string_view text, const std::string& name,
                                                     const ImportOptions& options) {
  return Finder(text, name, options).Find();
}

}  // namespace haptometer::trial
