#include "trial/import/lvm.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "trial/import/printed_number.h"
#include "trial/import/printed_times.h"
#include "trial/import/printed_unit.h"
#include "trial/import/segmented_times.h"
#include "trial/import/table_cells.h"

namespace haptometer::trial {
namespace {

constexpr std::string_view kMagic = "LabVIEW Measurement";
constexpr std::string_view kHeaderEnd = "***End_of_Header***";
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kRemedy = "write the file again, or export it as a CSV with time_s";

enum class XColumns : std::uint8_t { kNone, kOne, kMulti };

// one segment's header and rows
struct Segment {
  std::map<std::string, std::vector<std::string>, std::less<>> keys{};
  std::vector<std::string> names{};  // of the channels
  PrintedTimes times{};
  std::size_t rows = 0;
};

class Parser {
 public:
  Parser(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  Result<Record> Parse() {
    if (auto bounded = CheckLines(rest_, name_); !bounded) return std::unexpected(bounded.error());
    if (auto done = ReadFileHeader(); !done) return std::unexpected(done.error());
    while (NextLine()) {
      const bool begins_segment = LowerCase(Cells().front()) == "channels";
      const auto done = begins_segment ? ReadSegmentHeader() : ReadDataLine();
      if (!done) return std::unexpected(done.error());
    }
    if (auto done = FinishSegment(); !done) return std::unexpected(done.error());
    return Complete();
  }

 private:
  [[nodiscard]] std::string Here() const { return fmt::format("{}: line {}", name_, line_number_); }

  std::unexpected<Error> Wrong(const std::string& what) const {
    return CannotAnswer(Here(), what, kRemedy);
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

  // "key<separator>value<separator>value..." up to the header's end
  Result<void> ReadKeys(std::map<std::string, std::vector<std::string>, std::less<>>* keys) {
    do {
      const auto cells = Cells();
      if (cells.front() == kHeaderEnd) return {};
      if (keys->size() == kMostHeaderLines) return Wrong("the header has too many lines");
      auto& values = (*keys)[std::string(cells.front())];
      values.assign(cells.begin() + 1, cells.end());
      while (!values.empty() && values.back().empty()) values.pop_back();
    } while (NextLine());
    return Wrong("the header does not end");
  }

  [[nodiscard]] static std::string First(
      const std::map<std::string, std::vector<std::string>, std::less<>>& keys,
      std::string_view key) {
    const auto found = keys.find(key);
    return found == keys.end() || found->second.empty() ? "" : found->second.front();
  }

  Result<void> ReadFileHeader() {
    if (!NextLine()) return Wrong("is empty");
    // the separator is told by the header, which is separated by it
    separator_ =
        line_.find(',') != std::string_view::npos && line_.find('\t') == line_.npos ? ',' : '\t';
    if (separator_ == '\t' && rest_.substr(0, rest_.find('\n')).find('\t') == rest_.npos) {
      const std::string_view second = rest_.substr(0, rest_.find('\n'));
      if (second.find(',') != std::string_view::npos) separator_ = ',';
    }
    if (auto done = ReadKeys(&file_keys_); !done) return done;
    const std::string decimal = First(file_keys_, "Decimal_Separator");
    decimal_comma_ = decimal.empty() ? separator_ != ',' : decimal == ",";
    const std::string x_columns = LowerCase(First(file_keys_, "X_Columns"));
    if (x_columns == "no") x_columns_ = XColumns::kNone;
    if (x_columns == "multi") x_columns_ = XColumns::kMulti;
    for (const auto& [key, values] : file_keys_) {
      if (key == kMagic || values.empty()) continue;
      record_.metadata.fields["lvm." + key] = values.front();
    }
    record_.metadata.source = "imported";
    return {};
  }

  Result<void> ReadSegmentHeader() {
    if (auto done = FinishSegment(); !done) return done;
    segment_ = {};
    is_in_data_ = false;
    if (auto done = ReadKeys(&segment_.keys); !done) return done;
    return {};
  }

  // the line of names, or a row
  Result<void> ReadDataLine() {
    const auto cells = Cells();
    if (cells.front() == kHeaderEnd) return {};
    if (!is_in_data_ && LowerCase(cells.front()) == "x_value") return ReadNames(cells);
    if (!is_in_data_) {
      // blank lines and special blocks between segments
      if (std::ranges::all_of(cells, &std::string_view::empty)) return {};
      if (cells.front().starts_with("***")) return {};
      return Wrong("stands where a line of names (X_Value ...) should");
    }
    return ReadRow(cells);
  }

  Result<void> ReadNames(const std::vector<std::string_view>& cells) {
    is_in_data_ = true;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const std::string lower = LowerCase(cells[i]);
      if (lower == "x_value") continue;
      if (lower == "comment") break;
      if (!cells[i].empty()) segment_.names.emplace_back(cells[i]);
    }
    if (segment_.names.empty() || segment_.names.size() > 1024) {
      return Wrong("names no channel, or too many");
    }
    if (record_.channels.empty()) {
      SetChannels();
    } else if (segment_.names.size() != record_.channels.size()) {
      return Wrong(fmt::format("begins a segment of {} channels where the first has {}",
                               segment_.names.size(), record_.channels.size()));
    }
    return {};
  }

  void SetChannels() {
    const auto units = segment_.keys.find("Y_Unit_Label");
    for (std::size_t c = 0; c < segment_.names.size(); ++c) {
      Channel channel;
      channel.name = segment_.names[c];
      double factor = 1;
      if (units != segment_.keys.end() && c < units->second.size()) {
        channel.unit = units->second[c];
        if (const auto unit = FindUnit(channel.unit)) {
          channel.unit = unit->si_unit;
          channel.role = RoleOfUnit(unit->si_unit);
          factor = unit->factor;
        }
      }
      factors_.push_back(factor);
      record_.channels.push_back(std::move(channel));
    }
  }

  [[nodiscard]] std::optional<double> Number(std::string_view cell) const {
    return decimal_comma_ ? ReadNumberWithComma(cell) : ReadNumber(cell);
  }

  Result<void> ReadRow(const std::vector<std::string_view>& cells) {
    const std::size_t channels = record_.channels.size();
    const bool is_multi = x_columns_ == XColumns::kMulti;
    // without X its column is mostly there and empty
    const bool has_x_cell =
        x_columns_ != XColumns::kNone || cells.size() > channels || cells.front().empty();
    const std::size_t first = has_x_cell ? 1 : 0;
    const std::size_t needed = is_multi ? 2 * channels : first + channels;
    if (cells.size() < needed) {
      return Wrong(fmt::format("has {} cells where {} are needed", cells.size(), needed));
    }
    if (x_columns_ != XColumns::kNone) {
      if (auto done = TakeX(cells, is_multi ? channels : 1); !done) return done;
    }
    for (std::size_t c = 0; c < channels; ++c) {
      const std::string_view cell = cells[is_multi ? 2 * c + 1 : first + c];
      if (auto done = TakeValue(cell, c); !done) return done;
    }
    ++segment_.rows;
    ++record_.rows;
    if (cells.size() > needed && !cells[needed].empty()) {
      record_.metadata.notes.push_back(fmt::format("row {}: {}", record_.rows - 1, cells[needed]));
    }
    return {};
  }

  // the row's X; of several columns all must say the same
  Result<void> TakeX(const std::vector<std::string_view>& cells, std::size_t columns) {
    const auto x = Number(cells[0]);
    if (!x || !std::isfinite(*x)) return Wrong(fmt::format("'{}' is no X value", cells[0]));
    for (std::size_t i = 1; i < columns; ++i) {
      const auto other = Number(cells[2 * i]);
      if (!other || *other != *x) {
        return CannotAnswer(Here(),
                            fmt::format("its channels have X values of their own ({} and {})",
                                        cells[0], cells[2 * i]),
                            "write channels of one clock into one file");
      }
    }
    const auto& times_s = segment_.times.times_s();
    if (!times_s.empty() && *x <= times_s.back()) {
      return Wrong(fmt::format("X value {} does not grow", cells[0]));
    }
    segment_.times.Add(cells[0], *x, 1);
    return {};
  }

  Result<void> TakeValue(std::string_view cell, std::size_t channel_number) {
    std::optional<double> value = kNan;
    if (!cell.empty()) value = Number(cell);
    if (!value) return Wrong(fmt::format("'{}' is no number", cell));
    Channel& channel = record_.channels[channel_number];
    const bool is_value = std::isfinite(*value * factors_[channel_number]);
    channel.values.push_back(is_value ? *value * factors_[channel_number] : kNan);
    channel.statuses.push_back(is_value ? SampleStatus::kOk : SampleStatus::kInvalid);
    return {};
  }

  // the segment's rows get their times
  Result<void> FinishSegment() {
    if (segment_.rows == 0) return {};
    Record part;
    part.rows = segment_.rows;
    if (x_columns_ == XColumns::kNone) {
      const auto x0 = Number(First(segment_.keys, "X0")).value_or(0);
      const auto delta = Number(First(segment_.keys, "Delta_X"));
      if (!delta || !(*delta > 0) || !std::isfinite(*delta) || !std::isfinite(x0)) {
        return Wrong("its segment has neither X values nor a Delta_X above 0");
      }
      part.stretches = {{.rows = part.rows, .start_s = x0, .rate_hz = 1 / *delta}};
    } else if (part.rows == 1) {
      return Wrong("ends a segment of one row, which has no rate");
    } else {
      // X values grow, but perhaps by less than a rate can say
      if (!std::move(segment_.times).Complete(Timing::kUniform, {}, &part)) {
        return Wrong("ends a segment whose X values lie too close to have a rate");
      }
    }
    return Append(part);
  }

  Result<void> Append(const Record& part) {
    const std::string time = First(segment_.keys, "Time");
    const auto clock_s = ReadClock(time.empty() ? First(file_keys_, "Time") : time);
    const double start_s = part.stretches.front().start_s;
    double shift_s = 0;
    if (!has_first_) {
      has_first_ = true;
      first_clock_s_ = clock_s;
      first_date_ = First(segment_.keys, "Date");
      first_start_s_ = start_s;
    } else if (!times_.IsBehind(start_s) && clock_s && first_clock_s_ && !time.empty() &&
               First(segment_.keys, "Date") == first_date_) {
      // X begins again: only the clock on the wall tells the pause
      shift_s = *clock_s - *first_clock_s_ + first_start_s_ - start_s;
    }
    if (times_.Append(part, shift_s)) return {};
    return Wrong("ends a segment whose X begins again and whose Date and Time do not tell when");
  }

  Result<Record> Complete() {
    if (record_.rows < 2) {
      return CannotAnswer(name_,
                          fmt::format("holds {} row{}", record_.rows, record_.rows == 1 ? "" : "s"),
                          "a measurement needs at least two");
    }
    std::move(times_).Complete(&record_);
    return std::move(record_);
  }

  std::string_view rest_;
  std::string name_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  char separator_ = '\t';
  bool decimal_comma_ = false;
  XColumns x_columns_ = XColumns::kOne;
  std::map<std::string, std::vector<std::string>, std::less<>> file_keys_;
  Segment segment_;
  bool is_in_data_ = false;
  std::vector<double> factors_;
  std::optional<double> first_clock_s_;
  std::string first_date_;
  double first_start_s_ = 0;
  bool has_first_ = false;
  SegmentedTimes times_;
  Record record_;
};

}  // namespace

bool IsLvm(std::string_view text) { return text.starts_with(kMagic); }

Result<Record> ParseLvm(std::string_view text, const std::string& name) {
  return Parser(text, name).Parse();
}

}  // namespace haptometer::trial
