#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "trial/record.h"

namespace haptometer::trial {

/// The text of a file as UTF-8 with lines that end in LF (or CR LF).
///
/// A byte-order mark is taken off; UTF-16 (told by its mark, or Utf16WithoutMark) is converted;
/// text that is not valid UTF-8 is read as Windows-1252, as oscilloscopes and spreadsheets write
/// "µs"; NUL bytes are dropped; lines that end in CR alone end in LF. Returns a view of `raw` where
/// nothing needs changing, else of `storage`. Cost: one pass over the bytes.
[[nodiscard]] std::string_view Utf8Text(std::string_view raw, std::string* storage);

/// The order of bytes of UTF-16 that has no mark, where most of the first characters of `text` are
/// Latin ones, with a NUL as the upper byte and none as the lower; nothing for other text.
enum class ByteOrder : std::uint8_t { kLittleEndian, kBigEndian };
[[nodiscard]] std::optional<ByteOrder> Utf16WithoutMark(std::string_view text);

/// `text` without blanks at its ends.
[[nodiscard]] std::string_view Trimmed(std::string_view text);

/// `text` in ASCII lower case.
[[nodiscard]] std::string LowerCase(std::string_view text);

/// The whole of `text` as a number; infinities and NaN count as numbers here.
[[nodiscard]] std::optional<double> ReadNumber(std::string_view text);

/// The same with a decimal comma or point.
[[nodiscard]] std::optional<double> ReadNumberWithComma(std::string_view text);

/// Whether `sign` may group the thousands of `text`: "1,234", "-12,345,678"; not "0,123", "12,5" or
/// "1,234e3".
[[nodiscard]] bool MayGroupThousands(std::string_view text, char sign);

/// What an instrument or a program prints where it has no number: "∞", "inf", "1.#INF", "OVER",
/// "OL", Keyence's "FFFFFFF" are kOver, with a minus (or "UNDER") kUnder; "****" is kClipped,
/// because it says nothing of the sign; "", "nan", "1.#QNAN", "1.#IND", "null", "None", "NA",
/// "---",
/// "--.--", Saleae's "X" and a spreadsheet's "#NUM!" are kInvalid. Nothing for any other text.
[[nodiscard]] std::optional<SampleStatus> ReadNoNumber(std::string_view cell);

/// What an instrument sends in place of a number (SCPI 1999.0, volume 1, 7.2.1.4 and 7.2.1.5):
/// 9.9e37 for infinity is kOver, -9.9e37 kUnder, 9.91e37 kInvalid. Nothing for any other number.
[[nodiscard]] std::optional<SampleStatus> ReadScpiNoNumber(double number);

/// Seconds since midnight of a time on the clock, "12:00:47.056435" or with a decimal comma; a date
/// before it ("5/7/2021  12:00:47.056435", "2021-07-05T12:00:47Z") is passed over. Nothing where
/// `text` is none.
[[nodiscard]] std::optional<double> ReadClock(std::string_view text);

/// Whether `text` is a date alone: "2024-05-06", "6.5.2024", "5/7/21".
[[nodiscard]] bool IsDate(std::string_view text);

/// A unit as tables print it.
struct PrintedUnit {
  std::string_view si_unit;  ///< "s", "m", "V" or "A"
  double factor = 1;         ///< one printed unit in SI
};

/// "s", "second(s)", "ms", "us", "m", "mm", "um", "inch", "mil", "V", "Volt(s)", "mV", "A",
/// "Amp(s)", "mA" ...; upper and lower case are alike but for a leading M, which is no milli.
[[nodiscard]] std::optional<PrintedUnit> FindUnit(std::string_view text);

/// What is measured in `si_unit`: "m" is a displacement, "V" a voltage, "A" a current.
[[nodiscard]] ChannelRole RoleOfUnit(std::string_view si_unit);

/// One line of a table with the separator that it suggests.
struct TableCells {
  char separator = ',';
  std::vector<std::string_view> cells{};
};

/// Bounds of a table, wide of what programs write. With them the memory for reading is a small
/// multiple of the file's size, whatever it holds.
inline constexpr std::size_t kMostColumns = 4096;
inline constexpr std::size_t kMostLineBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMostHeaderLines = 100'000;  ///< that state something to be kept

/// Refuses a text with a line of more than kMostLineBytes or kMostColumns, or with more # lines
/// than kMostHeaderLines, before any of it is split. Errors (Cause::kCannotAnswer) name the line.
/// Cost: one pass, no memory.
[[nodiscard]] Result<void> CheckLines(std::string_view text, const std::string& name);

/// Whether the last line of `text` was cut off: it has no line end, and fewer cells than each of
/// the rows right above it, or fewer digits behind the decimal sign of its last number; of 64 rows,
/// of which at least 8 are there. Cost: that of so many lines.
[[nodiscard]] bool IsLastLineCutOff(std::string_view text);

/// `line` without blanks and a carriage return at its ends; tabs stay, because they separate empty
/// cells there.
[[nodiscard]] std::string_view LineWithTabs(std::string_view line);

/// The cells of `line`, without blanks and quotes around them, into `cells`. With a blank as the
/// separator any run of blanks and tabs outside of quotes and brackets separates, but one in front
/// of an opening bracket, whose unit belongs to the name before: "Time (s)  CH 1" is "Time (s)",
/// "CH", "1".
void SplitCells(std::string_view line, char separator, std::vector<std::string_view>* cells);
[[nodiscard]] std::vector<std::string_view> SplitCells(std::string_view line, char separator);

/// The cells of a line whose separator is not known: semicolon where there is one, else tab, else
/// blanks where they make numbers of it and commas do not, else comma. Separators within quotes do
/// not count.
[[nodiscard]] TableCells CellsOf(std::string_view line);

/// "commas", "semicolons", "tabs" or "blanks".
[[nodiscard]] std::string_view NameOfSeparator(char separator);

/// Whether a row of a table of numbers can look so: numbers, a time on the clock as the first
/// or behind a date as the first, and cells that say why there is no number (ReadNoNumber); at
/// least one is a number.
[[nodiscard]] bool IsNumbers(const std::vector<std::string_view>& cells);

}  // namespace haptometer::trial
