#include "trial/import/csv.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "trial/import/csv_column.h"
#include "trial/import/csv_comment.h"
#include "trial/import/foreign_table.h"
#include "trial/import/printed_times.h"
#include "trial/import/stated_rate.h"

namespace haptometer::trial {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Turns lines into a record; every member function reports the line it stands at.
class Parser {
 public:
  Parser(std::string_view text, std::string name, const ImportOptions& options)
      : rest_(text), name_(std::move(name)), options_(options) {}

  Result<Record> Parse(std::vector<std::string>* remarks) {
    if (auto done = SkipEncodingMark(); !done) return std::unexpected(done.error());
    whole_ = rest_;
    while (NextLine()) {
      const auto done = line_.starts_with('#') ? ReadCsvComment(line_, Here(), &comments_)
                        : columns_.empty()     ? ReadHeaderLine()
                                               : ReadRow();
      if (!done) return std::unexpected(done.error());
    }
    auto record = Complete();
    if (record) {
      if (std::string remark = RateRemark(*record); !remark.empty()) {
        remarks->push_back(std::move(remark));
      }
      for (std::string& remark : overridden_) remarks->push_back(std::move(remark));
    }
    return record;
  }

 private:
  Result<void> SkipEncodingMark() {
    if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);
    if (rest_.starts_with("\xff\xfe") || rest_.starts_with("\xfe\xff")) {
      return CannotAnswer(name_, "is UTF-16 text", "save it as CSV in UTF-8");
    }
    return {};
  }

  // the next line that is not blank; false at the end
  bool NextLine() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      line_ = Trimmed(rest_.substr(0, end));
      rest_ = end == std::string_view::npos ? "" : rest_.substr(end + 1);
      ++line_number_;
      if (!line_.empty()) return true;
    }
    return false;
  }

  [[nodiscard]] std::string Here() const { return fmt::format("{}: line {}", name_, line_number_); }

  Result<void> ReadHeaderLine() {
    separator_ = line_.find(';') != std::string_view::npos    ? ';'
                 : line_.find('\t') != std::string_view::npos ? '\t'
                                                              : ',';
    cells_ = SplitCells(line_, separator_);
    const bool is_ours = options_.columns.empty() && !options_.rate_hz && !options_.scale_m &&
                         std::ranges::any_of(cells_, IsOurTime);
    if (!is_ours) {
      auto table = FindForeignTable(whole_, name_, options_);
      if (!table) return std::unexpected(table.error());
      if (*table) {
        NoteOverridden((*table)->columns);
        return Begin(std::move(**table));
      }
    }
    auto columns = ReadCsvColumns(cells_, name_);
    if (!columns) return std::unexpected(columns.error());
    SetColumns(std::move(*columns));
    return {};
  }

  // remembers where --columns or --scale reads a column otherwise than the file names it
  void NoteOverridden(const std::vector<CsvColumn>& columns) {
    if (options_.columns.empty() && !options_.scale_m) return;
    const ImportOptions own_words{.rate_hz = options_.rate_hz};
    const auto own = FindForeignTable(whole_, name_, own_words);
    if (!own || !*own || (*own)->columns.size() != columns.size()) return;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const CsvColumn& said = (*own)->columns[i];
      const CsvColumn& read = columns[i];
      if (said.unit.empty() || read.kind == CsvColumnKind::kLeftOut) continue;
      if (said.unit == read.unit && said.factor == read.factor) continue;
      overridden_.push_back(
          fmt::format("column {} holds units of {:g} {} by the file and of {:g} {} by --columns or "
                      "--scale; the "
                      "file is not believed",
                      i + 1, said.factor, said.unit, read.factor, read.unit));
    }
  }

  // the column, from 1 on, whose next values grow in even steps as times do; 0: none
  [[nodiscard]] std::size_t EvenColumn() const {
    constexpr std::size_t kRows = 8;
    constexpr double kEven = 0.05;
    std::vector<std::vector<double>> values(cells_.size());
    std::string_view rest = rest_;
    for (std::size_t row = 0; row < kRows && !rest.empty(); ++row) {
      const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
      const auto cells = SplitCells(Trimmed(rest.substr(0, end + 1)), separator_);
      rest.remove_prefix(end + 1);
      if (cells.size() != values.size()) return 0;
      for (std::size_t i = 0; i < cells.size(); ++i) {
        values[i].push_back(ReadNumberWithComma(cells[i]).value_or(kNan));
      }
    }
    if (values.empty() || values[0].size() < kRows) return 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double step = (values[i].back() - values[i].front()) / (kRows - 1);
      bool is_even = step > 0 && columns_[i].kind != CsvColumnKind::kTime;
      for (std::size_t k = 1; k < kRows; ++k) {
        is_even = is_even && std::abs(values[i][k] - values[i][k - 1] - step) <= kEven * step;
      }
      if (is_even) return i + 1;
    }
    return 0;
  }

  static bool IsOurTime(std::string_view cell) {
    const auto column = ReadCsvColumn(cell, "");
    return column && column->kind == CsvColumnKind::kTime;
  }

  // goes on behind the head of another program's table
  Result<void> Begin(ForeignTable table) {
    rest_ = whole_.substr(table.offset);
    line_number_ = table.line;
    separator_ = table.separator;
    for (auto& [key, value] : table.fields) comments_.metadata.fields[key] = std::move(value);
    for (std::string& note : table.notes) comments_.metadata.notes.push_back(std::move(note));
    is_foreign_ = true;
    SetColumns(std::move(table.columns));
    return {};
  }

  void SetColumns(std::vector<CsvColumn> columns) {
    columns_ = std::move(columns);
    for (const CsvColumn& column : columns_) {
      if (column.kind == CsvColumnKind::kStatus) has_status_ = true;
      if (column.kind == CsvColumnKind::kTime) has_times_ = true;
      if (column.kind != CsvColumnKind::kValue) continue;
      Channel channel;
      channel.name = column.name;
      channel.role = column.role;
      channel.unit = column.unit;
      record_.channels.push_back(std::move(channel));
    }
  }

  // a cell as a number; a comma is a decimal comma where it does not separate cells, unless points
  // stand in other cells and three digits behind it
  [[nodiscard]] std::optional<double> CellNumber(std::string_view cell) {
    const std::size_t comma = cell.find(',');
    if (comma == std::string_view::npos) {
      if (point_.empty() && cell.find('.') != std::string_view::npos) point_ = cell;
      return ReadNumber(cell);
    }
    const std::size_t end = std::min(cell.find_first_not_of("0123456789", comma + 1), cell.size());
    const bool may_group = end - comma == 4 && cell.find_first_of("123456789") < comma;
    if (comma_.empty() && may_group) comma_ = fmt::format("line {}: '{}'", line_number_, cell);
    return ReadNumberWithComma(cell);
  }

  Result<void> ReadRow() {
    cells_ = SplitCells(line_, separator_);
    // some programs end every line with a separator
    while (is_foreign_ && cells_.size() > columns_.size() && cells_.back().empty()) {
      cells_.pop_back();
    }
    if (cells_.size() != columns_.size()) {
      return CannotAnswer(
          Here(),
          fmt::format("has {} cells where the columns are {}", cells_.size(), columns_.size()),
          "complete or remove the line");
    }
    std::size_t channel = 0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      Result<void> done;
      if (columns_[i].kind == CsvColumnKind::kTime) done = TakeTime(cells_[i], columns_[i].factor);
      if (columns_[i].kind == CsvColumnKind::kValue) {
        done = TakeValue(cells_[i], columns_[i], &record_.channels[channel++]);
      }
      if (!done) return done;
    }
    ++record_.rows;
    return has_status_ ? TakeStatuses() : Result<void>{};
  }

  Result<void> TakeTime(std::string_view cell, double factor) {
    const auto printed = CellNumber(cell);
    if (!printed || !std::isfinite(*printed)) {
      return CannotAnswer(Here(), fmt::format("'{}' is no time", cell),
                          "every row needs a time; remove the line or write its time");
    }
    const double time_s = *printed * factor;
    // lines that came in one burst have one arrival time
    const bool may_stand = comments_.timing == Timing::kArrival;
    if (!times_.times_s().empty() &&
        (may_stand ? time_s < times_.times_s().back() : time_s <= times_.times_s().back())) {
      return CannotAnswer(Here(),
                          fmt::format("time {} s does not grow (the row before is at {} s)", time_s,
                                      times_.times_s().back()),
                          NotGrowingRemedy());
    }
    times_.Add(cell, time_s, factor);
    return {};
  }

  [[nodiscard]] std::string NotGrowingRemedy() const {
    if (const std::size_t column = EvenColumn(); column > 0) {
      return fmt::format(
          "column {} grows in even steps as times do: if the columns are swapped, name them from "
          "the "
          "left with --columns",
          column);
    }
    return "sort the rows, or print the times with more digits";
  }

  Result<void> TakeValue(std::string_view cell, const CsvColumn& column, Channel* channel) {
    std::optional<double> value = kNan;
    if (!cell.empty()) value = CellNumber(cell);
    if (!value) {
      return CannotAnswer(Here(), fmt::format("'{}' is no number (column '{}')", cell, column.name),
                          "leave the cell empty where there is no value, or remove the column");
    }
    const double si_value = *value * column.factor;
    const bool is_value = std::isfinite(si_value);
    channel->values.push_back(is_value ? si_value : kNan);
    channel->statuses.push_back(is_value ? SampleStatus::kOk : SampleStatus::kInvalid);
    return {};
  }

  // after the row's values: what their statuses say
  Result<void> TakeStatuses() {
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (columns_[i].kind != CsvColumnKind::kStatus) continue;
      const auto status = SampleStatusFromName(cells_[i]);
      if (!status) {
        return CannotAnswer(Here(), fmt::format("'{}' is no status", cells_[i]),
                            "the statuses are ok, repeated, over, under, invalid, device_error, "
                            "late, clipped, bad_frame");
      }
      for (std::size_t c = 0; c < record_.channels.size(); ++c) {
        if (columns_[i].channel != 0 && columns_[i].channel != c + 1) continue;
        SetStatus(*status, &record_.channels[c]);
      }
    }
    return {};
  }

  // a value that is not there is no measurement, and a number that is none is not kept
  static void SetStatus(SampleStatus status, Channel* channel) {
    if (IsMeasurement(status) && std::isnan(channel->values.back())) return;
    channel->statuses.back() = status;
    if (!IsMeasurement(status)) channel->values.back() = kNan;
  }

  Result<Record> Complete() {
    if (columns_.empty()) {
      return CannotAnswer(name_, "holds no columns",
                          "put a line such as time_s,displacement_m above the numbers");
    }
    if (record_.rows < 2) {
      return CannotAnswer(name_,
                          fmt::format("holds {} row{}", record_.rows, record_.rows == 1 ? "" : "s"),
                          "a measurement needs at least two");
    }
    record_.metadata = std::move(comments_.metadata);
    if (record_.metadata.source.empty()) record_.metadata.source = "imported";
    if (!comma_.empty() && !point_.empty()) {
      return CannotAnswer(
          name_,
          fmt::format("{} may be a decimal comma or group thousands, as '{}' has a point", comma_,
                      point_),
          "write all numbers with points and without grouping");
    }
    SetChannelKeys();
    if (has_times_) {
      std::move(times_).Complete(comments_.timing, std::move(comments_.stretches), &record_);
    } else {
      record_.stretches = {{.rows = record_.rows, .rate_hz = *options_.rate_hz}};
    }
    if (auto agreed = CheckRate(); !agreed) return std::unexpected(agreed.error());
    return std::move(record_);
  }

  // `# channel.2.name = CH2` and its like
  void SetChannelKeys() {
    for (std::size_t c = 0; c < record_.channels.size(); ++c) {
      Channel& channel = record_.channels[c];
      auto text = [&](const char* key) -> const std::string* {
        const auto found = comments_.channel_keys.find(fmt::format("{}.{}", c + 1, key));
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

  // two statements about the rate must be one
  [[nodiscard]] Result<void> CheckRate() const {
    constexpr double kTolerance = 0.01;
    if (!options_.rate_hz) return {};
    const double wanted_hz = *options_.rate_hz;
    const double rate_hz = std::ranges::max_element(record_.stretches, {}, &Stretch::rows)->rate_hz;
    if (std::abs(rate_hz - wanted_hz) <= kTolerance * wanted_hz) return {};
    return CannotAnswer(name_,
                        fmt::format("its times say {:.6g} rows a second and --rate says {:.6g} Hz",
                                    rate_hz, wanted_hz),
                        "leave out --rate, or name the time's unit in --columns (time_ms), or - to "
                        "leave the times out");
  }

  std::string_view whole_;
  std::string_view rest_;
  std::string name_;
  const ImportOptions& options_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  char separator_ = ',';
  std::vector<std::string_view> cells_;
  std::vector<CsvColumn> columns_;
  bool has_status_ = false;
  bool has_times_ = false;
  bool is_foreign_ = false;
  std::string comma_;  // the first number whose comma may group thousands, and where
  std::string point_;  // the first number with a point
  std::vector<std::string> overridden_;
  CsvComments comments_;
  PrintedTimes times_;
  Record record_;
};

}  // namespace

Result<Record> ParseCsv(std::string_view text, const std::string& name,
                        const ImportOptions& options, std::vector<std::string>* remarks) {
  std::vector<std::string> ignored;
  return Parser(text, name, options).Parse(remarks != nullptr ? remarks : &ignored);
}

}  // namespace haptometer::trial
