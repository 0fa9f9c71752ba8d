#include "trial/import/number_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "trial/calibration.h"
#include "trial/export/object_names.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/csv_rows.h"
#include "trial/import/table/foreign_table.h"
#include "trial/import/table/named_columns.h"
#include "trial/import/table/row_times.h"
#include "trial/import/table/written_twice.h"

namespace haptometer::trial {
namespace {

constexpr const char* kNameColumns = "give <columns> such as time_s,displacement_m";

// turns the columns of one table into a record
class Reader {
 public:
  Reader(NumberTable table, const std::string& name, const ImportOptions& options)
      : table_(std::move(table)), name_(name), options_(options) {}

  Result<Recording> Read(FileKind kind) {
    HAPTOMETER_TRY(CheckShape());
    HAPTOMETER_TRY(options_.columns.empty() ? NameColumns() : NameByOptions());
    NumberChannels(&columns_);
    HAPTOMETER_TRY(NumberStatuses());
    HAPTOMETER_TRY(KeepChannel(options_, name_, &columns_));
    HAPTOMETER_TRY(ApplyScales(options_, &columns_));
    HAPTOMETER_TRY(AddChannels());
    HAPTOMETER_TRY(SetTimes());
    HAPTOMETER_TRY(CheckRate(name_, options_, record_));
    // a table that states no source is an import
    record_.metadata.source = "imported";
    record_.metadata.nominal_rate_hz = options_.rate_hz;
    if (options_.format) findings_.Note(FindingKind::kFormatNotUsed);
    if (!options_.calibration.empty()) {
      HAPTOMETER_TRY(CalibrateRecord(options_.calibration, name_, &record_, &findings_));
    }
    Recording recording{.record = std::move(record_), .report = {}};
    recording.report.kind = kind;
    recording.report.closed = true;
    recording.report.rows = recording.report.next_row = recording.record.rows;
    recording.report.findings = std::move(findings_);
    return recording;
  }

 private:
  Result<void> CheckShape() {
    if (table_.columns.empty()) return CannotAnswer(name_, "holds no column of numbers");
    const std::size_t rows = table_.columns.front().values.size();
    for (const NumberColumn& column : table_.columns) {
      if (column.values.size() == rows) continue;
      return CannotAnswer(
          name_, fmt::format("has columns of {} and of {} numbers", rows, column.values.size()));
    }
    if (rows < 2) {
      return CannotAnswer(name_, fmt::format("holds {} row{}", rows, rows == 1 ? "" : "s"),
                          "a measurement needs at least two");
    }
    record_.rows = rows;
    return {};
  }

  // names of this program; a single column without a name needs none
  Result<void> NameColumns() {
    const bool is_alone = table_.columns.size() == 1;
    for (const NumberColumn& column : table_.columns) {
      if (column.name.empty() && !is_alone) {
        return CannotAnswer(name_,
                            fmt::format("does not name its {} columns", table_.columns.size()),
                            kNameColumns);
      }
      if (StatusOf(column.name)) {
        columns_.push_back({.kind = CsvColumnKind::kStatus, .name = column.name, .unit = ""});
        continue;
      }
      HAPTOMETER_LET(auto read,
                     ReadCsvColumn(column.name.empty() ? "channel_1" : column.name, name_));
      columns_.push_back(std::move(read));
    }
    return CheckKinds();
  }

  // COLUMN_status is about COLUMN, whose place is given; nothing for another name
  [[nodiscard]] std::optional<std::size_t> StatusOf(const std::string& name) const {
    const auto found = std::ranges::find_if(table_.columns, [&](const NumberColumn& column) {
      return !column.name.empty() && objects::StatusName(column.name) == name;
    });
    if (found == table_.columns.end()) return std::nullopt;
    return static_cast<std::size_t>(found - table_.columns.begin());
  }

  Result<void> NameByOptions() {
    if (options_.columns.size() != table_.columns.size()) {
      return Usage("<columns>",
                   fmt::format("names {} columns where {} has {}", options_.columns.size(), name_,
                               table_.columns.size()),
                   "name each from the left, - for one to leave out");
    }
    for (const std::string& word : options_.columns) {
      HAPTOMETER_LET(auto column, ReadToldColumn(word, options_));
      columns_.push_back(std::move(column));
    }
    return CheckKinds();
  }

  // at most one time, and a channel; times of arrival beside them are not used
  Result<void> CheckKinds() {
    for (CsvColumn& column : columns_) {
      if (column.kind == CsvColumnKind::kArrival) column.kind = CsvColumnKind::kLeftOut;
    }
    if (std::ranges::count(columns_, CsvColumnKind::kTime, &CsvColumn::kind) > 1) {
      return CannotAnswer(name_, "two columns are named time", "keep one of them");
    }
    if (std::ranges::count(columns_, CsvColumnKind::kValue, &CsvColumn::kind) == 0) {
      return CannotAnswer(name_, "no column beside the time holds values", kNameColumns);
    }
    return {};
  }

  // the channel that each column of statuses is about, by its number
  Result<void> NumberStatuses() {
    const auto channels = static_cast<std::size_t>(
        std::ranges::count(columns_, CsvColumnKind::kValue, &CsvColumn::kind));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      CsvColumn& column = columns_[i];
      if (column.kind != CsvColumnKind::kStatus) continue;
      const auto of = options_.columns.empty() ? StatusOf(column.name) : std::nullopt;
      if (of) column.channel = columns_[*of].channel;
      if (column.channel > channels || (of && column.channel == 0)) {
        return CannotAnswer(
            name_, fmt::format("column '{}' is about a channel that is not there", column.name),
            fmt::format("there are {} channels, counted from 1", channels));
      }
    }
    return {};
  }

  // channels in SI units, then the statuses, which may be of all of them
  Result<void> AddChannels() {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].kind == CsvColumnKind::kValue) AddChannel(columns_[i], &table_.columns[i]);
    }
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].kind != CsvColumnKind::kStatus) continue;
      HAPTOMETER_TRY(ApplyStatuses(columns_[i], table_.columns[i].values));
    }
    return {};
  }

  void AddChannel(const CsvColumn& as, NumberColumn* column) {
    Channel channel{.name = as.name, .role = as.role, .unit = as.unit};
    channel.values = std::move(column->values);
    channel.statuses = std::move(column->statuses);
    channel.statuses.resize(record_.rows, SampleStatus::kOk);
    for (std::size_t row = 0; row < record_.rows; ++row) {
      double& value = channel.values[row];
      // in SI units: value = number * factor
      value *= as.factor;
      SampleStatus& status = channel.statuses[row];
      if (IsMeasurement(status) && !std::isfinite(value)) status = SampleStatus::kInvalid;
      if (!IsMeasurement(status)) value = std::numeric_limits<double>::quiet_NaN();
    }
    record_.channels.push_back(std::move(channel));
  }

  Result<void> ApplyStatuses(const CsvColumn& as, const std::vector<double>& numbers) {
    for (std::size_t row = 0; row < record_.rows; ++row) {
      const double number = numbers[row];
      if (!(number >= 0 && number < kSampleStatusCount && number == std::floor(number))) {
        return CannotAnswer(
            name_, fmt::format("row {} of column '{}' is no status", row + 1, as.name),
            fmt::format("statuses are whole numbers from 0 to {}", kSampleStatusCount - 1));
      }
      const auto status = static_cast<SampleStatus>(static_cast<std::uint8_t>(number));
      for (std::size_t c = 0; c < record_.channels.size(); ++c) {
        // channels that are read count from 1; 0: the status is valid for all
        const bool is_meant = as.channel == 0 || as.channel == c + 1;
        if (is_meant) SetStatus(status, row, &record_.channels[c]);
      }
    }
    return {};
  }

  // a missing value is no measurement, and a number with such a status is not retained
  static void SetStatus(SampleStatus status, std::size_t row, Channel* channel) {
    if (IsMeasurement(status) && std::isnan(channel->values[row])) return;
    channel->statuses[row] = status;
    if (!IsMeasurement(status)) channel->values[row] = std::numeric_limits<double>::quiet_NaN();
  }

  // by the column of times, else by the user's rate or the file's
  Result<void> SetTimes() {
    if (options_.segment && *options_.segment != 1) {
      return CannotAnswer(name_, "has 1 segment", "leave <segment> out");
    }
    TimeWords words;
    if (table_.rate_hz) {
      words.clock = StatedClock{1 / *table_.rate_hz, std::nullopt, "sample rate"};
    }
    const auto time = std::ranges::find(columns_, CsvColumnKind::kTime, &CsvColumn::kind);
    if (time == columns_.end()) {
      if (!words.clock && !options_.rate_hz) {
        return CannotAnswer(name_, "has no column of times and states no rate",
                            "give <rate> 10kHz, or name the times (time_s) in <columns>");
      }
      record_.stretches = {UniformTimes(words, options_, record_.rows, &findings_)};
      return {};
    }
    const auto column = static_cast<std::size_t>(time - columns_.begin());
    HAPTOMETER_LET(auto segment, TimesOf(*time, table_.columns[column]));
    MarkRowsWrittenTwice(record_.channels, &segment);
    std::vector<std::size_t> left_out;
    HAPTOMETER_LET(auto part, ReadSegmentTimes(name_, words, options_, std::move(segment),
                                               &left_out, &findings_));
    record_.stretches = std::move(part.stretches);
    record_.raw_times_s = std::move(part.raw_times_s);
    record_.timing = part.timing;
    record_.times_are_known = part.times_are_known;
    LeaveOutRows(left_out, &record_);
    return {};
  }

  // times with all the digits of a double, so that only 32-bit floats count as rounded
  Result<CsvRows::Segment> TimesOf(const CsvColumn& as, const NumberColumn& column) const {
    CsvRows::Segment segment{.rows = record_.rows, .line = 1};
    segment.times.Reserve(record_.rows);
    // the differences of large counts, as of microseconds since 1970, have fewer digits than they
    const double first = column.values[0];
    const double origin = column.is_count && std::isfinite(first) ? first : 0;
    segment.times.CountFrom(origin * as.factor);
    for (std::size_t row = 0; row < record_.rows; ++row) {
      const double time_s = (column.values[row] - origin) * as.factor;
      const auto& before = segment.times.times_s();
      if (!std::isfinite(time_s) || (!before.empty() && time_s < before.back())) {
        return CannotAnswer(
            name_,
            fmt::format("its time in row {} is {} s, which {}", row + 1,
                        column.values[row] * as.factor,
                        std::isfinite(time_s) ? "is before that of the row above" : "is no time"),
            "sort its rows, or name another column time_s in <columns>");
      }
      if (!before.empty() && time_s == before.back() && segment.repeat_line == 0) {
        segment.repeat_line = row + 1;
      }
      if (column.is_count) {
        segment.times.AddCount(time_s, as.factor);
      } else {
        segment.times.Add(fmt::format("{:.16e}", column.values[row]), time_s, as.factor);
      }
    }
    return segment;
  }

  NumberTable table_;
  const std::string& name_;
  const ImportOptions& options_;
  std::vector<CsvColumn> columns_{};  // one each of table_
  Record record_{};
  Findings findings_{};
};

}  // namespace

Result<std::vector<NumberColumn>> ColumnsOfMatrix(std::vector<double> numbers, std::size_t rows,
                                                  std::size_t columns, bool is_by_row,
                                                  const std::string& label, const std::string& name,
                                                  const ImportOptions& options) {
  HAPTOMETER_CHECK(numbers.size() == rows * columns, "{} numbers", numbers.size());
  if (rows == 1 || columns == 1) {
    return std::vector<NumberColumn>{{.name = label, .values = std::move(numbers)}};
  }
  const std::size_t named = options.columns.size();
  if (named != columns && named != rows) {
    return CannotAnswer(name,
                        fmt::format("is a matrix of {} x {} numbers without names", rows, columns),
                        fmt::format("{}, a name for each column", kNameColumns));
  }
  // columns of the table lie along the side that has as many as are named
  const bool is_along_rows = named != columns;
  std::vector<NumberColumn> table(named);
  const std::size_t length = is_along_rows ? columns : rows;
  for (std::size_t c = 0; c < named; ++c) {
    table[c].values.reserve(length);
    for (std::size_t i = 0; i < length; ++i) {
      const std::size_t row = is_along_rows ? c : i;
      const std::size_t column = is_along_rows ? i : c;
      table[c].values.push_back(numbers[is_by_row ? row * columns + column : column * rows + row]);
    }
  }
  return table;
}

Result<Recording> ReadNumberTable(NumberTable table, FileKind kind, const std::string& name,
                                  const ImportOptions& options) {
  return Reader(std::move(table), name, options).Read(kind);
}

}  // namespace haptometer::trial
