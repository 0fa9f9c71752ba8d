#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "trial/export/export.h"
#include "trial/import/table/csv_header.h"

namespace haptometer::trial {
namespace {

// which status columns are needed
enum class StatusColumns : std::uint8_t { kNone, kOne, kOneAChannel };

// no column if all samples are ok, one if all channels have the same statuses, else one each
StatusColumns StatusColumnsOf(const Record& record) {
  const std::vector<SampleStatus>& first = record.channels.front().statuses;
  const bool are_alike = std::ranges::all_of(
      record.channels, [&](const Channel& channel) { return channel.statuses == first; });
  if (!are_alike) return StatusColumns::kOneAChannel;
  const bool are_ok =
      std::ranges::all_of(first, [](SampleStatus status) { return status == SampleStatus::kOk; });
  return are_ok ? StatusColumns::kNone : StatusColumns::kOne;
}

// what the column names do not state of a channel
std::string ChannelLines(const Channel& channel, std::size_t number, bool has_own_unit) {
  auto line = [&](const char* key, std::string_view value) {
    return CsvCommentLine(fmt::format("channel.{}.{}", number, key), value);
  };
  std::string lines = line("name", channel.name);
  if (has_own_unit) lines += line("unit", channel.unit);
  if (std::isfinite(channel.range_min)) {
    lines += line("range_min", fmt::format("{}", channel.range_min));
  }
  if (std::isfinite(channel.range_max)) {
    lines += line("range_max", fmt::format("{}", channel.range_max));
  }
  if (channel.resolution != 0) lines += line("resolution", fmt::format("{}", channel.resolution));
  return lines;
}

// where the times come from, as the value of the key "times"
std::string_view TimesWord(const Record& record) {
  if (record.raw_times_s.empty()) return "grid";
  if (record.times_are_known) return "known";
  return record.timing == Timing::kPolled ? "polled" : "arrived";
}

// metadata, time base, channels, and the line of column names
std::string Head(const Record& record, const std::vector<std::string>& names,
                 StatusColumns status_columns) {
  std::string head = CsvMetadataLines(record.metadata);
  head += CsvCommentLine("times", TimesWord(record));
  for (const Stretch& stretch : record.stretches) {
    head += CsvCommentLine(
        "stretch", fmt::format("{} {} {} {} {}", stretch.first_row, stretch.rows, stretch.start_s,
                               stretch.rate_hz, stretch.time_uncertainty_s));
  }
  std::string columns = HasArrivalTimes(record) ? "time_s,arrival_s" : "time_s";
  for (std::size_t c = 0; c < names.size(); ++c) {
    // the names of these columns have no unit
    const bool has_own_unit = record.channels[c].role == ChannelRole::kOther ||
                              names[c].starts_with("channel_") || names[c].starts_with("trig");
    head += ChannelLines(record.channels[c], c + 1, has_own_unit);
    columns += "," + names[c];
  }
  if (status_columns == StatusColumns::kOne) columns += ",status";
  if (status_columns == StatusColumns::kOneAChannel) {
    for (std::size_t c = 0; c < record.channels.size(); ++c) {
      columns += fmt::format(",status_{}", c + 1);
    }
  }
  return head + columns + "\n";
}

// one line: times, values, statuses; numbers with the fewest digits that restore the double
void AppendRow(const Record& record, std::size_t row, StatusColumns status_columns,
               std::string* text) {
  auto out = std::back_inserter(*text);
  fmt::format_to(out, "{}", ExportedTimeOf(record, row));
  if (HasArrivalTimes(record)) fmt::format_to(out, ",{}", record.raw_times_s[row]);
  for (const Channel& channel : record.channels) {
    // no measurement: an empty cell, for which the status gives the reason
    if (IsMeasurement(channel.statuses[row]) && std::isfinite(channel.values[row])) {
      fmt::format_to(out, ",{}", channel.values[row]);
    } else {
      *text += ',';
    }
  }
  for (const Channel& channel : record.channels) {
    if (status_columns == StatusColumns::kNone) break;
    *text += ',';
    *text += Name(channel.statuses[row]);
    if (status_columns == StatusColumns::kOne) break;
  }
  *text += '\n';
}

}  // namespace

// pieces of 64 KiB or more, so that a long record is not in memory as text
Result<void> WriteInPieces(std::string bytes, std::size_t rows,
                           const std::function<void(std::size_t row, std::string* bytes)>& append,
                           const PieceSink& sink) {
  constexpr std::size_t kPieceBytes = 1U << 16;
  for (std::size_t row = 0; row < rows; ++row) {
    append(row, &bytes);
    if (bytes.size() < kPieceBytes) continue;
    HAPTOMETER_TRY(sink(bytes));
    bytes.clear();
  }
  return sink(bytes);
}

Result<void> WriteCsv(const Record& record, const PieceSink& sink, std::vector<std::string> names) {
  if (record.channels.empty()) return CannotAnswer("", "the record holds no channel");
  if (names.empty()) names = CsvColumnNames(record.channels);
  const StatusColumns status_columns = StatusColumnsOf(record);
  return WriteInPieces(
      Head(record, names, status_columns), record.rows,
      [&](std::size_t row, std::string* text) { AppendRow(record, row, status_columns, text); },
      sink);
}

}  // namespace haptometer::trial
