#include "trial/import/csv.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/input_file.h"
#include "trial/import/csv_column.h"
#include "trial/import/csv_comment.h"
#include "trial/import/printed_grid.h"
#include "trial/time_base.h"

namespace haptometer::trial {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// how a printed time is rounded: places behind the point and digits that count
struct Digits {
  int decimals = 0;
  int significant = 0;
};

Digits DigitsOf(std::string_view text) {
  Digits digits;
  bool is_behind_point = false;
  for (const char c : text) {
    if (c == 'e' || c == 'E') break;
    if (c == '.' || c == ',') is_behind_point = true;
    if (c < '0' || c > '9') continue;
    if (is_behind_point) ++digits.decimals;
    if (c != '0' || digits.significant > 0) ++digits.significant;
  }
  const std::size_t exponent = text.find_first_of("eE");
  if (exponent != std::string_view::npos) {
    const auto power = ReadNumber(text.substr(exponent + 1));
    digits.decimals -= static_cast<int>(std::clamp(power.value_or(0), -400.0, 400.0));
  }
  return digits;
}

// Turns lines into a record; every member function reports the line it stands at.
class Parser {
 public:
  Parser(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

  Result<Record> Parse() {
    if (auto done = SkipEncodingMark(); !done) return std::unexpected(done.error());
    while (NextLine()) {
      const auto done = line_.starts_with('#') ? ReadCsvComment(line_, Here(), &comments_)
                        : columns_.empty()     ? ReadHeaderLine()
                                               : ReadRow();
      if (!done) return std::unexpected(done.error());
    }
    return Complete();
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

  // cells of the line, without blanks and quotes
  void SplitLine() {
    cells_.clear();
    std::string_view line = line_;
    for (;;) {
      const std::size_t end = line.find(separator_);
      std::string_view cell = Trimmed(line.substr(0, end));
      if (cell.size() >= 2 && cell.starts_with('"') && cell.ends_with('"')) {
        cell = Trimmed(cell.substr(1, cell.size() - 2));
      }
      cells_.push_back(cell);
      if (end == std::string_view::npos) return;
      line.remove_prefix(end + 1);
    }
  }

  Result<void> ReadHeaderLine() {
    if (line_.find(';') != std::string_view::npos) {
      separator_ = ';';
    } else if (line_.find('\t') != std::string_view::npos) {
      separator_ = '\t';
    }
    SplitLine();
    auto columns = ReadCsvColumns(cells_, name_);
    if (!columns) return std::unexpected(columns.error());
    columns_ = std::move(*columns);
    for (const CsvColumn& column : columns_) {
      if (column.kind == CsvColumnKind::kStatus) has_status_ = true;
      if (column.kind != CsvColumnKind::kValue) continue;
      Channel channel;
      channel.name = column.name;
      channel.role = column.role;
      channel.unit = column.unit;
      record_.channels.push_back(std::move(channel));
    }
    return {};
  }

  // the cell as a number; a comma is a decimal comma where it does not separate cells
  [[nodiscard]] std::optional<double> CellNumber(std::string_view cell) const {
    if (cell.find(',') == std::string_view::npos) return ReadNumber(cell);
    std::string with_point(cell);
    std::ranges::replace(with_point, ',', '.');
    return ReadNumber(with_point);
  }

  Result<void> ReadRow() {
    SplitLine();
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
    if (!times_s_.empty() && time_s <= times_s_.back()) {
      return CannotAnswer(Here(),
                          fmt::format("time {} s does not grow (the row before is at {} s)", time_s,
                                      times_s_.back()),
                          "sort the rows, or print the times with more digits");
    }
    times_s_.push_back(time_s);
    digits_.push_back(DigitsOf(cell));
    time_factor_ = factor;
    return {};
  }

  Result<void> TakeValue(std::string_view cell, const CsvColumn& column, Channel* channel) {
    std::optional<double> value = kNan;
    if (!cell.empty()) value = CellNumber(cell);
    if (!value) {
      return CannotAnswer(Here(), fmt::format("'{}' is no number (column '{}')", cell, column.name),
                          "leave the cell empty where there is no value, or remove the column");
    }
    const bool is_value = std::isfinite(*value);
    channel->values.push_back(is_value ? *value * column.factor : kNan);
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
    SetChannelKeys();
    SetTimes();
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

  void SetTimes() {
    const bool times_are_raw = comments_.timing != Timing::kUniform;
    record_.timing = comments_.timing;
    if (StretchesFit()) {
      record_.stretches = std::move(comments_.stretches);
      if (times_are_raw) record_.raw_times_s = std::move(times_s_);
      return;
    }
    if (!times_are_raw) {
      if (auto grid = PrintedGrid(times_s_, HalfDigits())) {
        record_.stretches = std::move(*grid);
        return;
      }
    }
    // neither a grid nor explained: the mean line, beside the times as they stand
    std::vector<std::int64_t> time_ns;
    time_ns.reserve(times_s_.size());
    for (const double t : times_s_) {
      time_ns.push_back(static_cast<std::int64_t>(std::clamp(t * 1e9, -9e18, 9e18)));
    }
    if (!times_are_raw) record_.timing = Timing::kPolled;
    record_.stretches = record_.timing == Timing::kArrival
                            ? FitArrivalTimes(time_ns, record_.metadata.nominal_rate_hz)
                            : FitPolledTimes(time_ns, time_ns, record_.metadata.nominal_rate_hz);
    record_.raw_times_s = std::move(times_s_);
  }

  // whether the file's own stretches still describe its rows (somebody may have edited them)
  [[nodiscard]] bool StretchesFit() const {
    constexpr double kLargestDelayS = 1;
    std::size_t row = 0;
    for (const Stretch& stretch : comments_.stretches) {
      if (stretch.first_row != row || stretch.rows > record_.rows - row) return false;
      for (; row < stretch.first_row + stretch.rows; ++row) {
        const double line_s =
            stretch.start_s + static_cast<double>(row - stretch.first_row) / stretch.rate_hz;
        const double bound_s =
            comments_.timing != Timing::kUniform ? kLargestDelayS : 1e-6 / stretch.rate_hz;
        if (!(std::abs(times_s_[row] - line_s) <= bound_s)) return false;
      }
    }
    return row == record_.rows;
  }

  // half a unit of the last printed place, for each time: the file prints either a number of
  // decimals or a number of digits, and drops zeros at the end
  [[nodiscard]] std::vector<double> HalfDigits() const {
    Digits most;
    for (const Digits& digits : digits_) {
      most.decimals = std::max(most.decimals, digits.decimals);
      most.significant = std::max(most.significant, digits.significant);
    }
    std::vector<double> half;
    for (const double time_s : times_s_) {
      const double printed = std::abs(time_s / time_factor_);
      const double magnitude = printed > 0 ? std::floor(std::log10(printed)) : -most.decimals;
      const double place = std::max<double>(-most.decimals, magnitude + 1 - most.significant);
      half.push_back(0.5 * std::pow(10.0, place) * time_factor_);
    }
    return half;
  }

  std::string_view rest_;
  std::string name_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  char separator_ = ',';
  std::vector<std::string_view> cells_;
  std::vector<CsvColumn> columns_;
  bool has_status_ = false;
  CsvComments comments_;
  std::vector<double> times_s_;
  std::vector<Digits> digits_;
  double time_factor_ = 1;
  Record record_;
};

}  // namespace

Result<Record> ReadCsv(const std::string& path) {
  const auto text = ReadInputFile(path);
  if (!text) return std::unexpected(text.error());
  return ParseCsv(*text, path);
}

Result<Record> ParseCsv(std::string_view text, const std::string& name) {
  return Parser(text, name).Parse();
}

}  // namespace haptometer::trial
