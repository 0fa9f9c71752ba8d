#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "trial/import/readers.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/csv_rows.h"
#include "trial/import/table/foreign_table.h"
#include "trial/import/table/instrument_layouts.h"
#include "trial/import/table/named_columns.h"
#include "trial/import/table/row_times.h"
#include "trial/import/table/stated_clock.h"
#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

// rows in which a column of times is searched, and by how much its steps may differ, relative
constexpr std::size_t kRows = 8;
constexpr double kEven = 0.05;

bool GrowsEvenly(const std::vector<double>& values) {
  const double step = (values.back() - values.front()) / static_cast<double>(values.size() - 1);
  if (!(step > 0)) return false;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (!(std::abs(values[k] - values[k - 1] - step) <= kEven * step)) return false;
  }
  return true;
}

// the unit of a column in the file where the options read it in another one; none where nothing is
// overridden
std::vector<FindingNumber> OverriddenUnit(const CsvColumn& said, const CsvColumn& read,
                                          bool has_scale) {
  if (!said.unit.empty()) {
    if (said.unit == read.unit && said.factor == read.factor) return {};
    return {{"file_factor", said.factor}, {"file_unit", said.unit}};
  }
  // a scale states what a unit is that is not known
  if (said.unknown_unit.empty() || read.unit.empty() || has_scale) return {};
  return {{"unknown_unit", said.unknown_unit}};
}

// finds each column whose unit in the options (`read`) differs from that in the file (`said`);
// none where the numbers of columns differ. What the options name without a unit keeps the file's
void FindOverriddenUnits(const std::vector<CsvColumn>& said, std::vector<CsvColumn>& read,
                         bool has_scale, Findings& findings) {
  if (said.size() != read.size()) return;
  for (std::size_t i = 0; i < read.size(); ++i) {
    if (read[i].kind == CsvColumnKind::kLeftOut) continue;
    KeepStatedUnit(said[i], &read[i]);
    auto numbers = OverriddenUnit(said[i], read[i], has_scale);
    if (numbers.empty()) continue;
    numbers.insert(numbers.begin(), {"column", i + 1});
    numbers.emplace_back("given_factor", read[i].factor);
    numbers.emplace_back("given_unit", read[i].unit);
    findings.Add({Severity::kDoubt, FindingKind::kUnitOverridden, std::move(numbers)});
  }
}

// The column, from 1 on, but for `except`, whose values in the first eight lines of `rows` grow in
// steps equal to 5 %, as times do; 0: none. For a message about times that do not grow.
std::size_t EvenColumn(std::string_view rows, char separator, std::size_t except) {
  std::vector<std::vector<double>> columns;
  std::size_t count = 0;
  for (; count < kRows && !rows.empty(); ++count) {
    const std::size_t end = std::min(rows.find('\n'), rows.size());
    const auto cells = SplitCells(Trimmed(rows.substr(0, end)), separator);
    rows.remove_prefix(std::min(end + 1, rows.size()));
    if (columns.empty()) columns.resize(cells.size());
    if (cells.size() != columns.size()) return 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      columns[i].push_back(
          ReadNumberWithComma(cells[i]).value_or(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  if (count < kRows) return 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (i + 1 != except && GrowsEvenly(columns[i])) return i + 1;
  }
  return 0;
}

// whether a cell is the header of a time column of this program's CSV
bool IsOurTime(std::string_view cell) {
  const auto column = ReadCsvColumn(cell, "");
  return column && column->kind == CsvColumnKind::kTime;
}

// the finding of the layout as which a table is read
Finding FormatFinding(const ForeignTable& table, bool is_given) {
  const TableFormatFacts& facts = FactsOf(table.format);
  std::string channels;
  for (const CsvColumn& column : table.columns) {
    if (column.kind != CsvColumnKind::kValue) continue;
    channels += fmt::format("{}{}", channels.empty() ? "" : ", ", column.name);
    if (!column.unit.empty()) channels += fmt::format(" [{}]", column.unit);
  }
  Finding finding{.kind = is_given ? FindingKind::kFormatGiven : FindingKind::kFormatFound,
                  .numbers = {{"format", std::string(facts.name)},
                              {"title", std::string(facts.title)},
                              {"channels", std::move(channels)}}};
  if (table.separator == ' ') finding.numbers.emplace_back("separator", std::string("blanks"));
  return finding;
}

// Turns lines into a record.
class Parser {
 public:
  Parser(std::string_view text, const std::string& name, const ImportOptions& options,
         Findings* findings)
      : name_(name), options_(options), findings_(*findings), rows_(name) {
    whole_ = rest_ = Utf8Text(text, &storage_);
  }

  Result<Record> Parse() {
    // limits first, then the join of Hantek's blocks: both need the whole text
    HAPTOMETER_TRY(CheckLines(whole_, name_));
    HAPTOMETER_TRY(JoinBlocks());
    LeaveOutCutLine();
    while (NextLine()) {
      HAPTOMETER_TRY(line_.starts_with('#') ? ReadCsvComment(line_, Here(), &comments_)
                     : rows_.has_begun()    ? TakeRow()
                                            : ReadHeaderLine());
    }
    auto record = Complete();
    if (record) FindContradictedRate(*record, findings_);
    return record;
  }

 private:
  // Hantek writes its channels below each other; they are joined to a table of columns
  Result<void> JoinBlocks() {
    if (options_.format.value_or(FindTableFormat(whole_)) != TableFormat::kHantek) return {};
    HAPTOMETER_LET(auto joined, JoinHantekBlocks(whole_, name_));
    if (!joined) return {};
    storage_ = std::move(*joined);
    whole_ = rest_ = storage_;
    return {};
  }

  void LeaveOutCutLine() {
    if (!IsLastLineCutOff(whole_)) return;
    findings_.Doubt(FindingKind::kLastLineCutOff, {{"line", 1 + std::ranges::count(whole_, '\n')}});
    whole_ = rest_ = whole_.substr(0, whole_.rfind('\n') + 1);
  }

  // the next line that is not blank; false at the end
  bool NextLine() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      line_ = Trimmed(rest_.substr(0, end));
      // a tab at the beginning separates an empty cell from what follows
      if (is_foreign_) line_ = LineWithTabs(rest_.substr(0, end));
      rest_ = end == std::string_view::npos ? "" : rest_.substr(end + 1);
      ++line_number_;
      if (!Trimmed(line_).empty()) return true;
    }
    return false;
  }

  [[nodiscard]] std::string Here() const { return fmt::format("{}: line {}", name_, line_number_); }

  Result<void> ReadHeaderLine() {
    // a time_s in the first line and no options: a table of this program, else one of another
    TableCells header = CellsOf(line_);
    const bool is_told = !options_.columns.empty() || options_.rate_hz || options_.scale_m ||
                         options_.scale_v || options_.format || options_.segment;
    if (is_told || std::ranges::none_of(header.cells, IsOurTime)) {
      HAPTOMETER_LET(auto table, FindForeignTable(whole_, name_, options_));
      if (table) {
        HAPTOMETER_TRY(ReadCommentsTo(*table));
        NoteOverridden(table->columns);
        Begin(std::move(*table));
        return {};
      }
    }
    HAPTOMETER_LET(auto columns, ReadCsvColumns(header.cells, name_));
    NameChannels(&columns);
    HAPTOMETER_TRY(KeepChannel(options_, name_, &columns));
    BeginRows({.separator = header.separator, .columns = std::move(columns)});
    return {};
  }

  // where the options read a column otherwise than the file names it
  void NoteOverridden(std::vector<CsvColumn>& columns) {
    if (options_.columns.empty() && !options_.scale_m && !options_.scale_v) return;
    // the columns as the file alone would name them
    ImportOptions own_words = options_;
    own_words.columns.clear();
    own_words.scale_m.reset();
    own_words.scale_v.reset();
    const auto own = FindForeignTable(whole_, name_, own_words);
    if (!own || !*own) return;
    FindOverriddenUnits((*own)->columns, columns, options_.scale_m || options_.scale_v, findings_);
  }

  // a row; where its time does not grow, a column of the rows below may look like the times
  Result<void> TakeRow() {
    auto done = rows_.Take(line_, line_number_);
    if (done || !rows_.is_time_falling()) return done;
    const std::size_t even = EvenColumn(rest_, separator_, time_column_);
    if (even == 0) return done;
    return CannotAnswer(done.error().where, done.error().what,
                        fmt::format("column {} grows in even steps as times do: if the columns are "
                                    "swapped, name them from the left with <columns>",
                                    even));
  }

  // # lines within another program's header have the same meaning as those at the top
  Result<void> ReadCommentsTo(const ForeignTable& table) {
    while (line_number_ < table.line && NextLine() && line_number_ <= table.line) {
      if (!line_.starts_with('#')) continue;
      HAPTOMETER_TRY(ReadCsvComment(line_, Here(), &comments_));
    }
    return {};
  }

  // continues behind the header of another program's table
  void Begin(ForeignTable table) {
    // the header was read from the whole text: rows begin at the offset that was found
    rest_ = whole_.substr(table.offset);
    line_number_ = table.line;
    for (auto& [key, value] : table.fields) comments_.metadata.fields[key] = std::move(value);
    for (std::string& note : table.notes) comments_.metadata.notes.push_back(std::move(note));
    comments_.metadata.fields["table.format"] = FactsOf(table.format).name;
    findings_.Add(FormatFinding(table, options_.format.has_value()));
    for (const Finding& finding : table.findings.list()) findings_.Add(finding);
    words_ = {.clock = std::move(table.clock),
              .segment_starts_s = std::move(table.segment_starts_s)};
    stated_rows_ = table.stated_rows;
    is_foreign_ = true;
    BeginRows(
        {.separator = table.separator, .columns = std::move(table.columns), .is_foreign = true});
  }

  // an export's "# channel.2.name = CH2" is what the channel is called, too
  void NameChannels(std::vector<CsvColumn>* columns) const {
    for (CsvColumn& column : *columns) {
      if (column.kind != CsvColumnKind::kValue) continue;
      const auto found = comments_.channel_keys.find(fmt::format("{}.name", column.channel));
      if (found != comments_.channel_keys.end()) column.name = found->second;
    }
  }

  void BeginRows(CsvRows::Layout layout) {
    separator_ = layout.separator;
    // of arrival times and the fitted ones beside them one is read; the other follows from it
    const bool reads_arrivals =
        !layout.is_foreign && comments_.timing != Timing::kUniform &&
        std::ranges::count(layout.columns, CsvColumnKind::kArrival, &CsvColumn::kind) > 0;
    for (CsvColumn& column : layout.columns) {
      const bool is_arrival = column.kind == CsvColumnKind::kArrival;
      if (column.kind != CsvColumnKind::kTime && !is_arrival) continue;
      column.kind = is_arrival == reads_arrivals ? CsvColumnKind::kTime : CsvColumnKind::kLeftOut;
    }
    for (const CsvColumn& column : layout.columns) {
      // numbers of the channels in the file, to which the keys channel.N refer
      if (column.kind == CsvColumnKind::kValue) channel_numbers_.push_back(column.channel);
    }
    const auto time = std::ranges::find(layout.columns, CsvColumnKind::kTime, &CsvColumn::kind);
    time_column_ = static_cast<std::size_t>(time - layout.columns.begin()) + 1;
    // a row has at least one byte for each column, its line end included: a bound on the rows
    const std::size_t most_rows = rest_.size() / layout.columns.size();
    rows_.Begin(std::move(layout));
    const auto lines = static_cast<std::size_t>(std::ranges::count(rest_, '\n'));
    rows_.Reserve(1 + std::min(lines, most_rows));
  }

  Result<Record> Complete() {
    if (!rows_.has_begun()) {
      return CannotAnswer(name_, "holds no columns",
                          "put a line such as time_s,displacement_m above the numbers");
    }
    if (rows_.rows() < 2) {
      return CannotAnswer(name_,
                          fmt::format("holds {} row{}", rows_.rows(), rows_.rows() == 1 ? "" : "s"),
                          "a measurement needs at least two");
    }
    record_.rows = rows_.rows();
    record_.channels = std::move(rows_.channels());
    record_.metadata = std::move(comments_.metadata);
    // a file that states no source is an import
    if (record_.metadata.source.empty()) record_.metadata.source = "imported";
    HAPTOMETER_TRY(rows_.CheckCommas());
    SetChannelKeys();
    HAPTOMETER_TRY(SetTimes());
    HAPTOMETER_TRY(CheckRate(name_, options_, record_));
    if (options_.rate_hz) record_.metadata.nominal_rate_hz = options_.rate_hz;
    return std::move(record_);
  }

  Result<void> SetTimes() {
    if (!is_foreign_) {
      record_.times_are_known = comments_.times_are_known;
      return SetOwnTimes(name_, comments_.timing, std::move(comments_.stretches), &rows_, &record_,
                         &findings_);
    }
    // a row count in the header that differs is a reason to doubt that the file is complete
    if (stated_rows_ && *stated_rows_ != record_.rows) {
      findings_.Doubt(FindingKind::kStatedRowsDiffer,
                      {{"stated_rows", *stated_rows_}, {"rows", record_.rows}});
    }
    return SetForeignTimes(name_, words_, options_, &rows_, &record_, &findings_);
  }

  // `# channel.2.name = CH2` and its like
  void SetChannelKeys() {
    for (std::size_t c = 0; c < record_.channels.size(); ++c) {
      Channel& channel = record_.channels[c];
      auto text = [&](const char* key) -> const std::string* {
        const auto found =
            comments_.channel_keys.find(fmt::format("{}.{}", channel_numbers_[c], key));
        return found == comments_.channel_keys.end() ? nullptr : &found->second;
      };
      auto number = [&](const char* key, double otherwise) {
        const std::string* value = text(key);
        return value == nullptr ? otherwise : ReadNumber(*value).value_or(otherwise);
      };
      if (const std::string* name = text("name")) channel.name = *name;
      if (const std::string* unit = text("unit"); unit != nullptr && channel.unit.empty()) {
        channel.unit = *unit;
      }
      channel.range_min = number("range_min", channel.range_min);
      channel.range_max = number("range_max", channel.range_max);
      channel.resolution = number("resolution", channel.resolution);
    }
  }

  std::string storage_;
  std::string_view whole_;
  std::string_view rest_;
  const std::string& name_;
  const ImportOptions& options_;
  Findings& findings_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  bool is_foreign_ = false;
  char separator_ = ',';
  std::size_t time_column_ = 0;  // from 1 on
  TimeWords words_;
  std::vector<std::size_t> channel_numbers_;  // of the channels that are read, in the file, from 1
  std::optional<std::size_t> stated_rows_;
  CsvComments comments_;
  CsvRows rows_;
  Record record_;
};

}  // namespace

Result<Record> ParseCsv(std::string_view text, const std::string& name,
                        const ImportOptions& options, Findings* findings) {
  Findings ignored;
  return Parser(text, name, options, findings != nullptr ? findings : &ignored).Parse();
}

}  // namespace haptometer::trial
