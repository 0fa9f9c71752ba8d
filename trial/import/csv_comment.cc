#include "trial/import/csv_comment.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <optional>

#include "base/text.h"
#include "trial/import/printed_number.h"
#include "trial/metadata_texts.h"

namespace haptometer::trial {
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
  return CannotAnswer(where, fmt::format("'{} = {}' is no number", key, value),
                      "write a plain number in the unit that the key names");
}

// a key with a numeric place of its own; false where it is another key
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
  if (*number < 1 || *number > 1e9 || *number != std::floor(*number)) {
    return NoNumber(where, key, value);
  }
  metadata->averages = static_cast<int>(*number);
  return true;
}

// FIRST_ROW ROWS START_S RATE_HZ UNCERTAINTY_S
std::optional<Stretch> ReadStretch(std::string_view value) {
  std::vector<double> numbers;
  while (!value.empty()) {
    const std::size_t blank = value.find(' ');
    const auto number = ReadNumber(value.substr(0, blank));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    value = blank == std::string_view::npos ? "" : Trimmed(value.substr(blank));
  }
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

// keys about the time base and the channels; false where it is another key
bool TakeLayout(std::string_view key, std::string_view value, CsvComments* comments) {
  if (key == "times") {
    if (value == "arrived") comments->timing = Timing::kArrival;
    if (value == "polled" || value == "known") comments->timing = Timing::kPolled;
    comments->times_are_known = value == "known";
    return true;
  }
  if (key == "stretch") {
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
  line.remove_prefix(line.find_first_not_of("# \t") == std::string_view::npos
                         ? line.size()
                         : line.find_first_not_of("# \t"));
  Metadata& metadata = comments->metadata;
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) {
    if (!Trimmed(line).empty()) metadata.notes.emplace_back(Trimmed(line));
    return {};
  }
  const std::string_view key = Trimmed(line.substr(0, equals));
  const std::string_view value = Trimmed(line.substr(equals + 1));
  for (const auto& [name, member] : kMetadataTexts) {
    if (key != name) continue;
    metadata.*member = value;
    return {};
  }
  const auto taken = TakeNumber(key, value, where, &metadata);
  if (!taken) return std::unexpected(taken.error());
  if (*taken || TakeLayout(key, value, comments)) return {};
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
  if (value.empty()) return "";
  return Printable(fmt::format("# {} = {}", key, value)) + "\n";
}

std::string CsvMetadataLines(const Metadata& metadata) {
  std::string lines;
  for (const auto& [key, member] : kMetadataTexts) lines += CsvCommentLine(key, metadata.*member);
  for (const auto& [key, member] : kNumberKeys) {
    if (metadata.*member) lines += CsvCommentLine(key, fmt::format("{}", *(metadata.*member)));
  }
  if (metadata.averages) {
    lines += CsvCommentLine("averages", fmt::format("{}", *metadata.averages));
  }
  if (metadata.tare_m != 0) lines += CsvCommentLine("tare_m", fmt::format("{}", metadata.tare_m));
  for (const auto& [key, value] : metadata.labels) {
    lines += CsvCommentLine(std::string(kLabelPrefix) + key, value);
  }
  for (const auto& [key, value] : metadata.fields) lines += CsvCommentLine(key, value);
  for (const std::string& note : metadata.notes) lines += CsvCommentLine("note", note);
  return lines;
}

}  // namespace haptometer::trial
