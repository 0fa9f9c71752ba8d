#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "trial/import/readers.h"
#include "trial/import/table/csv_header.h"
#include "trial/import/table/csv_rows.h"
#include "trial/import/table/foreign_table.h"
#include "trial/import/table/named_columns.h"
#include "trial/import/table/printed_times.h"
#include "trial/import/table/row_times.h"
#include "trial/import/table/stated_clock.h"
#include "trial/import/table/table_cells.h"
#include "trial/import/table/written_twice.h"

namespace haptometer::trial {
namespace {

// first cells of the file, end of each header
constexpr std::string_view kMagic = "LabVIEW Measurement";
constexpr std::string_view kHeaderEnd = "***End_of_Header***";
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kRemedy = "write the file again, or export it as a CSV with time_s";

// X_Columns of the file header: no X, one X for all channels, or one before each channel
enum class XColumns : std::uint8_t { kNone, kOne, kMulti };

using Keys = std::map<std::string, std::vector<std::string>, std::less<>>;

// the keys of a segment's header by the specification, in lower case; any of them may be the first
constexpr std::array<std::string_view, 17> kSegmentKeys{
    "channels",     "samples",     "date",        "time",         "notes",       "test_name",
    "test_numbers", "test_series", "uut_m/n",     "uut_name",     "uut_s/n",     "x_dimension",
    "x0",           "delta_x",     "y_dimension", "x_unit_label", "y_unit_label"};

// one segment's header and rows
struct Segment {
  Keys keys{};
  std::vector<std::string> names{};  // of the channels
  CsvRows::Segment rows{};
};

// equality within 1e-6, relative
bool AreEqual(double a, double b) {
  return std::abs(a - b) <= 1e-6 * std::max(std::abs(a), std::abs(b));
}

// turns the lines of a LabVIEW measurement file into a record, one segment after another
class Parser {
 public:
  Parser(std::string_view text, const std::string& name, const ImportOptions& options,
         Findings* findings)
      : rest_(text), name_(name), options_(options), findings_(*findings) {}

  Result<Record> Parse() {
    HAPTOMETER_TRY(CheckLines(rest_, name_));
    LeaveOutCutLine();
    HAPTOMETER_TRY(ReadFileHeader());
    while (NextLine()) {
      // a key of a segment header ends the segment before it
      HAPTOMETER_TRY(BeginsSegment() ? ReadSegmentHeader() : ReadDataLine());
    }
    HAPTOMETER_TRY(FinishSegment());
    return Complete();
  }

 private:
  [[nodiscard]] std::string Here() const { return fmt::format("{}: line {}", name_, line_number_); }

  std::unexpected<Error> Wrong(const std::string& what) const {
    return CannotAnswer(Here(), what, kRemedy);
  }

  void LeaveOutCutLine() {
    if (!IsLastLineCutOff(rest_)) return;
    findings_.Doubt(FindingKind::kLastLineCutOff, {{"line", 1 + std::ranges::count(rest_, '\n')}});
    rest_ = rest_.substr(0, rest_.rfind('\n') + 1);
  }

  // the next line that is not blank, without its end; tabs at its beginning count
  bool NextLine() {
    while (!rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      line_ = rest_.substr(0, end);
      rest_ = end == std::string_view::npos ? "" : rest_.substr(end + 1);
      ++line_number_;
      if (line_.ends_with('\r')) line_.remove_suffix(1);
      if (!Trimmed(line_).empty()) return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<std::string_view> Cells() const {
    return SplitCells(line_, separator_);
  }

  [[nodiscard]] bool BeginsSegment() const {
    return std::ranges::find(kSegmentKeys, LowerCase(Cells().front())) != kSegmentKeys.end();
  }

  // "key<separator>value<separator>value..." up to the header's end
  Result<void> ReadKeys(Keys* keys) {
    do {
      const auto cells = Cells();
      if (cells.front() == kHeaderEnd) return {};
      // guards against a file without the line that ends the header
      if (keys->size() == kMostHeaderLines) return Wrong("the header has too many lines");
      auto& values = (*keys)[std::string(cells.front())];
      values.assign(cells.begin() + 1, cells.end());
      while (!values.empty() && values.back().empty()) values.pop_back();
    } while (NextLine());
    return Wrong("the header does not end");
  }

  // the value of a key for channel number `channel`, or its only one
  [[nodiscard]] static std::string ValueOf(const Keys& keys, std::string_view key,
                                           std::size_t channel = 0) {
    const auto found = keys.find(key);
    if (found == keys.end() || found->second.empty()) return "";
    return channel < found->second.size() ? found->second[channel] : found->second.front();
  }

  Result<void> ReadFileHeader() {
    if (!NextLine()) return Wrong("is empty");
    // the header is separated by the separator that it states, so this is found first
    separator_ =
        line_.find(',') != std::string_view::npos && line_.find('\t') == line_.npos ? ',' : '\t';
    if (separator_ == '\t' && rest_.substr(0, rest_.find('\n')).find('\t') == rest_.npos) {
      const std::string_view second = rest_.substr(0, rest_.find('\n'));
      if (second.find(',') != std::string_view::npos) separator_ = ',';
    }
    HAPTOMETER_TRY(ReadKeys(&file_keys_));
    const std::string decimal = ValueOf(file_keys_, "Decimal_Separator");
    // without the key both decimal signs are accepted, unless commas separate cells
    decimal_comma_ = decimal.empty() ? separator_ != ',' : decimal == ",";
    const std::string x_columns = LowerCase(ValueOf(file_keys_, "X_Columns"));
    if (x_columns == "no") x_columns_ = XColumns::kNone;
    if (x_columns == "multi") x_columns_ = XColumns::kMulti;
    // the keys of the file header are kept as metadata fields lvm.KEY
    for (const auto& [key, values] : file_keys_) {
      if (key == kMagic || values.empty()) continue;
      record_.metadata.fields["lvm." + key] = values.front();
    }
    record_.metadata.source = "imported";
    return {};
  }

  Result<void> ReadSegmentHeader() {
    HAPTOMETER_TRY(FinishSegment());
    segment_ = {};
    segment_.rows.first_row = record_.rows;
    is_in_data_ = false;
    HAPTOMETER_TRY(ReadKeys(&segment_.keys));
    // a spectrum has frequencies as X
    const std::string dimension = ValueOf(segment_.keys, "X_Dimension");
    if (!dimension.empty() && LowerCase(dimension) != "time") {
      return CannotAnswer(Here(), fmt::format("its X is not a time: X_Dimension is {}", dimension),
                          "save the signal over time, not its spectrum");
    }
    return {};
  }

  // the line of names, or a row
  Result<void> ReadDataLine() {
    const auto cells = Cells();
    if (cells.front() == kHeaderEnd) return {};
    if (!is_in_data_ && LowerCase(cells.front()) == "x_value") return ReadNames(cells);
    if (std::ranges::all_of(cells, &std::string_view::empty)) return {};
    // a special block is in the format of its writer
    if (LowerCase(cells.front()) == "***start_special***") {
      while (NextLine() && LowerCase(Cells().front()) != "***end_special***") {
      }
      return {};
    }
    if (!is_in_data_) {
      if (cells.front().starts_with("***")) return {};
      return Wrong("stands where a line of names (X_Value ...) should");
    }
    return ReadRow(cells);
  }

  Result<void> ReadNames(const std::vector<std::string_view>& cells) {
    is_in_data_ = true;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const std::string lower = LowerCase(cells[i]);
      // with one X for each channel X_Value is repeated; Comment is the last column
      if (lower == "x_value") continue;
      if (lower == "comment") break;
      segment_.names.emplace_back(cells[i]);
    }
    // separators at the end are no channels; one without a name keeps its place
    const bool has_comments = LowerCase(cells.back()) == "comment";
    while (!has_comments && !segment_.names.empty() && segment_.names.back().empty()) {
      segment_.names.pop_back();
    }
    for (std::size_t c = 0; c < segment_.names.size(); ++c) {
      if (segment_.names[c].empty()) segment_.names[c] = fmt::format("channel_{}", c + 1);
    }
    if (segment_.names.empty() || segment_.names.size() > 1024) {
      return Wrong("names no channel, or too many");
    }
    if (columns_.empty()) return SetChannels();
    // later segments continue the channels of the first
    if (segment_.names.size() != columns_.size()) {
      return Wrong(fmt::format("begins a segment of {} channels where the first has {}",
                               segment_.names.size(), columns_.size()));
    }
    return {};
  }

  // the channels by the first segment's header and by the options
  Result<void> SetChannels() {
    for (std::size_t c = 0; c < segment_.names.size(); ++c) {
      CsvColumn column{.name = segment_.names[c], .printed = segment_.names[c]};
      // Y_Unit_Label holds one unit for each channel
      const auto units = segment_.keys.find("Y_Unit_Label");
      if (units != segment_.keys.end() && c < units->second.size()) {
        column.unit = units->second[c];
        SetPrintedUnit(units->second[c], &column);
      }
      columns_.push_back(std::move(column));
    }
    // names of the user replace those of the file before numbers and scales are given
    HAPTOMETER_TRY(TakeToldColumns());
    NumberChannels(&columns_);
    HAPTOMETER_TRY(KeepChannel(options_, name_, &columns_));
    HAPTOMETER_TRY(ApplyScales(options_, &columns_));
    for (const CsvColumn& column : columns_) {
      if (column.kind != CsvColumnKind::kValue) continue;
      record_.channels.push_back({.name = column.name, .role = column.role, .unit = column.unit});
    }
    if (record_.channels.empty()) return CannotAnswer(name_, "no column is left", "say <columns>");
    return {};
  }

  // names for the channels, or for X and the channels
  Result<void> TakeToldColumns() {
    const std::size_t told = options_.columns.size();
    if (told == 0) return {};
    const bool has_x = told == columns_.size() + 1;
    if (!has_x && told != columns_.size()) {
      return Usage(
          "<columns>",
          fmt::format("names {} columns where {} has {} channels{}", told, name_, columns_.size(),
                      x_columns_ == XColumns::kNone ? "" : " beside X_Value"),
          "name each from the left, - for one to leave out");
    }
    for (std::size_t i = 0; i < told; ++i) {
      HAPTOMETER_LET(auto column, ReadToldColumn(options_.columns[i], options_));
      // the first of channels + 1 names is for X_Value, which must be a time or omitted
      const bool is_x = has_x && i == 0;
      const bool is_left_out = column.kind == CsvColumnKind::kLeftOut;
      if (is_x ? !is_left_out && column.kind != CsvColumnKind::kTime
               : !is_left_out && column.kind != CsvColumnKind::kValue) {
        return Usage("<columns>",
                     fmt::format("'{}' stands for {}", options_.columns[i],
                                 is_x ? "X_Value, which is the time" : "a channel"),
                     "name X_Value time_s (or -), then the channels");
      }
      if (is_x) {
        x_is_read_ = !is_left_out;
        x_factor_ = column.factor;
      } else {
        CsvColumn& stated = columns_[i - (has_x ? 1 : 0)];
        KeepStatedUnit(stated, &column);
        stated = std::move(column);
      }
    }
    return {};
  }

  [[nodiscard]] std::optional<double> Number(std::string_view cell) const {
    return decimal_comma_ ? ReadNumberWithComma(cell) : ReadNumber(cell);
  }

  Result<void> ReadRow(const std::vector<std::string_view>& cells) {
    const std::size_t channels = columns_.size();
    const bool is_multi = x_columns_ == XColumns::kMulti;
    // without X its column is mostly there and empty
    const bool has_x_cell =
        x_columns_ != XColumns::kNone || cells.size() > channels || cells.front().empty();
    // a row is X, Y, Y, ... or, with one X for each channel, X, Y, X, Y, ...
    const std::size_t first = has_x_cell ? 1 : 0;
    const std::size_t needed = is_multi ? 2 * channels : first + channels;
    if (cells.size() < needed) {
      return Wrong(fmt::format("has {} cells where {} are needed", cells.size(), needed));
    }
    if (segment_.rows.rows == 0) segment_.rows.line = line_number_;
    if (x_columns_ != XColumns::kNone && x_is_read_) {
      HAPTOMETER_TRY(TakeX(cells, is_multi ? channels : 1));
    }
    // number of the channel among those that are read
    std::size_t number = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      if (columns_[c].kind != CsvColumnKind::kValue) continue;
      const std::string_view cell = cells[is_multi ? 2 * c + 1 : first + c];
      HAPTOMETER_TRY(TakeValue(cell, columns_[c], &record_.channels[number++]));
    }
    ++segment_.rows.rows;
    ++record_.rows;
    // a cell behind the last channel is the row's comment
    if (cells.size() > needed && !cells[needed].empty()) {
      comments_[record_.rows - 1] = cells[needed];
    }
    return {};
  }

  // the row's X; several X columns must agree
  Result<void> TakeX(const std::vector<std::string_view>& cells, std::size_t columns) {
    const auto x = Number(cells[0]);
    if (!x || !std::isfinite(*x * x_factor_)) {
      return Wrong(fmt::format("'{}' is not an X value", cells[0]));
    }
    for (std::size_t i = 1; i < columns; ++i) {
      const auto other = Number(cells[2 * i]);
      if (!other || *other != *x) {
        return CannotAnswer(Here(),
                            fmt::format("its channels have X values of their own ({} and {})",
                                        cells[0], cells[2 * i]),
                            "write channels of one clock into one file");
      }
    }
    const double time_s = *x * x_factor_;
    PrintedTimes& times = segment_.rows.times;
    // a decreasing time is an error; of repeated ones the first line is kept for a message
    if (!times.times_s().empty() && time_s <= times.times_s().back()) {
      if (time_s < times.times_s().back()) {
        return Wrong(fmt::format("X value {} does not grow", cells[0]));
      }
      if (segment_.rows.repeat_line == 0) segment_.rows.repeat_line = line_number_;
    }
    times.Add(cells[0], time_s, x_factor_);
    return {};
  }

  // the value of one cell in SI units; an empty cell is an invalid sample, no error
  Result<void> TakeValue(std::string_view cell, const CsvColumn& column, Channel* channel) {
    std::optional<double> value = kNan;
    if (!cell.empty()) value = Number(cell);
    if (!value) return Wrong(fmt::format("'{}' is not a number", cell));
    const bool is_value = std::isfinite(*value * column.factor);
    channel->values.push_back(is_value ? *value * column.factor : kNan);
    channel->statuses.push_back(is_value ? SampleStatus::kOk : SampleStatus::kInvalid);
    return {};
  }

  // X0, Delta_X and Samples of one channel; nothing where there is no clock
  struct ChannelClock {
    double start_s = 0;
    double interval_s = 0;
    std::optional<double> samples{};
  };
  [[nodiscard]] std::optional<ChannelClock> ClockOf(std::size_t channel) const {
    ChannelClock clock;
    clock.start_s = Number(ValueOf(segment_.keys, "X0", channel)).value_or(0);
    clock.interval_s = Number(ValueOf(segment_.keys, "Delta_X", channel)).value_or(0);
    clock.samples = Number(ValueOf(segment_.keys, "Samples", channel));
    const bool is_sound = IsSampleInterval(clock.interval_s) && std::isfinite(clock.start_s);
    // a single sample has no interval, regardless of Delta_X
    if (!is_sound || (clock.samples && *clock.samples <= 1)) return std::nullopt;
    return clock;
  }

  // the clock that the channels that are read have in common
  Result<std::optional<ChannelClock>> CommonClock() const {
    std::optional<ChannelClock> common;
    std::size_t first = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const auto clock = ClockOf(c);
      if (columns_[c].kind != CsvColumnKind::kValue || !clock) continue;
      if (!common) {
        common = clock;
        first = c;
        continue;
      }
      // channels that begin within half an interval of each other share their rows' times
      const bool is_late = std::abs(clock->start_s - common->start_s) > 0.5 * common->interval_s;
      if (AreEqual(clock->interval_s, common->interval_s) && !is_late) continue;
      return CannotAnswer(
          name_,
          fmt::format(
              "its channels have clocks of their own: '{}' begins at {:.6g} s with a sample "
              "every {:.6g} s (Delta_X), '{}' at {:.6g} s with one every {:.6g} s",
              segment_.names[first], common->start_s, common->interval_s, segment_.names[c],
              clock->start_s, clock->interval_s),
          "read one of them: <channel>");
    }
    return common;
  }

  // the segment's rows get their times
  Result<void> FinishSegment() {
    if (segment_.rows.rows == 0) return {};
    ++segments_;
    // rows of segments that the user did not select are discarded
    if (options_.segment && *options_.segment != segments_) {
      Truncate(0);
      return {};
    }
    CountStatedRows();
    HAPTOMETER_LET(const auto clock, CommonClock());
    TimeWords words;
    if (clock) words.clock = StatedClock{clock->interval_s, clock->start_s, "Delta_X"};
    // X values are those of channel 1: valid for the others only at the same interval
    const auto first = ClockOf(0);
    const bool x_is_ours = x_columns_ == XColumns::kMulti || !clock || !first ||
                           AreEqual(first->interval_s, clock->interval_s);
    // rows beyond Samples hold no values of the channels that are read
    if (!x_is_ours && clock->samples && *clock->samples < static_cast<double>(segment_.rows.rows)) {
      Truncate(static_cast<std::size_t>(*clock->samples));
    }
    Record part;
    part.rows = segment_.rows.rows;
    // without usable X the times are start + i * interval of the stated clock or rate
    if (x_columns_ == XColumns::kNone || !x_is_read_ || !x_is_ours) {
      if (!words.clock && !options_.rate_hz) {
        return Wrong("its segment has neither X values nor a Delta_X above 0");
      }
      part.stretches = {UniformTimes(words, options_, part.rows, &findings_)};
      return Append(part);
    }
    MarkRowsWrittenTwice(record_.channels, &segment_.rows);
    HAPTOMETER_LET(auto read, ReadSegmentTimes(name_, words, options_, std::move(segment_.rows),
                                               &left_out_, &findings_));
    return Append(read);
  }

  // compares the segment's rows with its Samples, of which several writes below one header make a
  // multiple
  void CountStatedRows() {
    double samples = 0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      samples = std::max(samples, Number(ValueOf(segment_.keys, "Samples", c)).value_or(0));
    }
    // counts below 2^53 are exact as doubles
    const std::size_t rows = segment_.rows.rows;
    const bool is_stated = samples >= 1 && samples < 1e15 && samples == std::floor(samples);
    const std::size_t stated = is_stated ? static_cast<std::size_t>(samples) : rows;
    const bool differs = rows % stated != 0;
    rows_differ_ = rows_differ_ || differs;
    stated_rows_ += differs ? stated : rows;
    counted_rows_ += rows;
  }

  // keeps the first `rows` rows of the segment
  void Truncate(std::size_t rows) {
    const std::size_t kept = segment_.rows.first_row + rows;
    for (Channel& channel : record_.channels) {
      channel.values.resize(kept);
      channel.statuses.resize(kept);
    }
    record_.rows = kept;
    segment_.rows.rows = rows;
    comments_.erase(comments_.lower_bound(kept), comments_.end());
  }

  // adds a segment's times; where X begins again, behind the pause that the wall clock gives
  Result<void> Append(const Record& part) {
    const std::string time = ValueOf(segment_.keys, "Time");
    const auto clock_s = ReadClock(time.empty() ? ValueOf(file_keys_, "Time") : time);
    const double start_s = part.stretches.front().start_s;
    double shift_s = 0;
    // the first segment is the reference of the wall clock
    if (!has_first_) {
      has_first_ = true;
      first_clock_s_ = clock_s;
      first_date_ = ValueOf(segment_.keys, "Date");
      first_start_s_ = start_s;
    } else if (!times_.IsBehind(start_s) && clock_s && first_clock_s_ && !time.empty() &&
               ValueOf(segment_.keys, "Date") == first_date_) {
      // shift in s: wall-clock time since the first segment, less the difference of their X
      shift_s = *clock_s - *first_clock_s_ + first_start_s_ - start_s;
    }
    if (times_.Append(part, shift_s)) return {};
    return Wrong("ends a segment whose X begins again and whose Date and Time do not state when");
  }

  Result<Record> Complete() {
    if (options_.segment && *options_.segment > segments_) {
      return CannotAnswer(name_,
                          fmt::format("has {} segment{}", segments_, segments_ == 1 ? "" : "s"),
                          "give <segment> with one of them, counted from 1");
    }
    if (options_.format) findings_.Note(FindingKind::kFormatNotUsed);
    if (rows_differ_) {
      findings_.Doubt(FindingKind::kStatedRowsDiffer,
                      {{"stated_rows", stated_rows_}, {"rows", counted_rows_}});
    }
    if (record_.rows < 2) {
      return CannotAnswer(name_,
                          fmt::format("holds {} row{}", record_.rows, record_.rows == 1 ? "" : "s"),
                          "a measurement needs at least two");
    }
    if (options_.rate_hz) record_.metadata.nominal_rate_hz = options_.rate_hz;
    // rows are excluded last, because their numbers are those of the whole record
    std::move(times_).Complete(&record_);
    HAPTOMETER_TRY(CheckRate(name_, options_, record_));
    LeaveOutRows(left_out_, &record_);
    for (const auto& [row, comment] : comments_) {
      if (std::ranges::binary_search(left_out_, row)) continue;
      const auto before = std::ranges::lower_bound(left_out_, row) - left_out_.begin();
      record_.metadata.notes.push_back(
          fmt::format("row {}: {}", row - static_cast<std::size_t>(before), comment));
    }
    return std::move(record_);
  }

  std::string_view rest_;
  const std::string& name_;
  const ImportOptions& options_;
  Findings& findings_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  char separator_ = '\t';
  bool decimal_comma_ = false;
  XColumns x_columns_ = XColumns::kOne;
  Keys file_keys_;
  Segment segment_;
  bool is_in_data_ = false;
  std::vector<CsvColumn> columns_;  // of the channels
  bool x_is_read_ = true;
  double x_factor_ = 1;  // seconds
  std::size_t segments_ = 0;
  std::size_t stated_rows_ = 0;  // of the segments that are read, by their Samples
  std::size_t counted_rows_ = 0;
  bool rows_differ_ = false;                     // in one of them
  std::vector<std::size_t> left_out_;            // rows of the record
  std::map<std::size_t, std::string> comments_;  // of rows of the record
  std::optional<double> first_clock_s_;
  std::string first_date_;
  double first_start_s_ = 0;
  bool has_first_ = false;
  SegmentedTimes times_;
  Record record_;
};

}  // namespace

bool IsLvm(std::string_view text) { return text.starts_with(kMagic); }

Result<Record> ParseLvm(std::string_view text, const std::string& name,
                        const ImportOptions& options, Findings* findings) {
  Findings ignored;
  return Parser(text, name, options, findings != nullptr ? findings : &ignored).Parse();
}

}  // namespace haptometer::trial
