#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/dates.h"
#include "trial/import/table/printed_times.h"
#include "trial/import/table/row_numbers.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Turns the lines of a table into channels and times; errors name the line.
class CsvRows {
 public:
  /// What the lines below the names look like.
  struct Layout {
    char separator = ',';
    std::vector<CsvColumn> columns{};
    /// A table of another program: rows may be padded with empty cells, and times that fall begin a
    /// new segment.
    bool is_foreign = false;
  };

  /// Rows that follow each other with times that do not fall.
  struct Segment {
    std::size_t first_row = 0;
    std::size_t rows = 0;
    std::size_t line = 0;         ///< of its first row
    std::size_t repeat_line = 0;  ///< of its first row with the time of the row before
    PrintedTimes times{};
    std::size_t copies = 0;      ///< rows that were written twice (MarkRowsWrittenTwice)
    std::size_t first_copy = 0;  ///< the first of them, counted as times count
  };

  explicit CsvRows(std::string name) : name_(std::move(name)) {}

  void Begin(Layout layout);
  /// Room for `rows` rows.
  void Reserve(std::size_t rows);
  /// Takes one line, which is not blank.
  [[nodiscard]] Result<void> Take(std::string_view line, std::size_t line_number);

  [[nodiscard]] bool has_begun() const { return !layout_.columns.empty(); }
  [[nodiscard]] bool has_times() const { return has_times_; }
  /// Whether the error of the last Take() is that its time lies before that of the row before.
  [[nodiscard]] bool is_time_falling() const { return is_time_falling_; }
  [[nodiscard]] std::size_t rows() const { return rows_; }
  [[nodiscard]] std::vector<Channel>& channels() { return channels_; }
  [[nodiscard]] std::vector<Segment>& segments() { return segments_; }
  /// Of the column that numbers the rows; nothing where there is none.
  [[nodiscard]] const std::optional<RowNumbers>& numbers() const { return numbers_; }
  /// Whether a number has a comma, which CheckCommas finds to be a decimal one.
  [[nodiscard]] bool has_commas() const { return !commas_.first.empty(); }
  /// Whether commas, and points beside them, are decimal ones all along. Errors
  /// (Cause::kCannotAnswer): they may group thousands.
  [[nodiscard]] Result<void> CheckCommas() const;

 private:
  [[nodiscard]] std::string Here() const;
  [[nodiscard]] std::optional<double> CellNumber(std::string_view cell);
  [[nodiscard]] Result<void> CheckWidth();
  [[nodiscard]] Result<void> CheckEmptyRow();
  [[nodiscard]] Result<void> TakeTime(std::string_view cell, const CsvColumn& column);
  [[nodiscard]] std::optional<double> SinceFirst(std::string_view cell, const CsvColumn& column);
  [[nodiscard]] std::unexpected<Error> NoTime(std::string_view cell) const;
  [[nodiscard]] Result<void> TakeClock(std::string_view cell, const CsvColumn& column);
  [[nodiscard]] Result<void> PlaceTime(std::string_view cell, double time_s,
                                       const CsvColumn& column);
  [[nodiscard]] Result<void> TakeValue(std::string_view cell, const CsvColumn& column,
                                       Channel* channel);
  [[nodiscard]] Result<void> TakeStatuses();

  std::string name_;
  Layout layout_;
  std::vector<std::string_view> cells_;
  std::size_t line_number_ = 0;
  std::size_t empty_line_ = 0;  // of empty cells, behind which no row has come; 0: none
  std::size_t rows_ = 0;
  bool has_status_ = false;
  bool has_times_ = false;
  bool is_time_falling_ = false;
  std::vector<Channel> channels_;
  std::vector<Segment> segments_;
  std::optional<RowNumbers> numbers_;
  std::optional<double> first_clock_s_;
  std::int64_t first_whole_ = 0;  // of the first time, where it lies long after 0; else 0
  DayCount days_;
  std::string_view date_;  // of the row, where a column of dates stands before the times
  // what numbers show of a comma or a point in them
  struct Sign {
    char sign = ',';
    std::string first{};      // number with it
    std::string may_group{};  // the first number whose thousands it may group, and where
    bool is_decimal = false;  // it cannot group thousands in one of them
  };
  void Note(std::string_view number, Sign* sign) const;

  Sign commas_{.sign = ','};
  Sign points_{.sign = '.'};
};

}  // namespace haptometer::trial
