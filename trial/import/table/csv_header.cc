#include "trial/import/table/csv_header.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "base/text.h"
#include "trial/trial_format.h"

namespace haptometer::trial {
namespace {

// the quantities whose names need a unit
struct Quantity {
  std::string_view name;
  ChannelRole role;
  std::string_view si_unit;
  std::string_view examples;
};

// name, role, SI unit and examples for messages
constexpr std::array<Quantity, 4> kQuantities{
    {{"time", ChannelRole::kOther, "s", "time_s, time_ms or time_us"},
     {"displacement", ChannelRole::kDisplacement, "m",
      "displacement_m, displacement_mm or displacement_um"},
     {"voltage", ChannelRole::kVoltage, "V", "voltage_v or voltage_mv"},
     {"current", ChannelRole::kCurrent, "A", "current_a or current_ma"}}};

constexpr const char* kHeaderRemedy =
    "put a line such as time_s,displacement_m above the numbers (time_s,voltage_v for a coil)";

// whether `name` is `word` or begins with `word` and an underscore
bool BeginsWithWord(std::string_view name, std::string_view word) {
  return name.starts_with(word) && (name.size() == word.size() || name[word.size()] == '_');
}

// the channel number behind "status_"
std::optional<std::size_t> NumberAfter(std::string_view name, std::string_view prefix) {
  if (!name.starts_with(prefix)) return std::nullopt;
  // a whole number of at least 1 up to the end of the name
  std::size_t number = 0;
  const char* end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data() + prefix.size(), end, number);
  if (parsed.ec != std::errc() || parsed.ptr != end || number == 0) return std::nullopt;
  return number;
}

// the name of the `number`th channel; `ordinal` counts the channels of its role from 1
std::string ColumnName(const Channel& channel, std::size_t number, std::size_t ordinal) {
  // "displacement_m", "displacement_2_m", "trigger", or "channel_3" where the name has no unit
  const std::string count = ordinal > 1 ? fmt::format("_{}", ordinal) : "";
  if (channel.role == ChannelRole::kTrigger) return "trigger" + count;
  // only a channel in the SI unit of its role has the name of its quantity
  const auto quantity = std::ranges::find_if(kQuantities, [&](const Quantity& q) {
    return channel.role != ChannelRole::kOther && q.role == channel.role &&
           q.si_unit == channel.unit;
  });
  if (quantity == kQuantities.end()) return fmt::format("channel_{}", number);
  return fmt::format("{}{}_{}", quantity->name, count, LowerCase(quantity->si_unit));
}

}  // namespace

void SetUnit(const PrintedUnit& unit, CsvColumn* column) {
  column->role = RoleOfUnit(unit.si_unit);
  column->unit = unit.si_unit;
  column->factor = unit.factor;
}

void SetPrintedUnit(std::string_view printed, CsvColumn* column) {
  if (const auto unit = FindUnit(printed)) SetUnit(*unit, column);
}

Result<CsvColumn> ReadCsvColumn(std::string_view cell, const std::string& where) {
  // "-" omits a column
  if (cell == "-") return CsvColumn{.kind = CsvColumnKind::kLeftOut};
  const std::string name = LowerCase(cell);
  if (name == "status") return CsvColumn{.kind = CsvColumnKind::kStatus, .name = name, .unit = ""};
  if (const auto channel = NumberAfter(name, "status_")) {
    return CsvColumn{.kind = CsvColumnKind::kStatus, .name = name, .unit = "", .channel = *channel};
  }
  if (name == "arrival_s") {
    return CsvColumn{.kind = CsvColumnKind::kArrival, .name = "arrival", .unit = "s"};
  }
  if (BeginsWithWord(name, "trigger")) {
    return CsvColumn{
        .role = ChannelRole::kTrigger, .name = name, .unit = "", .printed = std::string(cell)};
  }
  // the quantity is before the first underscore, the unit behind the last one
  const auto quantity = std::ranges::find_if(
      kQuantities, [&](const Quantity& q) { return BeginsWithWord(name, q.name); });
  // a name without a known quantity is a channel in unknown units
  if (quantity == kQuantities.end()) {
    return CsvColumn{.name = std::string(cell), .unit = "", .printed = std::string(cell)};
  }
  const std::size_t bar = name.rfind('_');
  const std::string_view suffix =
      bar == std::string::npos ? "" : std::string_view(name).substr(bar + 1);
  const auto unit = FindUnit(suffix);
  if (!unit || unit->si_unit != quantity->si_unit) {
    return CannotAnswer(where, fmt::format("column '{}' does not state its unit", cell),
                        fmt::format("name it {}", quantity->examples));
  }
  return CsvColumn{.kind = quantity->name == "time" ? CsvColumnKind::kTime : CsvColumnKind::kValue,
                   .role = quantity->role,
                   .name = name.substr(0, bar),
                   .unit = std::string(unit->si_unit),
                   .factor = unit->factor,
                   .printed = std::string(cell)};
}

// channels count from 1, in the order of the value columns
void NumberChannels(std::vector<CsvColumn>* columns) {
  std::size_t number = 0;
  for (CsvColumn& column : *columns) {
    if (column.kind == CsvColumnKind::kValue) column.channel = ++number;
  }
}

Result<std::vector<CsvColumn>> ReadCsvColumns(const std::vector<std::string_view>& cells,
                                              const std::string& where) {
  std::vector<CsvColumn> columns;
  for (const std::string_view cell : cells) {
    HAPTOMETER_LET(auto column, ReadCsvColumn(cell, where));
    columns.push_back(std::move(column));
  }
  // one time, at most one arrival time, at least one channel
  const auto times = std::ranges::count(columns, CsvColumnKind::kTime, &CsvColumn::kind);
  const auto values = std::ranges::count(columns, CsvColumnKind::kValue, &CsvColumn::kind);
  if (times == 0) {
    return CannotAnswer(where, "no time column is named in its first line", kHeaderRemedy);
  }
  if (times > 1) return CannotAnswer(where, "two columns are named time", "keep one of them");
  if (std::ranges::count(columns, CsvColumnKind::kArrival, &CsvColumn::kind) > 1) {
    return CannotAnswer(where, "two columns are named arrival_s", "keep one of them");
  }
  if (values == 0) {
    return CannotAnswer(where, "no column beside the time holds values", kHeaderRemedy);
  }
  // status columns refer to channels by their numbers
  for (const CsvColumn& column : columns) {
    if (column.channel > static_cast<std::size_t>(values)) {
      return CannotAnswer(
          where, fmt::format("column '{}' is about a channel that is not there", column.name),
          fmt::format("there are {} channels, counted from 1", values));
    }
  }
  NumberChannels(&columns);
  return columns;
}

std::vector<std::string> CsvColumnNames(const std::vector<Channel>& channels) {
  std::vector<std::string> names;
  names.reserve(channels.size());
  std::map<ChannelRole, std::size_t> ordinals;
  for (const Channel& channel : channels) {
    names.push_back(ColumnName(channel, names.size() + 1, ++ordinals[channel.role]));
  }
  return names;
}

namespace {

// the keys of Metadata that hold a number
using NumberMember = std::optional<double> Metadata::*;
constexpr std::array<std::pair<std::string_view, NumberMember>, 4> kNumberKeys{
    {{"sampling_s", &Metadata::sampling_s},
     {"nominal_rate_hz", &Metadata::nominal_rate_hz},
     {"drive_frequency_hz", &Metadata::drive_frequency_hz},
     {"drive_amplitude_v", &Metadata::drive_amplitude_v}}};

constexpr std::string_view kLabelPrefix = "label.";
constexpr std::string_view kChannelPrefix = "channel.";

std::unexpected<Error> NoNumber(const std::string& where, std::string_view key,
                                std::string_view value) {
  return CannotAnswer(where, fmt::format("'{} = {}' is not a number", key, value),
                      "write a plain number in the unit that the key names");
}

// a key whose value is a number; false where it is another key
Result<bool> TakeNumber(std::string_view key, std::string_view value, const std::string& where,
                        Metadata* metadata) {
  const auto number = ReadNumber(value);
  const bool is_number = number && std::isfinite(*number);
  for (const auto& [name, member] : kNumberKeys) {
    if (key != name) continue;
    if (!is_number) return NoNumber(where, key, value);
    metadata->*member = number;
    return true;
  }
  if (key != "tare_m" && key != "averages") return false;
  if (!is_number) return NoNumber(where, key, value);
  if (key == "tare_m") {
    metadata->tare_m = *number;
    return true;
  }
  // averages is a count of raw samples, so a whole number
  if (*number < 1 || *number > 1e9 || *number != std::floor(*number)) {
    return CannotAnswer(
        where, fmt::format("'averages = {}' is no count of readings", value),
        "write a whole number from 1 to 1000000000 (1: the sensor does not average)");
  }
  metadata->averages = static_cast<int>(*number);
  return true;
}

// value of a line "stretch = FIRST_ROW ROWS START_S RATE_HZ UNCERTAINTY_S"
std::optional<Stretch> ReadStretch(std::string_view value) {
  std::vector<double> numbers;
  while (!value.empty()) {
    const std::size_t blank = value.find(' ');
    const auto number = ReadNumber(value.substr(0, blank));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    value = blank == std::string_view::npos ? "" : Trimmed(value.substr(blank));
  }
  // counts below 2^53 are exact as doubles
  constexpr double kMaxRows = 1e15;
  const bool is_sound = numbers.size() == 5 && numbers[0] >= 0 && numbers[0] < kMaxRows &&
                        numbers[1] >= 1 && numbers[1] < kMaxRows && std::isfinite(numbers[2]) &&
                        numbers[3] > 0 && numbers[4] >= 0;
  if (!is_sound) return std::nullopt;
  return Stretch{.first_row = static_cast<std::size_t>(numbers[0]),
                 .rows = static_cast<std::size_t>(numbers[1]),
                 .start_s = numbers[2],
                 .rate_hz = numbers[3],
                 .time_uncertainty_s = numbers[4]};
}

// keys of the time base and of the channels; false where it is another key
bool TakeLayout(std::string_view key, std::string_view value, CsvComments* comments) {
  // grid is the default; known: the readings' own times, on no grid
  if (key == "times") {
    if (value == "arrived") comments->timing = Timing::kArrival;
    if (value == "polled" || value == "known") comments->timing = Timing::kPolled;
    comments->times_are_known = value == "known";
    return true;
  }
  if (key == "stretch") {
    // a line that is damaged is ignored: then the times are fitted again
    if (const auto stretch = ReadStretch(value)) comments->stretches.push_back(*stretch);
    return true;
  }
  if (!key.starts_with(kChannelPrefix)) return false;
  comments->channel_keys[std::string(key.substr(kChannelPrefix.size()))] = value;
  return true;
}

}  // namespace

Result<void> ReadCsvComment(std::string_view line, const std::string& where,
                            CsvComments* comments) {
  // without the signs # and blanks at the beginning
  line.remove_prefix(line.find_first_not_of("# \t") == std::string_view::npos
                         ? line.size()
                         : line.find_first_not_of("# \t"));
  Metadata& metadata = comments->metadata;
  const std::size_t equals = line.find('=');
  // a comment without "=" is a note
  if (equals == std::string_view::npos) {
    if (!Trimmed(line).empty()) metadata.notes.emplace_back(Trimmed(line));
    return {};
  }
  const std::string_view key = Trimmed(line.substr(0, equals));
  const std::string_view value = Trimmed(line.substr(equals + 1));
  // order: texts, numbers, time base and channels, labels; any other key is a field
  for (const auto& [name, member] : kMetadataTexts) {
    if (key != name) continue;
    metadata.*member = value;
    return {};
  }
  HAPTOMETER_LET(const auto taken, TakeNumber(key, value, where, &metadata));
  if (taken || TakeLayout(key, value, comments)) return {};
  if (key == "note") {
    metadata.notes.emplace_back(value);
  } else if (key.starts_with(kLabelPrefix)) {
    metadata.labels[std::string(key.substr(kLabelPrefix.size()))] = value;
  } else {
    metadata.fields[std::string(key)] = value;
  }
  return {};
}

std::string CsvCommentLine(std::string_view key, std::string_view value) {
  // an empty value has no line, as an absent one
  if (value.empty()) return "";
  return Printable(fmt::format("# {} = {}", key, value)) + "\n";
}

std::string CsvMetadataLines(const Metadata& metadata) {
  std::string lines;
  for (const auto& [key, member] : kMetadataTexts) lines += CsvCommentLine(key, metadata.*member);
  // numbers with the fewest digits that restore the double
  for (const auto& [key, member] : kNumberKeys) {
    if (metadata.*member) lines += CsvCommentLine(key, fmt::format("{}", *(metadata.*member)));
  }
  if (metadata.averages) lines += CsvCommentLine("averages", fmt::format("{}", *metadata.averages));
  if (metadata.tare_m != 0) lines += CsvCommentLine("tare_m", fmt::format("{}", metadata.tare_m));
  for (const auto& [key, value] : metadata.labels) {
    lines += CsvCommentLine(std::string(kLabelPrefix) + key, value);
  }
  for (const auto& [key, value] : metadata.fields) lines += CsvCommentLine(key, value);
  for (const std::string& note : metadata.notes) lines += CsvCommentLine("note", note);
  return lines;
}

}  // namespace haptometer::trial
