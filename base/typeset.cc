#include "base/typeset.h"

#include <cctype>
#include <utility>

namespace haptometer {
namespace {

// a unit as text has it, and as a page
constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
    {"um", "µm"}, {"uH", "µH"},   {"us", "µs"}, {"ohm", "Ω"}, {"mm", "mm"}, {"ms", "ms"},
    {"mV", "mV"}, {"mA", "mA"},   {"mW", "mW"}, {"mH", "mH"}, {"Hz", "Hz"}, {"kHz", "kHz"},
    {"kg", "kg"}, {"rad", "rad"}, {"dB", "dB"}, {"VA", "VA"}, {"m", "m"},   {"s", "s"},
    {"g", "g"},   {"V", "V"},     {"A", "A"},   {"N", "N"},   {"W", "W"},   {"H", "H"},
    {"K", "K"},   {"%", "%"}};

bool IsLetterOrDigit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

// whether a word ends before `rest`, which is not the end of a file's name
bool IsEndOfWord(std::string_view rest) {
  const bool goes_on = !rest.empty() && (IsLetterOrDigit(rest.front()) || rest.front() == '_');
  return !goes_on && !(rest.size() > 1 && rest.front() == '.' && IsLetterOrDigit(rest[1]));
}

std::string_view PowerOf(char digit) { return digit == '2' ? "²" : digit == '3' ? "³" : ""; }

// takes a unit with its exponent from the beginning of `text`; empty where there is none
std::string TakeUnit(std::string_view& text) {
  for (const auto& [plain, sign] : kUnits) {
    if (!text.starts_with(plain)) continue;
    std::string_view rest = text.substr(plain.size());
    std::string unit(sign);
    if (rest.starts_with('^')) rest.remove_prefix(1);
    if (rest.starts_with('2') || rest.starts_with('3')) {
      unit += PowerOf(rest.front());
      rest.remove_prefix(1);
    }
    // the beginning of another word
    if (!IsEndOfWord(rest)) continue;
    text = rest;
    return unit;
  }
  return {};
}

}  // namespace

std::string Typeset(std::string_view text) {
  std::string set;
  char before = ' ';  // the last character but a blank
  bool is_unit = false;
  while (!text.empty()) {
    const char c = text.front();
    std::string_view rest = text.substr(1);
    if (text.starts_with("+-")) {
      set += "±";
      text.remove_prefix(2);
      continue;
    }
    // "R^2", "1/s^2"
    if (c == '^' && std::isalpha(static_cast<unsigned char>(before)) != 0 && !rest.empty() &&
        !PowerOf(rest.front()).empty() && IsEndOfWord(rest.substr(1))) {
      set += PowerOf(rest.front());
      text = rest.substr(1);
      continue;
    }
    const bool is_number = IsLetterOrDigit(before) ? before <= '9' : before == ')';
    std::string unit;
    // "12 um", "distance / um", "density / (um^2/Hz)"; "um/V"
    const bool is_before_unit =
        (c == ' ' && (is_number || before == '/')) || (c == '(' && before == '/');
    if (is_before_unit || (c == '/' && is_unit)) unit = TakeUnit(rest);
    is_unit = !unit.empty();
    set += is_unit && c == ' ' && is_number ? "\u00a0" : std::string(1, c);
    set += unit;
    text = rest;
    if (is_unit) {
      before = 'm';
    } else if (c != ' ') {
      before = c;
    }
  }
  return set;
}

}  // namespace haptometer
