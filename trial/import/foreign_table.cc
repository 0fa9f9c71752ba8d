#include "trial/import/foreign_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "trial/import/csv_comment.h"
#include "trial/import/printed_unit.h"

namespace haptometer::trial {
namespace {

// no preamble is longer, so that a book is not searched for numbers
constexpr std::size_t kMostLinesAbove = 1000;

struct Line {
  std::string_view text;  // without blanks at its ends
  std::size_t offset = 0;
  std::size_t number = 0;  // lines before it
};

// a line's cells with the separator that it suggests
struct Cells {
  char separator = ',';
  std::vector<std::string_view> cells{};
};

Cells CellsOf(std::string_view line) {
  char separator = ',';
  if (line.find('\t') != std::string_view::npos) separator = '\t';
  if (line.find(';') != std::string_view::npos) separator = ';';
  return {separator, SplitCells(line, separator)};
}

// numbers with perhaps empty cells beside them
bool IsNumbers(const Cells& line) {
  bool has_number = false;
  for (const std::string_view cell : line.cells) {
    if (cell.empty()) continue;
    if (!ReadNumberWithComma(cell)) return false;
    has_number = true;
  }
  return has_number;
}

// "Time [ms]" or "Voltage (V)" split into name and unit
std::pair<std::string_view, std::string_view> SplitUnit(std::string_view cell) {
  const std::size_t open = cell.find_last_of("[(");
  if (open == std::string_view::npos || !(cell.ends_with(']') || cell.ends_with(')'))) {
    return {cell, ""};
  }
  return {Trimmed(cell.substr(0, open)), Trimmed(cell.substr(open + 1, cell.size() - open - 2))};
}

// a cell that holds a unit alone: "V", "(ms)", "second"
std::string_view UnitCell(std::string_view cell) {
  const auto [before, inside] = SplitUnit(cell);
  if (inside.empty()) return cell;
  return before.empty() ? inside : "";
}

bool IsTimeName(std::string_view name) {
  std::string lower(name);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  constexpr std::array<std::string_view, 8> kNames{"time",   "t",       "x-axis", "x",
                                                   "second", "seconds", "zeit",   "x_value"};
  return std::ranges::find(kNames, lower) != kNames.end();
}

// the lines up to the first two of numbers, and those two
struct Beginning {
  std::vector<Line> above{};
  std::array<Cells, 2> rows{};
  std::size_t offset = 0;
  std::size_t line = 0;
};

std::optional<Beginning> FindNumbers(std::string_view text) {
  Beginning found;
  std::optional<Line> last;  // a line of numbers whose like has not come yet
  std::size_t at = 0;
  for (std::size_t number = 0; at < text.size() && number < kMostLinesAbove; ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const Line line{Trimmed(text.substr(at, end - at)), at, number};
    at = end + 1;
    if (line.text.empty()) continue;
    const bool is_comment = line.text.starts_with('#');
    Cells cells = CellsOf(line.text);
    if (is_comment || !IsNumbers(cells)) {
      if (last) found.above.push_back(*std::exchange(last, std::nullopt));
      if (!is_comment) found.above.push_back(line);
      continue;
    }
    if (last && found.rows[0].separator == cells.separator &&
        found.rows[0].cells.size() == cells.cells.size()) {
      found.rows[1] = std::move(cells);
      found.offset = last->offset;
      found.line = last->number;
      return found;
    }
    if (last) found.above.push_back(*last);
    last = line;
    found.rows[0] = std::move(cells);
  }
  return std::nullopt;
}

// What names the columns, and the readings of it that are possible.
class Head {
 public:
  Head(const Beginning& beginning, const std::string& name, const ImportOptions& options)
      : beginning_(beginning), name_(name), options_(options) {}

  Result<ForeignTable> Read() {
    auto columns = options_.columns.empty() ? FromHeader() : FromOptions();
    if (!columns) return std::unexpected(columns.error());
    if (auto done = Check(*columns); !done) return std::unexpected(done.error());
    ForeignTable table{.offset = beginning_.offset,
                       .line = beginning_.line,
                       .separator = beginning_.rows[0].separator,
                       .columns = std::move(*columns)};
    // what else stands above
    for (std::size_t i = 0; i + lines_used_ < beginning_.above.size(); ++i) {
      const std::string_view text = beginning_.above[i].text;
      const Cells cells = CellsOf(text);
      // under a prefix, because a key of our own means something else
      const std::string_view key = cells.cells[0];
      if (cells.cells.size() == 2 && !key.empty() && key.find('=') == std::string_view::npos) {
        table.fields["table." + std::string(key)] = cells.cells[1];
      } else {
        table.notes.emplace_back(text);
      }
    }
    return table;
  }

 private:
  [[nodiscard]] std::size_t Width() const { return beginning_.rows[0].cells.size(); }

  std::unexpected<Error> NoNames() const {
    return CannotAnswer(
        name_, fmt::format("no line names its {} column{}", Width(), Width() == 1 ? "" : "s"),
        "put a line such as time_s,displacement_m above the numbers (time_s,voltage_v for a coil), "
        "or say --columns");
  }

  // the line `back` lines above the numbers, in cells of the numbers' separator
  [[nodiscard]] std::vector<std::string_view> Above(std::size_t back) const {
    if (back > beginning_.above.size()) return {};
    const Line& line = beginning_.above[beginning_.above.size() - back];
    auto cells = SplitCells(line.text, beginning_.rows[0].separator);
    // a separator at the line's end
    while (cells.size() > Width() && cells.back().empty()) cells.pop_back();
    return cells;
  }

  Result<std::vector<CsvColumn>> FromOptions() {
    if (options_.columns.size() != Width()) {
      return Usage(
          "--columns",
          fmt::format("names {} columns where {} has {}", options_.columns.size(), name_, Width()),
          "name each from the left, - for one to leave out");
    }
    // the line above is the header that the options replace
    lines_used_ = Above(1).size() == Width() ? 1 : 0;
    std::vector<CsvColumn> columns;
    for (const std::string& word : options_.columns) {
      const bool is_scaled = options_.scale_m && word.starts_with("displacement");
      // with a scale the column needs no unit of its own
      auto column =
          ReadCsvColumn(is_scaled && word == "displacement" ? "displacement_m" : word, "--columns");
      if (!column) {
        Error error = column.error();
        error.cause = Cause::kUsage;
        return std::unexpected(std::move(error));
      }
      columns.push_back(std::move(*column));
    }
    return columns;
  }

  Result<std::vector<CsvColumn>> FromHeader() {
    std::vector<std::string_view> units = Above(1);
    std::vector<std::string_view> names = Above(2);
    const bool has_units =
        units.size() == Width() && names.size() == Width() &&
        std::ranges::all_of(units, [](std::string_view cell) {
          return cell.empty() || FindUnit(UnitCell(cell)) || cell.starts_with('(');
        });
    if (!has_units) {
      names = std::exchange(units, {});
    }
    lines_used_ = has_units ? 2 : 1;
    if (names.size() * 2 == Width() && beginning_.rows[0].separator == ',')
      return CommaError(names);
    // rows that end with separators have cells without names
    while (!names.empty() && names.size() < Width() && IsEmptyBelow(names.size())) {
      names.emplace_back();
    }
    if (names.size() != Width()) return NoNames();
    std::vector<CsvColumn> columns;
    for (std::size_t i = 0; i < names.size(); ++i) {
      auto column = ColumnOf(names[i], has_units ? UnitCell(units[i]) : "", i);
      if (!column) return std::unexpected(column.error());
      columns.push_back(std::move(*column));
    }
    return columns;
  }

  [[nodiscard]] bool IsEmptyBelow(std::size_t column) const {
    return beginning_.rows[0].cells[column].empty() && beginning_.rows[1].cells[column].empty();
  }

  // twice as many cells as names: each may be half of a number with a decimal comma
  std::unexpected<Error> CommaError(const std::vector<std::string_view>& names) const {
    const auto& cells = beginning_.rows[0].cells;
    return CannotAnswer(
        fmt::format("{}: line {}", name_, beginning_.line + 1),
        fmt::format("has {} cells under {} names: either cells '{}' and '{}', or one number {},{}",
                    Width(), names.size(), cells[0], cells[1], cells[0], cells[1]),
        "separate cells with semicolons, or write decimal points");
  }

  Result<CsvColumn> ColumnOf(std::string_view cell, std::string_view unit_text,
                             std::size_t number) const {
    // a name of our own says its unit
    if (unit_text.empty()) {
      auto own = ReadCsvColumn(cell, name_);
      if (own && (own->kind != CsvColumnKind::kValue || own->role != ChannelRole::kOther)) {
        return own;
      }
    }
    const auto [title, bracket] = SplitUnit(cell);
    const auto unit = FindUnit(unit_text.empty() ? bracket : unit_text);
    // "second" as a name is a unit as well
    const auto time_unit = unit ? unit : FindUnit(title);
    if (IsTimeName(title)) {
      if (!time_unit || time_unit->si_unit != "s") return TimeError(cell, number);
      return CsvColumn{
          .kind = CsvColumnKind::kTime, .name = "time", .unit = "s", .factor = time_unit->factor};
    }
    if (cell.empty()) return CsvColumn{.kind = CsvColumnKind::kLeftOut};
    CsvColumn column{.name = std::string(title.empty() ? cell : title)};
    if (unit) {
      column.role = RoleOfUnit(unit->si_unit);
      column.unit = unit->si_unit;
      column.factor = unit->factor;
    }
    return column;
  }

  // a time that may be seconds or milliseconds
  std::unexpected<Error> TimeError(std::string_view cell, std::size_t number) const {
    const double step = ReadNumberWithComma(beginning_.rows[1].cells[number]).value_or(0) -
                        ReadNumberWithComma(beginning_.rows[0].cells[number]).value_or(0);
    return CannotAnswer(
        name_,
        fmt::format("column '{}' does not say its unit: in s there are {:.4g} rows a second, in ms "
                    "{:.4g}",
                    cell, 1 / step, 1000 / step),
        "name it time_s, time_ms or time_us, or say --columns");
  }

  // what holds for any source of the names
  Result<void> Check(std::vector<CsvColumn>& columns) const {
    const auto times = std::ranges::count(columns, CsvColumnKind::kTime, &CsvColumn::kind);
    const auto values = std::ranges::count(columns, CsvColumnKind::kValue, &CsvColumn::kind);
    if (times > 1) return CannotAnswer(name_, "two columns are times", "say --columns");
    if (times == 0 && !options_.rate_hz) {
      return CannotAnswer(
          name_, "no column is a time",
          "name one time_s (--columns), or say how many rows come a second (--rate)");
    }
    if (values == 0) {
      return CannotAnswer(name_, "no column beside the time holds values", "say --columns");
    }
    for (const CsvColumn& column : columns) {
      if (column.channel > static_cast<std::size_t>(values)) {
        return CannotAnswer(name_,
                            fmt::format("'{}' is about a channel that is not there", column.name));
      }
    }
    return ApplyScale(columns);
  }

  Result<void> ApplyScale(std::vector<CsvColumn>& columns) const {
    if (!options_.scale_m) return {};
    bool is_used = false;
    for (CsvColumn& column : columns) {
      if (column.role != ChannelRole::kDisplacement) continue;
      column.factor = *options_.scale_m;
      is_used = true;
    }
    if (is_used) return {};
    return Usage("--scale", "is about a displacement, and no column is one",
                 "say --columns time_s,displacement");
  }

  const Beginning& beginning_;
  const std::string& name_;
  const ImportOptions& options_;
  std::size_t lines_used_ = 0;
};

}  // namespace

std::vector<std::string_view> SplitCells(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t end = line.find(separator);
    std::string_view cell = Trimmed(line.substr(0, end));
    if (cell.size() >= 2 && cell.starts_with('"') && cell.ends_with('"')) {
      cell = Trimmed(cell.substr(1, cell.size() - 2));
    }
    cells.push_back(cell);
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

Result<std::optional<ForeignTable>> FindForeignTable(std::string_view text, const std::string& name,
                                                     const ImportOptions& options) {
  const auto beginning = FindNumbers(text);
  if (!beginning) return std::nullopt;
  auto table = Head(*beginning, name, options).Read();
  if (!table) return std::unexpected(table.error());
  return std::move(*table);
}

}  // namespace haptometer::trial
