#include "trial/import/printed_number.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

namespace haptometer::trial {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::optional<double> ReadNumber(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0;
  const auto parsed = std::from_chars(text.begin(), text.end(), number);
  if (parsed.ec != std::errc() || parsed.ptr != text.end()) return std::nullopt;
  return number;
}

std::optional<double> ReadNumberWithComma(std::string_view text) {
  if (text.find(',') == std::string_view::npos) return ReadNumber(text);
  std::string with_point(text);
  std::ranges::replace(with_point, ',', '.');
  return ReadNumber(with_point);
}

std::optional<SampleStatus> ReadNoNumber(std::string_view cell) {
  constexpr std::size_t kLongest = 12;
  if (cell.size() > kLongest) return std::nullopt;
  std::string word = LowerCase(cell);
  if (!word.empty() && word.find_first_not_of('*') == std::string::npos) {
    return SampleStatus::kClipped;
  }
  if (word.find_first_not_of('-') == std::string::npos) return SampleStatus::kInvalid;
  constexpr std::array<std::string_view, 8> kNone{"nan",     "-nan", "x",   "#num!",
                                                  "#value!", "#n/a", "n/a", "invalid"};
  if (std::ranges::find(kNone, word) != kNone.end()) return SampleStatus::kInvalid;
  if (word == "under" || word == "underflow") return SampleStatus::kUnder;
  const bool is_negative = word.starts_with('-');
  if (is_negative || word.starts_with('+')) word.erase(0, 1);
  constexpr std::array<std::string_view, 6> kOver{"\xe2\x88\x9e", "inf", "infinity",
                                                  "over",         "ol",  "overflow"};
  if (std::ranges::find(kOver, word) == kOver.end()) return std::nullopt;
  return is_negative ? SampleStatus::kUnder : SampleStatus::kOver;
}

std::optional<double> ReadClock(std::string_view text) {
  text = Trimmed(text);
  // "2024-05-06T12:00:00.5Z"
  if (text.ends_with('Z')) text.remove_suffix(1);
  if (const std::size_t blank = text.find_last_of(" T"); blank != std::string_view::npos) {
    text.remove_prefix(blank + 1);
  }
  double seconds = 0;
  for (int part = 0; part < 3; ++part) {
    const std::size_t colon = text.find(':');
    if ((colon == std::string_view::npos) != (part == 2)) return std::nullopt;
    const auto number = ReadNumberWithComma(text.substr(0, colon));
    if (!number || !(*number >= 0 && *number < 61)) return std::nullopt;
    seconds = 60 * seconds + *number;
    text = part == 2 ? "" : text.substr(colon + 1);
  }
  return seconds;
}

}  // namespace haptometer::trial
