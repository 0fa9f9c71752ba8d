#include "trial/import/table/named_columns.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "trial/import/table/row_numbers.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

bool IsOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, LowerCase(word)) != words.end();
}

// names of time columns in exports of oscilloscopes and data loggers, some of them German
bool IsTimeName(std::string_view name) {
  return IsOneOf(name, {"time", "t", "x-axis", "x", "second", "seconds", "zeit", "x_value",
                        "relative time", "elapsed time", "timestamp", "time stamp"});
}

bool IsUnitOfTime(std::string_view text) {
  const auto unit = FindUnit(text);
  return unit && unit->si_unit == "s";
}

// whether a word that no unit is known for may be one: a quotient or power, or a usual name; not
// "filtered", "CH1" or Siglent's "Value"
bool MayBeUnit(std::string_view word) {
  if (word.contains(' ')) return false;
  return word.find_first_of("/^%.*") != std::string_view::npos ||
         IsOneOf(word, {"in",    "ft",     "g",   "n",      "mn",    "kn",    "pa",  "kpa",
                        "mpa",   "bar",    "k",   "c",      "deg",   "rad",   "ohm", "w",
                        "count", "counts", "lsb", "digits", "steps", "pixels"});
}

struct NameAndUnit {
  std::string_view name;
  std::string_view unit;
};

// "t/s" or "x/um" split into quantity and unit (ISO 80000-1); a quotient of units ("mm/s", "N/mm")
// is none of a quantity. The symbol s is a path, too.
std::optional<NameAndUnit> SplitQuantity(std::string_view cell) {
  const std::size_t slash = cell.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const NameAndUnit split{Trimmed(cell.substr(0, slash)), Trimmed(cell.substr(slash + 1))};
  const auto unit = FindUnit(split.unit);
  // what counts per second is no time
  if (!unit || (unit->si_unit == "s" && !IsTimeName(split.name))) return std::nullopt;
  const bool is_unit = (FindUnit(split.name) && split.name != "s") ||
                       IsOneOf(split.name, {"", "1", "n", "kn", "mn", "g", "kg", "deg", "rad"});
  if (is_unit) return std::nullopt;
  return split;
}

// "Time [ms]", "Voltage (V)", "v/(mm/s)", "t / s", "x/um", "C1 in V" or "t_s" split into name and
// unit
NameAndUnit SplitUnit(std::string_view cell) {
  const std::size_t open = cell.find_last_of("[(");
  if (open != std::string_view::npos && (cell.ends_with(']') || cell.ends_with(')'))) {
    std::string_view name = Trimmed(cell.substr(0, open));
    if (name.ends_with('/')) name = Trimmed(name.substr(0, name.size() - 1));
    return {name, Trimmed(cell.substr(open + 1, cell.size() - open - 2))};
  }
  for (const std::string_view sign : {" / ", " in "}) {
    const std::size_t at = cell.rfind(sign);
    if (at == std::string_view::npos) continue;
    return {Trimmed(cell.substr(0, at)), Trimmed(cell.substr(at + sign.size()))};
  }
  if (cell.starts_with("in ")) return {"", Trimmed(cell.substr(3))};
  if (const auto split = SplitQuantity(cell)) return *split;
  // an underscore separates a unit only behind a time: other names may contain it
  const std::size_t bar = cell.rfind('_');
  if (bar != std::string_view::npos && IsTimeName(cell.substr(0, bar)) &&
      IsUnitOfTime(cell.substr(bar + 1))) {
    return {cell.substr(0, bar), cell.substr(bar + 1)};
  }
  return {cell, ""};
}

// a cell that holds a unit alone: "V", "(ms)", "second"
std::string_view UnitCell(std::string_view cell) {
  const auto [before, inside] = SplitUnit(cell);
  if (inside.empty()) return cell;
  return before.empty() ? inside : "";
}

// names the columns of a foreign table from its header lines, its comments or the options
class Head {
 public:
  Head(const TableBeginning& beginning, const TableWords& words, const std::string& name,
       const ImportOptions& options)
      : beginning_(beginning),
        facts_(FactsOf(words.format)),
        clock_(words.clock),
        name_(name),
        options_(options) {}

  Result<NamedColumns> Read() {
    HAPTOMETER_TRY(options_.columns.empty() ? FromHeader() : FromOptions());
    return std::move(named_);
  }

 private:
  [[nodiscard]] std::size_t Width() const { return beginning_.width(); }

  Result<void> FromOptions() {
    std::size_t width = Width();
    // separators at the ends of rows make columns without content
    while (width > options_.columns.size() && IsEmptyBelow(width - 1)) --width;
    if (options_.columns.size() != width) {
      return Usage(
          "<columns>",
          fmt::format("names {} columns where {} has {}, separated by {}", options_.columns.size(),
                      name_, width, NameOfSeparator(beginning_.rows[0].separator)),
          "name each from the left, - for one to leave out");
    }
    // the line above is the header that the options replace
    named_.lines_used = beginning_.Above(1).size() == Width() ? 1 : 0;
    named_.columns.reserve(Width());
    for (const std::string& word : options_.columns) {
      HAPTOMETER_LET(auto column, ReadToldColumn(word, options_));
      const bool is_first = named_.columns.empty();
      if (is_first && IsRowNumberName(word) && HasNumbers()) column.kind = CsvColumnKind::kNumber;
      named_.columns.push_back(std::move(column));
    }
    // columns behind the named ones are empty
    named_.columns.resize(Width(), CsvColumn{.kind = CsvColumnKind::kLeftOut});
    return {};
  }

  // names in the line above the numbers, or above a line of units, or in the last comment
  Result<void> FromHeader() {
    std::vector<std::string_view> names = beginning_.Above(1);
    std::vector<std::string_view> units;
    auto names_above = beginning_.Above(2);
    // a line of units has the names one line higher
    if (IsLineOfUnits(names) && names_above.size() == names.size() && !AreKeys(names_above)) {
      units = std::exchange(names, std::move(names_above));
    }
    // a comment as header (np.savetxt) must name a time: other comments may have as many cells
    auto comment = beginning_.LastComment();
    const bool is_in_comment = comment.size() == Width() && NamesTime(comment);
    if (is_in_comment) {
      names = std::move(comment);
      units.clear();
    }
    // two cells for each name: decimal commas split at commas
    if (names.size() * 2 == Width() && beginning_.rows[0].separator == ',') {
      return CommaError(names);
    }
    // rows that end with separators have cells without names
    while (!names.empty() && names.size() < Width() && IsEmptyBelow(names.size())) {
      names.emplace_back();
    }
    if (names.size() != Width() || AreKeys(names) || IsKeyOfTraces()) return WithoutNames();
    units.resize(Width());
    // lines above the rows that are header and become no notes
    named_.lines_used = is_in_comment ? 0 : units[0].empty() ? 1 : 2;
    for (std::size_t i = 0; i < names.size(); ++i) {
      HAPTOMETER_LET(auto column, ColumnOf(names[i], UnitCell(units[i]), i));
      named_.columns.push_back(std::move(column));
    }
    FillUnits();
    return {};
  }

  // "second,Volt", "(ms),(V)"; Siglent's "Second,Value" too
  [[nodiscard]] bool IsLineOfUnits(const std::vector<std::string_view>& cells) const {
    const bool is_wide = cells.size() == Width() || EndsEmpty(cells.size());
    // a line of units: each cell is a unit or empty; "value" stands for one beside a time
    return is_wide && !cells.empty() && std::ranges::all_of(cells, [&](std::string_view cell) {
             return cell.empty() || FindUnit(UnitCell(cell)) || cell.starts_with('(') ||
                    (IsUnitOfTime(UnitCell(cells[0])) && IsOneOf(cell, {"value"}));
           });
  }

  [[nodiscard]] bool EndsEmpty(std::size_t from) const {
    for (std::size_t i = from; i < Width(); ++i) {
      if (!IsEmptyBelow(i)) return false;
    }
    return from <= Width();
  }

  // whether the rows begin with a date, and the time of day behind it
  [[nodiscard]] bool HasDates() const {
    return Width() > 1 && IsDate(beginning_.rows[0].cells[0]) &&
           ReadClock(beginning_.rows[0].cells[1]);
  }

  [[nodiscard]] bool IsEmptyBelow(std::size_t column) const {
    return beginning_.rows[0].cells[column].empty() && beginning_.rows[1].cells[column].empty();
  }

  // whether one of the cells is a time column's name, of this program or of another
  [[nodiscard]] bool NamesTime(const std::vector<std::string_view>& cells) const {
    const auto is_time = [&](std::string_view cell) {
      const auto own = ReadCsvColumn(cell, name_);
      return (own && own->kind == CsvColumnKind::kTime) || IsTimeName(SplitUnit(cell).name);
    };
    return std::ranges::any_of(cells, is_time);
  }

  // a line such as "Sample Interval:,1e-9" right above two columns names none of them
  [[nodiscard]] static bool AreKeys(const std::vector<std::string_view>& cells) {
    const auto is_of_key = [](std::string_view cell) {
      return cell.ends_with(':') || ReadNumberWithComma(cell);
    };
    return std::ranges::any_of(cells, is_of_key) && !IsTimeName(cells[0]);
  }

  // whether rows begin with an empty cell below the keys of a file that names its channels in one
  [[nodiscard]] bool IsKeyOfTraces() const {
    return IsEmptyBelow(0) && !ValuesOf(beginning_.keys, "TraceName").empty();
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

  // no line names the columns: one column needs no name where the rate is known; of several, the
  // first may be the time
  Result<void> WithoutNames() {
    std::vector<std::size_t> filled;
    for (std::size_t i = 0; i < Width(); ++i) {
      if (!IsEmptyBelow(i)) filled.push_back(i);
    }
    const bool is_infiniium = facts_.format == TableFormat::kKeysightInfiniium;
    const bool is_timeless = options_.rate_hz || facts_.format == TableFormat::kHantek;
    // Infiniium files without names: one column of values, or time in s and values
    if (is_infiniium && filled.size() <= 2) {
      named_.columns.assign(Width(), {.kind = CsvColumnKind::kLeftOut});
      if (filled.size() == 2) SetTime(PrintedUnit{"s", 1}, filled[0]);
      named_.columns[filled.back()] = CsvColumn{.name = "channel_1"};
      FillUnits();
      return {};
    }
    // a single column beside a rate or keys needs no name
    if (filled.size() == 1 && (is_timeless || is_infiniium || !beginning_.keys.empty())) {
      named_.columns.assign(Width(), {.kind = CsvColumnKind::kLeftOut});
      named_.columns[filled[0]] = CsvColumn{.name = "channel_1"};
      return {};
    }
    // the key TraceName names the channels of a table that has a clock but no line of names
    const auto traces = ValuesOf(beginning_.keys, "TraceName");
    if (clock_ && !filled.empty() && traces.size() == filled.size()) {
      named_.columns.assign(Width(), {.kind = CsvColumnKind::kLeftOut});
      for (std::size_t i = 0; i < filled.size(); ++i) {
        named_.columns[filled[i]] = CsvColumn{.name = std::string(traces[i])};
      }
      FillUnits();
      return {};
    }
    return NoNames(filled);
  }

  // the error for columns without names; the step of the first gives the rates it would mean
  std::unexpected<Error> NoNames(const std::vector<std::size_t>& filled) const {
    constexpr const char* kRemedy =
        "put a line such as time_s,displacement_m above the numbers (time_s,voltage_v for a coil), "
        "or give <columns>";
    const std::string what =
        fmt::format("no line names its {} column{}{}", Width(), Width() == 1 ? "" : "s",
                    beginning_.rows[0].separator == ' ' ? " (separated by blanks)" : "");
    if (filled.size() == 1) {
      return CannotAnswer(
          name_, "holds one column, without a name and without times",
          "give <rate> 10kHz, and what the column is: <scale>, or <columns> voltage_v");
    }
    const double step = filled.empty() ? 0 : Step(filled[0]);
    if (!(step > 0)) return CannotAnswer(name_, what, kRemedy);
    return CannotAnswer(
        name_,
        fmt::format("{}: the first may be a time ({:.4g} rows per second in s, {:.4g} in ms) or a "
                    "channel like the others",
                    what, 1 / step, 1000 / step),
        fmt::format(
            "give <columns> time_s,voltage_v, or <columns> voltage_v,voltage_2_v with <rate>{}",
            filled[0] == 0 && HasNumbers() ? ", or <columns> sample,voltage_v where it numbers the "
                                             "rows"
                                           : ""));
  }

  // whether the first of several columns begins with two whole numbers that differ
  [[nodiscard]] bool HasNumbers() const {
    const auto is_whole = [](const TableCells& row) {
      const auto number = ReadNumberWithComma(row.cells[0]);
      return number && *number == std::floor(*number);
    };
    return Width() > 1 && std::ranges::all_of(beginning_.rows, is_whole) && Step(0) != 0;
  }

  // difference of the first two rows, which is the period if the column is a time
  [[nodiscard]] double Step(std::size_t column) const {
    return ReadNumberWithComma(beginning_.rows[1].cells[column]).value_or(0) -
           ReadNumberWithComma(beginning_.rows[0].cells[column]).value_or(0);
  }

  void SetTime(const PrintedUnit& unit, std::size_t number) {
    named_.columns[number] =
        CsvColumn{.kind = CsvColumnKind::kTime, .name = "time", .unit = "s", .factor = unit.factor};
  }

  Result<CsvColumn> ColumnOf(std::string_view cell, std::string_view unit_text,
                             std::size_t number) {
    // a name of this program contains its unit
    if (unit_text.empty()) {
      auto own = ReadCsvColumn(cell, name_);
      if (own && (own->kind != CsvColumnKind::kValue || own->role != ChannelRole::kOther)) {
        return own;
      }
    }
    auto [title, bracket] = SplitUnit(cell);
    const std::string_view printed = unit_text.empty() ? bracket : unit_text;
    // frequency and level columns of a spectrum are omitted
    const bool is_spectrum = IsOneOf(printed, {"hz", "khz", "db", "dbv"});
    if (number == 0 && HasDates()) return CsvColumn{.kind = CsvColumnKind::kDate};
    // a first column of row numbers is no channel
    if (number == 0 && unit_text.empty() && IsRowNumberName(cell) && HasNumbers()) {
      return CsvColumn{.kind = CsvColumnKind::kNumber, .name = std::string(cell)};
    }
    // nor is one that numbers the samples of a series
    const bool is_number = number == 0 && Width() > 1 && IsOneOf(cell, {"nr", "sample", "index"});
    if ((cell.empty() && unit_text.empty()) || is_spectrum || is_number) {
      return CsvColumn{.kind = CsvColumnKind::kLeftOut};
    }
    const auto unit = FindUnit(printed);
    // a first column in a unit of time is the time, regardless of its name; so are times of day
    // there, and behind their dates
    const bool is_clock = number == 0 ? ReadClock(beginning_.rows[0].cells[0]).has_value()
                                      : number == 1 && HasDates();
    // "x" may be a path
    const bool is_named_time = IsTimeName(title) && (!unit || unit->si_unit == "s");
    const bool is_time = is_named_time || (number == 0 && IsUnitOfTime(printed)) || is_clock;
    if (is_time) return TimeOfColumn(cell, unit ? unit : FindUnit(title), number);
    CsvColumn column{.name = std::string(unit && !title.empty() ? title : cell),
                     .printed = std::string(cell)};
    if (unit) {
      SetUnit(*unit, &column);
    } else if (MayBeUnit(printed)) {
      column.unknown_unit = printed;
    }
    return column;
  }

  // unit of a time column: printed, else the instrument's, else the one that fits a stated rate
  Result<CsvColumn> TimeOfColumn(std::string_view cell, std::optional<PrintedUnit> unit,
                                 std::size_t number) {
    CsvColumn column{.kind = CsvColumnKind::kTime, .name = "time", .unit = "s"};
    // times of day need no unit
    if (ReadClock(beginning_.rows[0].cells[number])) {
      column.is_clock = true;
      return column;
    }
    if (!unit && facts_.assumed_time_unit == "s") {
      // the unit of the time axis may be a key of the header
      const auto stated = ValuesOf(beginning_.keys, "Horizontal Units");
      if (!stated.empty()) unit = FindUnit(stated[0]);
      // LeCroy states no unit of time: s, with a note
      if (!unit && facts_.format == TableFormat::kLecroy) {
        unit = PrintedUnit{"s", 1};
        named_.findings.Note(FindingKind::kTimeUnitAssumed,
                             {{"title", std::string(facts_.title)}, {"unit", std::string("s")}});
      }
      if (!unit && facts_.format != TableFormat::kTektronixDpo) unit = PrintedUnit{"s", 1};
    }
    // a stated rate or sample interval determines the unit from the step of the times
    if (!unit && options_.rate_hz) unit = UnitByRate(Step(number), *options_.rate_hz);
    const bool is_clear = clock_ && !MayGroupThousands(*clock_, HasCommas());
    if (!unit && is_clear) unit = UnitByRate(Step(number), 1 / clock_->interval_s);
    if (!unit || unit->si_unit != "s") return TimeError(cell, number);
    column.factor = unit->factor;
    return column;
  }

  // whether a cell of the first rows has a comma
  [[nodiscard]] bool HasCommas() const {
    return std::ranges::any_of(beginning_.rows, [](const TableCells& row) {
      return std::ranges::any_of(row.cells,
                                 [](std::string_view cell) { return cell.contains(','); });
    });
  }

  // the unit in which the rows have the stated rate, to 1 %; nothing where none has
  [[nodiscard]] static std::optional<PrintedUnit> UnitByRate(double step, double rate_hz) {
    for (const double factor : {1.0, 1e-3, 1e-6, 1e-9}) {
      if (std::abs(step * factor * rate_hz - 1) < 0.01) return PrintedUnit{"s", factor};
    }
    return std::nullopt;
  }

  // the error for a time that may be in seconds or milliseconds
  std::unexpected<Error> TimeError(std::string_view cell, std::size_t number) const {
    const double step = Step(number);
    return CannotAnswer(name_,
                        fmt::format("column '{}' does not state its unit: in s there are {:.4g} "
                                    "rows per second, in ms {:.4g}",
                                    cell, 1 / step, 1000 / step),
                        "name it time_s, time_ms or time_us, or give <columns>");
  }

  // units of values that stand elsewhere than beside their names
  void FillUnits() {
    auto stated = ValuesOf(beginning_.keys, "Vertical Units");
    for (const char* key : {"YUnits", "VUnit"}) {
      if (stated.empty()) stated = ValuesOf(beginning_.keys, key);
    }
    std::size_t channel = 0;
    bool is_assumed = false;
    for (CsvColumn& column : named_.columns) {
      if (column.kind != CsvColumnKind::kValue) continue;
      // one stated unit is valid for all channels, several are in the order of the channels
      const std::size_t at = stated.size() == 1 ? 0 : channel;
      ++channel;
      if (!column.unit.empty() || column.role != ChannelRole::kOther) continue;
      if (at < stated.size()) {
        if (const auto unit = FindUnit(stated[at])) SetUnit(*unit, &column);
      } else if (const auto unit = FindUnit(facts_.assumed_value_unit)) {
        // the instrument's usual unit, reported as assumed
        SetUnit(*unit, &column);
        is_assumed = true;
      }
    }
    if (is_assumed) {
      named_.findings.Note(
          FindingKind::kValueUnitAssumed,
          {{"title", std::string(facts_.title)}, {"unit", std::string(facts_.assumed_value_unit)}});
    }
  }

  const TableBeginning& beginning_;
  const TableFormatFacts& facts_;
  const std::optional<StatedClock>& clock_;
  const std::string& name_;
  const ImportOptions& options_;
  NamedColumns named_;
};

}  // namespace

Result<CsvColumn> ReadToldColumn(const std::string& word, const ImportOptions& options) {
  std::string name = word;
  // with a scale the unit need not be in the name
  if (options.scale_m && word == "displacement") name = "displacement_m";
  if (options.scale_v && word == "voltage") name = "voltage_v";
  auto column = ReadCsvColumn(name, "<columns>");
  // an invalid name in the options is an error of usage, not of the file
  if (!column) {
    Error error = column.error();
    error.cause = Cause::kUsage;
    return std::unexpected(std::move(error));
  }
  column->printed = word;
  return column;
}

CsvColumn ReadQuantity(std::string_view cell) {
  auto own = ReadCsvColumn(cell, "");
  if (own && (own->kind != CsvColumnKind::kValue || own->role != ChannelRole::kOther)) {
    return *std::move(own);
  }
  const auto [title, unit] = SplitUnit(cell);
  CsvColumn column{.name = std::string(title), .printed = std::string(cell)};
  SetPrintedUnit(unit, &column);
  return column;
}

void KeepStatedUnit(const CsvColumn& said, CsvColumn* told) {
  if (told->kind != CsvColumnKind::kValue || told->role != ChannelRole::kOther) return;
  told->unit = said.unit;
  told->factor = said.factor;
}

Result<NamedColumns> ReadNamedColumns(const TableBeginning& beginning, const TableWords& words,
                                      const std::string& name, const ImportOptions& options) {
  return Head(beginning, words, name, options).Read();
}

}  // namespace haptometer::trial
