#include "sim/sweep/sweep_axis.h"

#include <fmt/core.h>

#include <cmath>

#include "base/error.h"
#include "base/toml.h"

namespace haptometer::sim {

SweepValue NumberValue(double number) {
  std::string text = fmt::format("{}", number + 0.0);  // no -0
  return {.literal = text, .text = text};
}

SweepValue PlainValue(std::string_view word) {
  return {.literal = std::string(word), .text = std::string(word)};
}

SweepValue TextValue(std::string_view text) {
  return {.literal = TomlString(text), .text = std::string(text)};
}

double ValueAt(const SweepRange& range, double numerator, double denominator) {
  if (range.spacing == Spacing::kLinear) {
    return (range.begin * (denominator - numerator) + range.end * numerator) / denominator;
  }
  if (numerator == denominator) return range.end;
  // a power rounds as often as its exponent is large: 30000.000000000015 in double
  const auto begin = static_cast<long double>(range.begin);
  const auto ratio = static_cast<long double>(range.end) / begin;
  const auto way = static_cast<long double>(numerator) / static_cast<long double>(denominator);
  return static_cast<double>(begin * std::pow(ratio, way));
}

std::size_t CountOf(const SweepAxis& axis) {
  if (const auto* range = std::get_if<SweepRange>(&axis.values)) return range->count;
  return std::get<std::vector<SweepValue>>(axis.values).size();
}

SweepValue ValueOf(const SweepAxis& axis, std::size_t index) {
  HAPTOMETER_CHECK(index < CountOf(axis), "value {} of {}", index, CountOf(axis));
  const auto* range = std::get_if<SweepRange>(&axis.values);
  if (range == nullptr) return std::get<std::vector<SweepValue>>(axis.values)[index];
  return NumberValue(
      ValueAt(*range, static_cast<double>(index), static_cast<double>(range->count - 1)));
}

std::string WordOf(const SweepAxis& axis) {
  if (const auto* range = std::get_if<SweepRange>(&axis.values)) {
    const std::string_view log = range->spacing == Spacing::kLogarithmic ? "log:" : "";
    const std::string ends = fmt::format("{}{}:{}", log, range->begin, range->end);
    return range->count == 0 ? ends : fmt::format("{}:{}", ends, range->count);
  }
  std::string word;
  for (const SweepValue& value : std::get<std::vector<SweepValue>>(axis.values)) {
    if (!word.empty()) word += ',';
    word += value.text;
  }
  return word;
}

}  // namespace haptometer::sim
