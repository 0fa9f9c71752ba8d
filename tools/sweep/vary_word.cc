#include "tools/sweep/vary_word.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "base/quantity.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kLogarithmic = "log:";
constexpr std::int64_t kMostValues = 1'000'000'000;

struct KeyUnit {
  std::string_view ending;  // of the key's name
  Dimension dimension;
};

// those with "per" first: "_n_per_m" also ends in "_m"
constexpr auto kKeyUnits = std::to_array<KeyUnit>({
    {"_n_s_per_m", Dimension::kDamping},
    {"_n_per_m", Dimension::kStiffness},
    {"_n_per_a", Dimension::kForceConstant},
    {"_kg", Dimension::kMass},
    {"_hz", Dimension::kFrequency},
    {"_ohm", Dimension::kResistance},
    {"_m", Dimension::kLength},
    {"_s", Dimension::kTime},
    {"_v", Dimension::kVoltage},
    {"_a", Dimension::kCurrent},
    {"_h", Dimension::kInductance},
});

// of the unit in the key's name; plain where it has none that base/quantity.h knows
Dimension DimensionOf(std::string_view key) {
  for (const KeyUnit& unit : kKeyUnits) {
    if (!key.ends_with(unit.ending)) continue;
    const bool is_quotient = unit.ending.find("_per_") == std::string_view::npos &&
                             key.substr(0, key.size() - unit.ending.size()).ends_with("_per");
    return is_quotient ? Dimension::kNone : unit.dimension;
  }
  return Dimension::kNone;
}

std::vector<std::string> SplitAt(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t at = text.find(separator); at != std::string::npos;
       at = text.find(separator, begin)) {
    parts.push_back(text.substr(begin, at - begin));
    begin = at + 1;
  }
  parts.push_back(text.substr(begin));
  return parts;
}

// an exact number of the key's dimension
Result<double> ReadNumber(const std::string& word, Dimension dimension, const std::string& where) {
  const auto quantity = ParseQuantity(word, dimension, where);
  if (!quantity) return std::unexpected(quantity.error());
  if (!quantity->exact()) {
    return Usage(where, fmt::format("'{}' has an uncertainty", word),
                 "give exact values to a sweep");
  }
  return quantity->value;
}

std::optional<std::int64_t> SignedWholeNumber(std::string_view text) {
  std::int64_t value = 0;
  const auto [stop, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc{} || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

// one value of a list
Result<sim::SweepValue> ReadValue(const std::string& word, Dimension dimension,
                                  const std::string& where) {
  const bool has_control = std::ranges::any_of(
      word, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (word.empty() || has_control) {
    return Usage(where, "has a value that is empty or not printable", "write it as KEY=A,B,C");
  }
  if (dimension == Dimension::kNone) {
    if (const auto whole = SignedWholeNumber(word)) return sim::PlainValue(fmt::format("{}", *whole));
    if (word == "true" || word == "false") return sim::PlainValue(word);
    if (!ParseQuantity(word, dimension, where)) return sim::TextValue(word);
  }
  const auto number = ReadNumber(word, dimension, where);
  if (!number) return std::unexpected(number.error());
  return sim::NumberValue(*number);
}

// a text may hold a colon ("C:/actuator.toml"); a range begins with a number
bool IsRange(const std::string& text) {
  if (text.starts_with(kLogarithmic)) return true;
  return text.find(':') != std::string::npos &&
         std::string_view("0123456789+-.").find(text[0]) != std::string_view::npos;
}

Result<std::size_t> ReadCount(const std::vector<std::string>& parts, RangesAre ranges,
                              const std::string& where) {
  if (ranges == RangesAre::kSampled) {
    if (parts.size() == 2) return std::size_t{0};
    return Usage(where, "is to be sampled, so it is BEGIN:END",
                 "leave out the count, or --samples");
  }
  if (parts.size() != 3) {
    return Usage(where, "is not BEGIN:END:COUNT",
                 "write it like 100Hz:400Hz:301, or give --samples");
  }
  const auto count = SignedWholeNumber(parts[2]);
  if (!count || *count < 2 || *count > kMostValues) {
    return Usage(where, fmt::format("'{}' is no count of values", parts[2]),
                 "give 2 or more, both ends among them");
  }
  return static_cast<std::size_t>(*count);
}

Result<sim::SweepRange> ReadRange(std::string text, Dimension dimension, RangesAre ranges,
                                  const std::string& where) {
  sim::SweepRange range;
  if (text.starts_with(kLogarithmic)) {
    range.spacing = sim::Spacing::kLogarithmic;
    text = text.substr(kLogarithmic.size());
  }
  const std::vector<std::string> parts = SplitAt(text, ':');
  const auto count = ReadCount(parts, ranges, where);
  if (!count) return std::unexpected(count.error());
  range.count = *count;
  const auto begin = ReadNumber(parts[0], dimension, where);
  if (!begin) return std::unexpected(begin.error());
  const auto end = ReadNumber(parts[1], dimension, where);
  if (!end) return std::unexpected(end.error());
  range.begin = *begin;
  range.end = *end;
  // infinite ends are equal too, in this sense
  if (!(range.end - range.begin != 0 && std::isfinite(range.end - range.begin))) {
    return Usage(where, "has ends between which there is nothing", "give a single value alone");
  }
  if (range.spacing == sim::Spacing::kLogarithmic && !(range.begin > 0 && range.end > 0)) {
    return Usage(where, "is logarithmic and reaches to 0 or below", "give ends above 0");
  }
  return range;
}

}  // namespace

Result<sim::SweepAxis> ReadVaryWord(const std::string& word, RangesAre ranges) {
  const std::size_t equals = word.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
    return Usage("--vary", fmt::format("'{}' is not KEY=VALUES", word),
                 "write it like drive.frequency_hz=100Hz:400Hz:301");
  }
  sim::SweepAxis axis{.key = word.substr(0, equals), .values = {}};
  const std::string where = fmt::format("--vary {}", axis.key);
  const std::string text = word.substr(equals + 1);
  const Dimension dimension = DimensionOf(axis.key);
  if (IsRange(text)) {
    auto range = ReadRange(text, dimension, ranges, where);
    if (!range) return std::unexpected(range.error());
    axis.values = *range;
    return axis;
  }
  std::vector<sim::SweepValue> values;
  for (const std::string& part : SplitAt(text, ',')) {
    auto value = ReadValue(part, dimension, where);
    if (!value) return std::unexpected(value.error());
    values.push_back(*std::move(value));
  }
  axis.values = std::move(values);
  return axis;
}

}  // namespace haptometer::tools
