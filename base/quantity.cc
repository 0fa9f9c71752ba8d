#include "base/quantity.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "base/elementary_functions.h"

namespace haptometer {
namespace {

// Name and example for messages; bare numbers count as SI where they may.
struct DimensionRow {
  Dimension dimension;
  std::string_view name;
  std::string_view example;
  bool may_be_bare;
  PossibleMagnitudes possible;  // in SI units
};

using enum Dimension;
// limits far outside of any device: numbers beyond them are typing errors, and could overflow
constexpr std::array<DimensionRow, 13> kDimensions{{
    {kNone, "a plain number", "0.3", true, {1e-30, 1e30}},
    {kLength, "a length", "10mm", false, {1e-15, 1e6}},
    {kMass, "a mass", "1.4g", false, {1e-12, 1e6}},
    {kInductance, "an inductance", "130uH", false, {1e-12, 1e6}},
    {kTime, "a time", "3s", true, {1e-12, 1e12}},
    {kFrequency, "a frequency", "225Hz", true, {1e-9, 1e12}},
    {kVoltage, "a voltage", "5V", true, {1e-15, 1e9}},
    {kCurrent, "a current", "0.13A", true, {1e-15, 1e9}},
    {kResistance, "a resistance", "27ohm", true, {1e-9, 1e15}},
    {kStiffness, "a stiffness", "2800N/m", true, {1e-9, 1e15}},
    {kDamping, "a damping", "0.0322Ns/m", true, {1e-12, 1e12}},
    {kForceConstant, "a force constant", "1.0N/A", true, {1e-9, 1e9}},
    {kArea, "an area", "10mm2", true, {1e-15, 1e6}},
}};

struct Unit {
  std::string_view symbol;
  double si;  // how many SI units one of these is
};

// By dimension, the SI unit first; unused places have an empty symbol. "u" stands for micro here;
// Normalised() turns both code points of the Greek letter into it.
constexpr std::array<std::array<Unit, 6>, 13> kUnits{{
    {{{"", 1}}},
    {{{"m", 1}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}, {"cm", 1e-2}}},
    {{{"kg", 1}, {"g", 1e-3}, {"mg", 1e-6}}},
    {{{"H", 1}, {"mH", 1e-3}, {"uH", 1e-6}, {"nH", 1e-9}}},
    {{{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}, {"min", 60}, {"h", 3600}}},
    {{{"Hz", 1}, {"kHz", 1e3}, {"MHz", 1e6}, {"GHz", 1e9}}},
    {{{"V", 1}, {"mV", 1e-3}, {"uV", 1e-6}, {"kV", 1e3}}},
    {{{"A", 1}, {"mA", 1e-3}, {"uA", 1e-6}}},
    {{{"ohm", 1}, {"mohm", 1e-3}, {"kohm", 1e3}, {"Mohm", 1e6}}},
    {{{"N/m", 1}, {"N/mm", 1e3}}},
    {{{"N s/m", 1}, {"Ns/m", 1}, {"N*s/m", 1}}},
    {{{"N/A", 1}}},
    {{{"m2", 1}, {"cm2", 1e-4}, {"mm2", 1e-6}}},
}};

// both tables are in the order of Dimension
const std::array<Unit, 6>& UnitsOf(Dimension dimension) {
  return kUnits[static_cast<std::size_t>(dimension)];
}

const DimensionRow& RowOf(Dimension dimension) {
  return kDimensions[static_cast<std::size_t>(dimension)];
}

void ReplaceAll(std::string& text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// one spelling for micro, ohm and plus-minus; no surrounding blanks
std::string Normalised(std::string_view raw) {
  std::string text(raw);
  ReplaceAll(text, "\u00b5", "u");
  ReplaceAll(text, "\u03bc", "u");
  ReplaceAll(text, "\u03a9", "ohm");
  ReplaceAll(text, "\u2126", "ohm");
  for (const char* spelling : {"Ohms", "ohms", "Ohm", "OHM"}) ReplaceAll(text, spelling, "ohm");
  ReplaceAll(text, "\u00b1", "+-");
  ReplaceAll(text, "+/-", "+-");
  const auto first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

struct Number {
  double value = 0;
  double last_digit = 1;   // what one unit of the last written digit is worth
  std::size_t length = 0;  // characters read
};

// the decimal exponent behind `mark`, where "e-3" begins in `written`; 0 without one
int ExponentAt(std::string_view written, std::size_t mark) {
  int exponent = 0;
  if (mark >= written.size()) return exponent;
  const std::size_t first = mark + (written[mark + 1] == '+' ? 2 : 1);
  std::from_chars(written.data() + first, written.data() + written.size(), exponent);
  return exponent;
}

// a decimal number at the front of `text`
std::optional<Number> LeadingNumber(std::string_view text) {
  // from_chars() accepts no '+'
  const std::size_t sign = !text.empty() && text[0] == '+' ? 1 : 0;
  Number number;
  const char* begin = text.data() + sign;
  const auto [end, failure] = std::from_chars(begin, text.data() + text.size(), number.value);
  if (failure != std::errc{} || !std::isfinite(number.value)) return std::nullopt;
  number.length = static_cast<std::size_t>(end - text.data());
  const std::string_view digits = text.substr(sign, number.length - sign);
  const std::size_t mark = std::min(digits.find_first_of("eE"), digits.size());
  const std::size_t dot = std::min(digits.find('.'), mark);
  const int places = dot < mark ? static_cast<int>(mark - dot - 1) : 0;
  // 10^(exponent - decimal places): weight of the last digit written
  number.last_digit = Pow(10.0, ExponentAt(digits, mark) - places);
  return number;
}

// the factor of a unit, or nothing
std::optional<double> FactorOf(const DimensionRow& row, std::string_view symbol) {
  for (const Unit& unit : UnitsOf(row.dimension)) {
    if (!unit.symbol.empty() && unit.symbol == symbol) return unit.si;
  }
  return std::nullopt;
}

std::string UnitList(const DimensionRow& row) {
  std::string list;
  for (const Unit& unit : UnitsOf(row.dimension)) {
    if (unit.symbol.empty()) continue;
    if (!list.empty()) list += ", ";
    list += unit.symbol;
  }
  return list;
}

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// the unit behind a number in SI, or why there is none
Result<double> UnitFactor(const DimensionRow& row, std::string_view symbol, std::string_view number,
                          std::string_view where, BareNumber bare) {
  // a unit that is given must be one of the dimension
  if (!symbol.empty()) {
    if (const auto factor = FactorOf(row, symbol)) return *factor;
    const std::string units = UnitList(row);
    return Usage(std::string(where), fmt::format("'{}' is not a unit of {}", symbol, row.name),
                 units.empty() ? "write the number alone" : "use one of " + units);
  }
  if (row.may_be_bare || bare == BareNumber::kIsSi) return 1.0;
  // length, mass and inductance need a unit; the usual one is proposed, or that of the key
  const std::string_view customary = bare == BareNumber::kRefusedSi
                                         ? UnitsOf(row.dimension)[0].symbol
                                     : row.dimension == Dimension::kLength ? "mm"
                                     : row.dimension == Dimension::kMass   ? "g"
                                                                           : "uH";
  return Usage(std::string(where),
               fmt::format("'{}' has no unit, and {} needs one", number, row.name),
               fmt::format("did you mean {}{}?", number, customary));
}

// `value` times a factor whose inverse is a whole number where it is below 1. What would underflow
// to 0 stays as small as it is written: that is no 0, and beyond what is possible.
double Times(double value, double factor) {
  // division by the exact inverse: one rounding, where 1e-3 itself is already rounded
  const double product = factor < 1 ? value / std::round(1 / factor) : value * factor;
  return product == 0 ? value : product;
}

// The number at the front of `text` times a unit's factor. A power of ten moves the decimal point,
// so that 0.4 mm is the double next to 0.0004, as if that had been written.
double InSi(std::string_view text, const Number& number, double factor) {
  // the factor as a power of ten, where it is one within 1e-12
  const int shift = static_cast<int>(std::lround(Log10(factor)));
  const bool moves_the_point = std::abs(Pow(10.0, shift) / factor - 1) < 1e-12;
  if (shift == 0 || !moves_the_point) return Times(number.value, factor);
  const std::size_t sign = text.starts_with('+') ? 1 : 0;
  const std::string_view written = text.substr(sign, number.length - sign);
  const std::size_t mark = std::min(written.find_first_of("eE"), written.size());
  // the exponent is changed in the text, and the decimal number is rounded once
  const std::string shifted =
      fmt::format("{}e{}", written.substr(0, mark), ExponentAt(written, mark) + shift);
  double value = 0;
  const auto [end, failure] =
      std::from_chars(shifted.data(), shifted.data() + shifted.size(), value);
  return failure == std::errc{} && value != 0 ? value : Times(number.value, factor);
}

bool IsPossible(double value, const DimensionRow& row) {
  const double size = std::abs(value);
  // 0, a possible magnitude, or an infinite resistance (open circuit)
  return size == 0 || (size >= row.possible.least && size <= row.possible.largest) ||
         (row.dimension == Dimension::kResistance && value > 0 && std::isinf(value));
}

bool IsPossible(Quantity quantity, const DimensionRow& row) {
  return IsPossible(quantity.value, row) && IsPossible(quantity.standard_uncertainty, row);
}

Result<Quantity> NotPossible(std::string_view written, const DimensionRow& row,
                             std::string_view where) {
  const std::string_view unit = UnitsOf(row.dimension)[0].symbol;
  return Usage(std::string(where),
               fmt::format("'{}' is outside the possible range of {}", written, row.name),
               fmt::format("its size is 0, or from {} to {}{}{}", row.possible.least,
                           row.possible.largest, unit.empty() ? "" : " ", unit));
}

// `quantity`, which `written` stands for, where nothing about it is impossible
Result<Quantity> Possible(Quantity quantity, std::string_view written, const DimensionRow& row,
                          std::string_view where) {
  return IsPossible(quantity, row) ? Result<Quantity>(quantity) : NotPossible(written, row, where);
}

Result<Quantity> NotANumber(std::string_view raw, const DimensionRow& row, std::string_view where) {
  return Usage(std::string(where), fmt::format("'{}' is not {}", raw, row.name),
               fmt::format("write it like {}", row.example));
}

// "0,02": `rest` stands behind the 0, and the comma is the only one
bool HasDecimalComma(std::string_view text, std::string_view rest) {
  return rest.size() > 1 && rest[0] == ',' && rest[1] >= '0' && rest[1] <= '9' &&
         std::ranges::count(text, ',') == 1;
}

}  // namespace

PossibleMagnitudes PossibleMagnitudesOf(Dimension dimension) { return RowOf(dimension).possible; }

Result<Quantity> PossibleQuantity(Quantity quantity, Dimension dimension, std::string_view where) {
  const DimensionRow& row = RowOf(dimension);
  if (IsPossible(quantity, row)) return quantity;
  return NotPossible(fmt::format("{}", quantity.value), row, where);
}

std::string_view SiUnit(Dimension dimension) { return UnitsOf(dimension)[0].symbol; }

Result<Quantity> ParseQuantity(std::string_view raw, Dimension dimension, std::string_view where,
                               BareNumber bare) {
  const DimensionRow& row = RowOf(dimension);
  const std::string text = Normalised(raw);
  // open circuit
  if (dimension == Dimension::kResistance && (text == "inf" || text == "open")) {
    return Quantity{std::numeric_limits<double>::infinity(), 0};
  }
  const auto number = LeadingNumber(text);
  if (!number) return NotANumber(raw, row, where);
  std::string_view rest = std::string_view(text).substr(number->length);
  if (HasDecimalComma(text, rest)) {
    std::string with_point = text;
    with_point[with_point.find(',')] = '.';
    return Usage(std::string(where), fmt::format("'{}' has a decimal comma", raw),
                 fmt::format("write a point: {}", with_point));
  }
  double uncertainty = 0;

  // 1.40(3)g: the bracket counts in units of the last digit
  if (!rest.empty() && rest[0] == '(') {
    // digits in the bracket, directly behind the number
    const auto bracket = LeadingNumber(rest.substr(1));
    if (!bracket || bracket->length + 1 >= rest.size() || rest[bracket->length + 1] != ')') {
      return NotANumber(raw, row, where);
    }
    // "1.40(3)": 3 units of the last digit; "1.40(0.03)": the value itself
    const bool counts_digits = rest.substr(1, bracket->length).find('.') == std::string_view::npos;
    uncertainty = bracket->value * (counts_digits ? number->last_digit : 1.0);
    rest.remove_prefix(bracket->length + 2);
  }

  // 1.40g+-0.03g: two quantities; the left unit serves both when the right one has none
  const auto plus_minus = rest.find("+-");
  std::string_view symbol = Trimmed(rest.substr(0, plus_minus));
  if (plus_minus != std::string_view::npos) {
    const std::string_view right = Trimmed(rest.substr(plus_minus + 2));
    const auto deviation = LeadingNumber(right);
    // one statement of the uncertainty only
    if (!deviation || uncertainty != 0) return NotANumber(raw, row, where);
    const std::string_view right_symbol = Trimmed(right.substr(deviation->length));
    if (symbol.empty()) symbol = right_symbol;
    // the uncertainty may have a unit of its own
    HAPTOMETER_LET(const auto factor, UnitFactor(row, right_symbol.empty() ? symbol : right_symbol,
                                                 right.substr(0, deviation->length), where, bare));
    uncertainty = InSi(right, *deviation, factor);
    if (uncertainty < 0) return NotANumber(raw, row, where);
    HAPTOMETER_LET(const auto left,
                   UnitFactor(row, symbol, text.substr(0, number->length), where, bare));
    return Possible({InSi(text, *number, left), uncertainty}, raw, row, where);
  }
  // no "+-": one unit for number and bracket
  HAPTOMETER_LET(
      const auto factor,
      UnitFactor(row, symbol, std::string_view(text).substr(0, number->length), where, bare));
  if (uncertainty < 0) return NotANumber(raw, row, where);
  return Possible({InSi(text, *number, factor), Times(uncertainty, factor)}, raw, row, where);
}

}  // namespace haptometer
