#include "trial/import/table/table_cells.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "base/text.h"

namespace haptometer::trial {
namespace {

unsigned Byte(char c) { return static_cast<unsigned char>(c); }

// UTF-8 of one code point in 1 to 4 bytes: lead byte with the length, then 6 bits a byte
void AppendUtf8(std::uint32_t code, std::string* text) {
  const auto put = [text](std::uint32_t byte) { text->push_back(static_cast<char>(byte)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0 | code >> 6);
    put(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  } else {
    put(0xf0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3f));
    put(0x80 | (code >> 6 & 0x3f));
    put(0x80 | (code & 0x3f));
  }
}

// UTF-8 of UTF-16 text; an unpaired surrogate becomes the replacement character U+FFFD
std::string FromUtf16(std::string_view raw, bool is_big_endian) {
  constexpr std::uint32_t kReplacement = 0xfffd;
  const auto unit = [&](std::size_t i) -> std::uint32_t {
    const unsigned first = Byte(raw[i]);
    const unsigned second = Byte(raw[i + 1]);
    return is_big_endian ? first << 8U | second : second << 8U | first;
  };
  std::string text;
  text.reserve(raw.size());
  for (std::size_t i = 0; i + 1 < raw.size(); i += 2) {
    std::uint32_t code = unit(i);
    const bool is_high = code >= 0xd800 && code < 0xdc00;
    // a high and a low surrogate are one code point above U+FFFF, 10 bits each
    if (is_high && i + 3 < raw.size() && unit(i + 2) >= 0xdc00 && unit(i + 2) < 0xe000) {
      code = 0x10000 + ((code - 0xd800) << 10U) + (unit(i + 2) - 0xdc00);
      i += 2;
    } else if (code >= 0xd800 && code < 0xe000) {
      code = kReplacement;
    }
    AppendUtf8(code, &text);
  }
  return text;
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    // most tables are ASCII
    const auto is_ascii = [](char c) { return Byte(c) < 0x80; };
    text.remove_prefix(
        static_cast<std::size_t>(std::ranges::find_if_not(text, is_ascii) - text.begin()));
    if (text.empty()) return true;
    const std::size_t bytes = Utf8CharacterBytes(text);
    if (bytes == 0) return false;
    text.remove_prefix(bytes);
  }
  return true;
}

// UTF-8 of Windows-1252 text; any bytes are such text
std::string FromWindows1252(std::string_view raw) {
  // code points of the bytes 0x80 to 0x9f; the others are those of Latin-1
  constexpr std::array<std::uint16_t, 32> kAbove7f{
      0x20ac, 0xfffd, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160,
      0x2039, 0x0152, 0xfffd, 0x017d, 0xfffd, 0xfffd, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022,
      0x2013, 0x2014, 0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0xfffd, 0x017e, 0x0178};
  std::string text;
  text.reserve(raw.size());
  for (const char c : raw) {
    const unsigned byte = Byte(c);
    AppendUtf8(byte >= 0x80 && byte < 0xa0 ? kAbove7f[byte - 0x80] : byte, &text);
  }
  return text;
}

}  // namespace

std::optional<ByteOrder> Utf16WithoutMark(std::string_view text) {
  constexpr std::size_t kLooked = 64;
  constexpr std::size_t kFewest = 8;
  text = text.substr(0, kLooked);
  if (text.size() < kFewest) return std::nullopt;
  // NUL bytes at even and at odd places
  std::array<std::size_t, 2> nuls{};
  for (std::size_t i = 0; i < text.size(); ++i) nuls[i % 2] += text[i] == '\0' ? 1 : 0;
  const std::size_t most = text.size() * 3 / 8;
  if (nuls[0] == 0 && nuls[1] >= most) return ByteOrder::kLittleEndian;
  if (nuls[1] == 0 && nuls[0] >= most) return ByteOrder::kBigEndian;
  return std::nullopt;
}

std::string_view Utf8Text(std::string_view raw, std::string* storage) {
  std::string_view text = raw;
  // byte order marks: UTF-16 little endian, UTF-16 big endian, UTF-8
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    *storage = FromUtf16(text.substr(2), text.starts_with("\xfe\xff"));
    text = *storage;
  } else if (const auto order = Utf16WithoutMark(text)) {
    *storage = FromUtf16(text, *order == ByteOrder::kBigEndian);
    text = *storage;
  } else if (text.starts_with("\xef\xbb\xbf")) {
    text.remove_prefix(3);
  }
  // bytes that are no UTF-8 are read as Windows-1252
  if (!IsUtf8(text)) {
    *storage = FromWindows1252(text);
    text = *storage;
  }
  // NUL bytes are removed; line ends of CR alone become LF
  const bool has_nul = text.find('\0') != std::string_view::npos;
  const bool ends_in_cr =
      text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos;
  if (!has_nul && !ends_in_cr) return text;
  std::string changed(text);
  std::erase(changed, '\0');
  if (ends_in_cr) std::ranges::replace(changed, '\r', '\n');
  *storage = std::move(changed);
  return *storage;
}

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
  // from_chars accepts no plus sign
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0;
  const auto parsed = std::from_chars(text.begin(), text.end(), number);
  if (parsed.ec != std::errc() || parsed.ptr != text.end()) return std::nullopt;
  return number;
}

// the number with a decimal point or a decimal comma; nothing for "1,000.5"
std::optional<double> ReadNumberWithComma(std::string_view text) {
  if (text.find(',') == std::string_view::npos) return ReadNumber(text);
  std::string with_point(text);
  std::ranges::replace(with_point, ',', '.');
  return ReadNumber(with_point);
}

bool MayGroupThousands(std::string_view text, char sign) {
  if (text.starts_with('+') || text.starts_with('-')) text.remove_prefix(1);
  // one to three digits, the first no 0
  const std::size_t head = std::min(text.find(sign), text.size());
  if (head < 1 || head > 3 || head == text.size() || text[0] == '0') return false;
  // groups of the sign and three digits behind them
  constexpr std::size_t kGroup = 4;
  const std::size_t behind = text.size() - head;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_sign = i >= head && (i - head) % kGroup == 0;
    if (is_sign ? text[i] != sign : text[i] < '0' || text[i] > '9') return false;
  }
  return behind % kGroup == 0;
}

std::optional<SampleStatus> ReadNoNumber(std::string_view cell) {
  // longer cells are text, not a mark for a missing value
  constexpr std::size_t kLongest = 12;
  if (cell.size() > kLongest) return std::nullopt;
  std::string word = LowerCase(cell);
  // "****": a display that overflows
  if (!word.empty() && word.find_first_not_of('*') == std::string::npos) {
    return SampleStatus::kClipped;
  }
  // empty, or dashes in place of digits: no reading
  const bool has_dash = word.empty() || word.contains('-');
  if (has_dash && word.find_first_not_of("-.,") == std::string::npos) return SampleStatus::kInvalid;
  // the last four: a NaN of Microsoft's C library, with a sign or without
  constexpr std::array<std::string_view, 15> kNone{
      "nan",  "-nan", "x",  "#num!",   "#value!",  "#n/a",   "n/a",    "invalid",
      "null", "none", "na", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"};
  if (std::ranges::find(kNone, word) != kNone.end()) return SampleStatus::kInvalid;
  if (word == "under" || word == "underflow") return SampleStatus::kUnder;
  const bool is_negative = word.starts_with('-');
  // the sign of an overflow distinguishes over from under
  if (is_negative || word.starts_with('+')) word.erase(0, 1);
  constexpr std::array<std::string_view, 10> kOver{
      "\xe2\x88\x9e", "inf",      "infinity",  "over",   "ol",
      "overflow",     "overload", "overrange", "1.#inf", "fffffff"};
  if (std::ranges::find(kOver, word) == kOver.end()) return std::nullopt;
  return is_negative ? SampleStatus::kUnder : SampleStatus::kOver;
}

std::optional<SampleStatus> ReadScpiNoNumber(double number) {
  constexpr double kInfinity = 9.9e37;
  constexpr double kNotANumber = 9.91e37;
  const auto is = [number](double value) { return std::abs(number - value) < 1e-6 * kInfinity; };
  if (is(kNotANumber)) return SampleStatus::kInvalid;
  if (is(kInfinity)) return SampleStatus::kOver;
  if (is(-kInfinity)) return SampleStatus::kUnder;
  return std::nullopt;
}

// seconds since midnight of h:min:s; a date before it is ignored
std::optional<double> ReadClock(std::string_view text) {
  text = Trimmed(text);
  // "2024-05-06T12:00:00.5Z"
  if (text.ends_with('Z')) text.remove_suffix(1);
  // the date ends at the last blank or T
  if (const std::size_t blank = text.find_last_of(" T"); blank != std::string_view::npos) {
    text.remove_prefix(blank + 1);
  }
  double seconds = 0;
  for (int part = 0; part < 3; ++part) {
    const std::size_t colon = text.find(':');
    if ((colon == std::string_view::npos) != (part == 2)) return std::nullopt;
    const auto number = ReadNumberWithComma(text.substr(0, colon));
    // one limit for hours, minutes and seconds, which rejects text that is no clock time
    if (!number || !(*number >= 0 && *number < 61)) return std::nullopt;
    seconds = 60 * seconds + *number;
    text = part == 2 ? "" : text.substr(colon + 1);
  }
  return seconds;
}

bool IsDate(std::string_view text) {
  // three numbers between two equal signs
  const std::size_t first = text.find_first_of("-./");
  if (first == std::string_view::npos) return false;
  const std::size_t second = text.find(text[first], first + 1);
  if (second == std::string_view::npos) return false;
  const std::array<std::string_view, 3> parts{
      text.substr(0, first), text.substr(first + 1, second - first - 1), text.substr(second + 1)};
  const auto is_part = [](std::string_view part, std::size_t digits) {
    return !part.empty() && part.size() <= digits &&
           part.find_first_not_of("0123456789") == std::string_view::npos;
  };
  // the year is the first or the last of them
  return is_part(parts[0], 4) && is_part(parts[1], 2) && is_part(parts[2], 4) &&
         parts[0].size() + parts[2].size() <= 6;
}

namespace {

// the names of a unit in lower case, each between blanks
struct UnitNames {
  PrintedUnit unit;
  std::string_view names;
};

// SI unit and factor; both code points of the micro sign (U+00B5, U+03BC) occur in files
constexpr std::array kUnits{
    UnitNames{{"s", 1}, " s sec second seconds sekunden "},
    UnitNames{{"s", 1e-3}, " ms msec millisecond milliseconds "},
    UnitNames{{"s", 1e-6}, " us \u00b5s \u03bcs usec microsecond microseconds "},
    UnitNames{{"s", 1e-9}, " ns nanosecond nanoseconds "},
    UnitNames{{"s", 1e-12}, " ps "},
    UnitNames{{"m", 1}, " m meter meters metre metres "},
    UnitNames{{"m", 1e-2}, " cm centimeters "},
    UnitNames{{"m", 1e-3}, " mm millimeter millimeters millimetre millimetres "},
    UnitNames{{"m", 1e-6},
              " um \u00b5m \u03bcm micrometer micrometers micrometre micrometres microns "},
    UnitNames{{"m", 1e-9}, " nm nanometer nanometers nanometres "},
    UnitNames{{"m", 25.4e-3}, " inch inches "},
    UnitNames{{"m", 25.4e-6}, " mil mils thou "},
    UnitNames{{"V", 1}, " v volt volts "},
    UnitNames{{"V", 1e-3}, " mv millivolt millivolts "},
    UnitNames{{"V", 1e-6}, " uv \u00b5v \u03bcv microvolts "},
    UnitNames{{"V", 1e3}, " kv "},
    UnitNames{{"A", 1}, " a amp amps ampere amperes "},
    UnitNames{{"A", 1e-3}, " ma milliamp milliamps milliamperes "},
    UnitNames{{"A", 1e-6}, " ua \u00b5a \u03bca microamps "},
};

}  // namespace

std::optional<PrintedUnit> FindUnit(std::string_view text) {
  // a unit is compared in lower case, so that "MV" would be read as millivolts
  const bool is_mega = text.size() > 1 && text[0] == 'M' && text.size() < 3;
  // nor are newton metres nanometres
  if (is_mega || text == "Nm") return std::nullopt;
  if (text.contains(' ')) return std::nullopt;
  const std::string word = " " + LowerCase(text) + " ";
  const auto found = std::ranges::find_if(
      kUnits, [&](const UnitNames& unit) { return unit.names.contains(word); });
  if (found == kUnits.end()) return std::nullopt;
  return found->unit;
}

ChannelRole RoleOfUnit(std::string_view si_unit) {
  if (si_unit == "m") return ChannelRole::kDisplacement;
  if (si_unit == "V") return ChannelRole::kVoltage;
  if (si_unit == "A") return ChannelRole::kCurrent;
  return ChannelRole::kOther;
}

namespace {

// where the cell at the beginning of `line` ends: at a separator outside of quotes
std::size_t CellEnd(std::string_view line, char separator) {
  const std::size_t end = line.find(separator);
  if (end == std::string_view::npos) return end;
  const std::size_t open = line.find_first_not_of(" \t");
  if (open >= end || line[open] != '"') return end;
  const std::size_t close = line.find('"', open + 1);
  // a quote without a closing one is an ordinary character
  return close == std::string_view::npos ? end : line.find(separator, close + 1);
}

bool HasOutsideQuotes(std::string_view line, char wanted) {
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') is_quoted = !is_quoted;
    if (c == wanted && !is_quoted) return true;
  }
  return false;
}

std::string_view WithoutQuotes(std::string_view cell) {
  const bool is_quoted = cell.size() >= 2 && cell.starts_with('"') && cell.ends_with('"');
  return is_quoted ? Trimmed(cell.substr(1, cell.size() - 2)) : cell;
}

// where the cell at the beginning of `line` ends: at blanks outside of quotes and brackets
std::size_t CellEndAtBlanks(std::string_view line) {
  bool is_quoted = false;
  int open = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') is_quoted = !is_quoted;
    if (c == '(' || c == '[') ++open;
    if (c == ')' || c == ']') --open;
    // a blank inside quotes or brackets belongs to the cell
    if ((c != ' ' && c != '\t') || is_quoted || open > 0) continue;
    // blanks before a bracket belong to the cell: "Time (s)"
    const std::size_t next = line.find_first_not_of(" \t", i);
    if (next == std::string_view::npos) return i;
    if (i == 0 || (line[next] != '(' && line[next] != '[')) return i;
  }
  return std::string_view::npos;
}

void SplitAtBlanks(std::string_view line, std::vector<std::string_view>* cells) {
  line = Trimmed(line);
  do {
    const std::size_t end = CellEndAtBlanks(line);
    cells->push_back(WithoutQuotes(line.substr(0, end)));
    line = end == std::string_view::npos ? "" : Trimmed(line.substr(end));
  } while (!line.empty());
}

// upper limit of the number of cells, for each of the separators
std::size_t MostCells(std::string_view line) {
  // a line has at most one cell more than characters
  if (line.size() < kMostColumns) return line.size() + 1;
  std::size_t cells = 0;
  for (const char separator : {',', ';', '\t'}) {
    const auto separators = static_cast<std::size_t>(std::ranges::count(line, separator));
    cells = std::max(cells, separators + 1);
  }
  return cells;
}

}  // namespace

// guards memory and time against files that are no tables: long lines, columns, comments
Result<void> CheckLines(std::string_view text, const std::string& name) {
  std::size_t comments = 0;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const auto refuse = [&](std::string what) -> Result<void> {
      return CannotAnswer(fmt::format("{}: line {}", name, number), std::move(what),
                          "is it a table of measurements?");
    };
    if (line.size() > kMostLineBytes) {
      return refuse(fmt::format("is longer than {} MiB", kMostLineBytes >> 20));
    }
    if (MostCells(line) > kMostColumns) {
      return refuse(fmt::format("has more than {} columns", kMostColumns));
    }
    if (line.starts_with('#') && ++comments > kMostHeaderLines) {
      return refuse(fmt::format("is the last of more than {} comments", kMostHeaderLines));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

namespace {

// what is shorter of a line that was cut off
struct LineShape {
  std::size_t cells = 0;
  std::size_t places = 0;  // characters behind the decimal sign of the last cell that is not empty
};

LineShape ShapeOf(const std::vector<std::string_view>& cells) {
  const auto last = std::ranges::find_if(cells.rbegin(), cells.rend(),
                                         [](std::string_view cell) { return !cell.empty(); });
  if (last == cells.rend()) return {cells.size()};
  const std::size_t sign = last->find_last_of(".,");
  return {cells.size(), sign == std::string_view::npos ? 0 : last->size() - sign - 1};
}

}  // namespace

bool IsLastLineCutOff(std::string_view text) {
  constexpr std::size_t kLines = 64;
  constexpr std::size_t kFewest = 8;
  std::size_t end = text.rfind('\n');
  if (end == std::string_view::npos || end + 1 == text.size()) return false;
  const LineShape last = ShapeOf(CellsOf(LineWithTabs(text.substr(end + 1))).cells);
  bool has_fewer_cells = true;
  bool has_fewer_places = true;
  // upwards, up to what stands above the rows
  std::size_t rows = 0;
  while (rows < kLines && end != std::string_view::npos && end > 0) {
    const std::size_t before = text.rfind('\n', end - 1);
    const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
    const auto cells = CellsOf(LineWithTabs(text.substr(begin, end - begin))).cells;
    if (!IsNumbers(cells)) break;
    const auto [count, places] = ShapeOf(cells);
    has_fewer_cells = has_fewer_cells && last.cells < count;
    has_fewer_places = has_fewer_places && last.cells == count && last.places < places;
    end = before;
    ++rows;
  }
  return rows >= kFewest && (has_fewer_cells || has_fewer_places);
}

// without blanks at the ends; tabs there separate empty cells
std::string_view LineWithTabs(std::string_view line) {
  constexpr std::string_view kBlanks = " \r";
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

void SplitCells(std::string_view line, char separator, std::vector<std::string_view>* cells) {
  cells->clear();
  if (separator == ' ') {
    SplitAtBlanks(line, cells);
    return;
  }
  for (;;) {
    const std::size_t end = CellEnd(line, separator);
    cells->push_back(WithoutQuotes(Trimmed(line.substr(0, end))));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

std::vector<std::string_view> SplitCells(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  SplitCells(line, separator, &cells);
  return cells;
}

// separator by precedence: semicolon, tab, comma; blanks only where that gives a row of numbers
TableCells CellsOf(std::string_view line) {
  if (HasOutsideQuotes(line, ';')) return {';', SplitCells(line, ';')};
  if (HasOutsideQuotes(line, '\t')) return {'\t', SplitCells(line, '\t')};
  TableCells by_commas{',', SplitCells(line, ',')};
  const bool has_blanks = Trimmed(line).find(' ') != std::string_view::npos;
  if (!has_blanks || IsNumbers(by_commas.cells)) return by_commas;
  TableCells by_blanks{' ', SplitCells(line, ' ')};
  const bool is_row = by_blanks.cells.size() > 1 && IsNumbers(by_blanks.cells);
  return is_row ? by_blanks : by_commas;
}

std::string_view NameOfSeparator(char separator) {
  if (separator == ';') return "semicolons";
  if (separator == '\t') return "tabs";
  return separator == ' ' ? "blanks" : "commas";
}

// whether all cells are numbers or marks for missing values, and at least one is a number
bool IsNumbers(const std::vector<std::string_view>& cells) {
  bool has_number = false;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    // a time of day is the first cell, or the one behind its date
    const bool is_clock = (i == 0 || (i == 1 && IsDate(cells[0]))) && ReadClock(cells[i]);
    const bool is_date = i == 0 && cells.size() > 1 && IsDate(cells[0]) && ReadClock(cells[1]);
    const bool is_number = ReadNumberWithComma(cells[i]) || is_clock;
    if (!is_number && !is_date && !ReadNoNumber(cells[i])) return false;
    has_number = has_number || is_number;
  }
  return has_number;
}

}  // namespace haptometer::trial
