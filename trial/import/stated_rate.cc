#include "trial/import/stated_rate.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "trial/import/printed_number.h"

namespace haptometer::trial {
namespace {

// the number directly before `end`, blanks in between aside
std::optional<double> NumberBefore(std::string_view text, std::size_t end) {
  const std::string_view before = Trimmed(text.substr(0, end));
  const std::size_t other = before.find_last_not_of("0123456789.eE+-");
  return ReadNumber(before.substr(other == std::string_view::npos ? 0 : other + 1));
}

std::optional<double> RateIn(std::string_view text) {
  const std::size_t unit = text.find("Hz");
  if (unit == std::string_view::npos || unit == 0) return std::nullopt;
  const char prefix = text[unit - 1];
  const double factor = prefix == 'k' ? 1e3 : prefix == 'M' ? 1e6 : prefix == 'G' ? 1e9 : 1;
  const auto number = NumberBefore(text, factor == 1 ? unit : unit - 1);
  if (!number || !(*number > 0) || !std::isfinite(*number)) return std::nullopt;
  return *number * factor;
}

bool SpeaksOfRate(std::string_view text) {
  for (const char* word : {"ampl", "rate", "RATE", "AMPL", "Rate"}) {
    if (text.find(word) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

std::optional<double> StatedRate(const Metadata& metadata) {
  if (metadata.nominal_rate_hz) return metadata.nominal_rate_hz;
  for (const auto& [key, value] : metadata.fields) {
    if (!SpeaksOfRate(key)) continue;
    if (key.ends_with("_hz")) {
      if (const auto number = ReadNumber(value); number && *number > 0) return number;
    }
    if (const auto rate_hz = RateIn(value)) return rate_hz;
  }
  for (const std::string& note : metadata.notes) {
    if (!SpeaksOfRate(note)) continue;
    if (const auto rate_hz = RateIn(note)) return rate_hz;
  }
  return std::nullopt;
}

std::string RateRemark(const Record& record) {
  const auto stated_hz = StatedRate(record.metadata);
  if (!stated_hz || record.stretches.empty()) return "";
  const double rate_hz = std::ranges::max_element(record.stretches, {}, &Stretch::rows)->rate_hz;
  const double thousands = std::log10(*stated_hz / rate_hz) / 3;
  // within 5 %, as rates are stated
  const double whole = std::round(thousands);
  if (!std::isfinite(thousands) || whole == 0 || std::abs(thousands - whole) * 3 > 0.021) return "";
  return fmt::format(
      "the times say {:.6g} rows a second where the file states {:.6g} Hz; they are taken at their "
      "word, but may be in another unit than their column says",
      rate_hz, *stated_hz);
}

}  // namespace haptometer::trial
