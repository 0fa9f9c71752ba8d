#include "trial/import/table/csv_rows.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "trial/import/table/table_cells.h"

namespace haptometer::trial {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kDayS = 86400;
// more are unsorted rows
constexpr std::size_t kMostSegments = 100'000;

// a missing value is no measurement, and a number with such a status is not retained
void SetStatus(SampleStatus status, Channel* channel) {
  if (IsMeasurement(status) && std::isnan(channel->values.back())) return;
  channel->statuses.back() = status;
  if (!IsMeasurement(status)) channel->values.back() = kNan;
}

// a number without a sign and an exponent, of which no digit before the point is rounded
struct Decimal {
  std::int64_t whole = 0;
  double fraction = 0;
};

std::optional<Decimal> ReadDecimal(std::string_view cell) {
  Decimal decimal;
  const auto parsed = std::from_chars(cell.begin(), cell.end(), decimal.whole);
  if (parsed.ec != std::errc() || decimal.whole < 0) return std::nullopt;
  const std::string_view rest(parsed.ptr, cell.end());
  if (rest.empty()) return decimal;
  const auto fraction = ReadNumberWithComma(rest);
  const bool is_plain = rest.find_first_not_of("0123456789", 1) == std::string_view::npos;
  if (!fraction || !is_plain) return std::nullopt;
  decimal.fraction = *fraction;
  return decimal;
}

// a reason why a cell that should be a number is none
std::string_view WhatElse(std::string_view cell) {
  // two signs or more: "1.234.567" or "12.03.2024"
  const auto points = std::ranges::count(cell, '.') + std::ranges::count(cell, ',');
  if (points < 2) return "";
  return ": a spreadsheet may have grouped its digits or made a date of it";
}

}  // namespace

void CsvRows::Begin(Layout layout) {
  layout_ = std::move(layout);
  for (const CsvColumn& column : layout_.columns) {
    if (column.kind == CsvColumnKind::kStatus) has_status_ = true;
    if (column.kind == CsvColumnKind::kTime) has_times_ = true;
    if (column.kind == CsvColumnKind::kNumber) numbers_.emplace();
    if (column.kind != CsvColumnKind::kValue) continue;
    channels_.push_back({.name = column.name, .role = column.role, .unit = column.unit});
  }
  segments_.emplace_back();
}

// memory for the rows at once; the number is an upper bound
void CsvRows::Reserve(std::size_t rows) {
  for (Channel& channel : channels_) {
    channel.values.reserve(rows);
    channel.statuses.reserve(rows);
  }
  if (has_times_) segments_.back().times.Reserve(rows);
}

std::string CsvRows::Here() const { return fmt::format("{}: line {}", name_, line_number_); }

Result<void> CsvRows::Take(std::string_view line, std::size_t line_number) {
  line_number_ = line_number;
  SplitCells(line, layout_.separator, &cells_);
  // a row of empty cells at the end of a table is no row; followed by another row it is a gap
  if (layout_.is_foreign && std::ranges::all_of(cells_, &std::string_view::empty)) {
    empty_line_ = line_number;
    return {};
  }
  HAPTOMETER_TRY(CheckWidth());
  // number of the value column in this row
  std::size_t channel = 0;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const CsvColumn& column = layout_.columns[i];
    Result<void> done;
    // of what is no value only a decimal comma counts, as it is the file's
    const bool is_number = column.kind == CsvColumnKind::kNumber;
    if ((is_number || column.kind == CsvColumnKind::kLeftOut) &&
        !MayGroupThousands(cells_[i], ',') && cells_[i].find(',') != std::string_view::npos) {
      (void)CellNumber(cells_[i]);
    }
    if (column.kind == CsvColumnKind::kDate) date_ = cells_[i];
    if (column.kind == CsvColumnKind::kTime) {
      done = column.is_clock ? TakeClock(cells_[i], column) : TakeTime(cells_[i], column);
    }
    if (is_number) numbers_->Add(ReadNumberWithComma(cells_[i]).value_or(kNan), line_number);
    if (column.kind == CsvColumnKind::kValue) {
      done = TakeValue(cells_[i], column, &channels_[channel++]);
    }
    if (!done) return done;
  }
  Segment& segment = segments_.back();
  if (segment.rows == 0) segment.line = line_number;
  ++segment.rows;
  ++rows_;
  return has_status_ ? TakeStatuses() : Result<void>{};
}

Result<void> CsvRows::CheckWidth() {
  HAPTOMETER_TRY(CheckEmptyRow());
  const auto& columns = layout_.columns;
  // some programs end every line with a separator, or only some
  while (layout_.is_foreign && cells_.size() > columns.size() && cells_.back().empty()) {
    cells_.pop_back();
  }
  // omitted columns at the end may be absent
  while (layout_.is_foreign && cells_.size() < columns.size() &&
         columns[cells_.size()].kind == CsvColumnKind::kLeftOut) {
    cells_.emplace_back();
  }
  if (cells_.size() == columns.size()) return {};
  return CannotAnswer(
      Here(), fmt::format("has {} cells where the columns are {}", cells_.size(), columns.size()),
      "complete or remove the line");
}

// without a time column only its place gives a row its time, so an empty row between rows is a gap
Result<void> CsvRows::CheckEmptyRow() {
  const std::size_t line = std::exchange(empty_line_, 0);
  if (line == 0 || has_times_ || rows_ == 0) return {};
  return CannotAnswer(fmt::format("{}: line {}", name_, line),
                      "has empty cells alone between rows that have no times",
                      "write its values, or remove it where no row is missing");
}

// what a number shows of the meaning of a comma or point: of "1,234" it may be either
void CsvRows::Note(std::string_view number, Sign* sign) const {
  if (sign->is_decimal || number.find(sign->sign) == std::string_view::npos) return;
  if (sign->first.empty()) sign->first = number;
  if (!MayGroupThousands(number, sign->sign)) {
    sign->is_decimal = true;
  } else if (sign->may_group.empty()) {
    sign->may_group = fmt::format("line {}: '{}'", line_number_, number);
  }
}

// a comma is a decimal comma where it does not separate cells, unless CheckCommas finds otherwise
std::optional<double> CsvRows::CellNumber(std::string_view cell) {
  const auto number = ReadNumberWithComma(cell);
  if (!number) return std::nullopt;
  Note(cell, &commas_);
  Note(cell, &points_);
  return number;
}

// seconds since the first row's time of day, plus the whole days between them
Result<void> CsvRows::TakeClock(std::string_view cell, const CsvColumn& column) {
  const auto clock_s = ReadClock(cell);
  if (!clock_s) return NoTime(cell);
  // seconds of a time of day are never grouped
  if (cell.find(',', cell.rfind(':')) != std::string_view::npos) {
    commas_.is_decimal = true;
    if (commas_.first.empty()) commas_.first = cell;
  }
  const std::string_view date = date_.empty() ? DateBefore(cell) : date_;
  const auto days = days_.Take(date, *clock_s);
  if (!days) {
    return CannotAnswer(Here(),
                        fmt::format("the date changes from '{}' to '{}', and the number of days "
                                    "between them is not clear",
                                    days_.date(), date),
                        "write the dates as yyyy-mm-dd");
  }
  if (!first_clock_s_) first_clock_s_ = clock_s;
  return PlaceTime(cell, *clock_s - *first_clock_s_ + *days * kDayS, column);
}

std::unexpected<Error> CsvRows::NoTime(std::string_view cell) const {
  return CannotAnswer(Here(), fmt::format("'{}' is not a time{}", cell, WhatElse(cell)),
                      "every row needs a time; remove the line or write its time");
}

// The number in a column of times; of numbers from 2^30 on, as of seconds or nanoseconds since
// 1970, what lies between it and the first one's whole part: they have more digits than a double.
std::optional<double> CsvRows::SinceFirst(std::string_view cell, const CsvColumn& column) {
  constexpr std::int64_t kLarge = std::int64_t{1} << 30;
  const auto number = CellNumber(cell);
  if (rows_ > 0 && first_whole_ == 0) return number;
  const auto decimal = ReadDecimal(cell);
  if (rows_ == 0 && !column.is_count && decimal && decimal->whole >= kLarge) {
    first_whole_ = decimal->whole;
    segments_.back().times.CountFrom(static_cast<double>(first_whole_) * column.factor);
  }
  if (first_whole_ == 0 || !number) return number;
  return decimal ? static_cast<double>(decimal->whole - first_whole_) + decimal->fraction
                 : *number - static_cast<double>(first_whole_);
}

Result<void> CsvRows::TakeTime(std::string_view cell, const CsvColumn& column) {
  // time in s = printed * factor + offset
  const double time_s = SinceFirst(cell, column).value_or(kNan) * column.factor + column.offset;
  if (!std::isfinite(time_s)) return NoTime(cell);
  return PlaceTime(cell, time_s, column);
}

Result<void> CsvRows::PlaceTime(std::string_view cell, double time_s, const CsvColumn& column) {
  const auto& times_s = segments_.back().times.times_s();
  const double origin_s = segments_.back().times.origin_s();
  // a time that falls begins a segment in a foreign table, and is an error in one of this program
  if (!times_s.empty() && time_s < times_s.back()) {
    if (!layout_.is_foreign || segments_.size() == kMostSegments) {
      is_time_falling_ = true;
      return CannotAnswer(Here(),
                          fmt::format("time {} s does not grow (the row before is at {} s)",
                                      origin_s + time_s, origin_s + times_s.back()),
                          "sort the rows, or print the times with more digits");
    }
    segments_.push_back({.first_row = rows_, .line = line_number_});
    segments_.back().times.CountFrom(origin_s);
  }
  // rows of one burst have one arrival time; too few digits give several rows the same time
  Segment& segment = segments_.back();
  if (!segment.times.times_s().empty() && time_s == segment.times.times_s().back() &&
      segment.repeat_line == 0) {
    segment.repeat_line = line_number_;
  }
  PrintedTimes& times = segment.times;
  // counts of a column of row numbers have no digits that were rounded
  if (column.is_count) {
    times.AddCount(time_s);
  } else {
    times.Add(cell, time_s, column.factor);
  }
  return {};
}

Result<void> CsvRows::TakeValue(std::string_view cell, const CsvColumn& column, Channel* channel) {
  // an empty cell is an invalid sample
  auto number = cell.empty() ? std::nullopt : CellNumber(cell);
  auto status = SampleStatus::kInvalid;
  if (!cell.empty() && (!number || !std::isfinite(*number))) {
    // missing values may be words such as OVER or ----
    const auto word = ReadNoNumber(cell);
    if (!word && !number) {
      return CannotAnswer(
          Here(),
          fmt::format("'{}' is not a number (column '{}'){}", cell, column.name, WhatElse(cell)),
          "leave the cell empty where there is no value, or remove the column");
    }
    status = word.value_or(status);
  }
  if (const auto scpi = number ? ReadScpiNoNumber(*number) : std::nullopt) {
    status = *scpi;
    number.reset();
  }
  // in SI units: value = number * factor
  const double value_si = number.value_or(kNan) * column.factor;
  const bool is_value = std::isfinite(value_si);
  channel->values.push_back(is_value ? value_si : kNan);
  channel->statuses.push_back(is_value ? SampleStatus::kOk : status);
  return {};
}

// statuses are taken behind all values of the row, because they override them
Result<void> CsvRows::TakeStatuses() {
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const CsvColumn& column = layout_.columns[i];
    if (column.kind != CsvColumnKind::kStatus) continue;
    const auto status = SampleStatusFromName(cells_[i]);
    if (!status) {
      return CannotAnswer(Here(), fmt::format("'{}' is not a status", cells_[i]),
                          "the statuses are ok, repeated, over, under, invalid, device_error, "
                          "late, clipped, bad_frame");
    }
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      // 0: the status is valid for all channels
      if (column.channel != 0 && column.channel != c + 1) continue;
      SetStatus(*status, &channels_[c]);
    }
  }
  return {};
}

// Meanings that differ by a factor of 1000. A comma that may group thousands is ambiguous beside
// points, and where no number shows that it is a decimal one; a point only beside commas.
Result<void> CsvRows::CheckCommas() const {
  const auto refuse = [&](const Sign& sign, std::string_view name, const std::string& why) {
    return CannotAnswer(
        name_,
        fmt::format("{} may be a decimal {} or group thousands, {}", sign.may_group, name, why),
        "write all numbers with points and without grouping");
  };
  if (!commas_.may_group.empty() && !points_.first.empty()) {
    return refuse(commas_, "comma", fmt::format("as '{}' has a point", points_.first));
  }
  if (!commas_.may_group.empty() && !commas_.is_decimal) {
    return refuse(commas_, "comma", "and no other number shows which");
  }
  if (!points_.may_group.empty() && !points_.is_decimal && has_commas()) {
    return refuse(points_, "point", fmt::format("as '{}' has a comma", commas_.first));
  }
  return {};
}

}  // namespace haptometer::trial
