#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/protocol/line_framer.h"
#include "acquire/protocol/wire.h"
#include "base/error.h"

/// Free-running ASCII lines of one fixed width, such as `+01.2345` CR: pure functions between lines
/// and values, both directions.
namespace haptometer::acquire {

/// Where a line's sign stands.
enum class SignRule : std::uint8_t {
  kAlways,  ///< `+` or `-` in front of every number
  kNever,   ///< no sign, nothing is negative
};

/// How one line is written. The default is `+01.2345` CR in millimetres: 9 bytes, 0.1 um a count.
struct StreamFormat {
  SignRule sign = SignRule::kAlways;
  int whole_digits = 2;
  int decimals = 4;      ///< 0: no point; whole_digits + decimals is 1 to 9
  double unit_m = 1e-3;  ///< metres of one unit of the printed number
  Delimiter delimiter = Delimiter::kCr;
  int counter_digits = 0;  ///< of a number in front that counts the lines, 1 to 9; 0: there is none
  char separator = ',';    ///< between that number and the value
};

/// Reads `PICTURE,UNIT,DELIMITER`, e.g. `+00.0000,mm,CR` (the default) or `+000000,0.1um,CRLF`.
///
/// PICTURE draws the number with zeros: a leading + where a sign is always sent, the point where it
/// stands. In front of it may stand the zeros of a line counter and what separates the two (comma,
/// semicolon, colon, blank or tab): `000,+00.0000,mm,CR`. UNIT is the length of one unit of the
/// printed number. Errors: Cause::kUsage.
[[nodiscard]] Result<StreamFormat> ParseStreamFormat(std::string_view text);

/// What an emulated head is asked, and the line by which it owns up. Real heads are not asked: only
/// a virtual terminal or a socket is.
inline constexpr std::string_view kIdentityRequest = "?\r";
inline constexpr std::string_view kEmulatedIdentity = "EMULATED";

/// Numbers that a line's counter goes through before it begins again at 0: 10^counter_digits; 1
/// where there is no counter.
[[nodiscard]] std::int32_t CounterTurn(const StreamFormat& format);

/// Characters of a line without its delimiter (8 by default).
[[nodiscard]] std::size_t LineWidth(const StreamFormat& format);
/// Characters of a line with its delimiter (9 by default).
[[nodiscard]] std::size_t LineBytes(const StreamFormat& format);
/// Metres of one count: unit_m / 10^decimals.
[[nodiscard]] double MetresPerCount(const StreamFormat& format);
/// Largest number of counts that fits: 10^(digits) - 1.
[[nodiscard]] std::int32_t MostCounts(const StreamFormat& format);
/// Lines that the wire carries in a second: baud / (10 x LineBytes): 10 240 at 921600 baud.
[[nodiscard]] double MostLinesPerSecond(const StreamFormat& format, int baud);

/// Reads one line without its delimiter; nothing unless it has exactly the drawn width and form.
///
/// In place of a number: sign and F's (`+FFFFFFF`, without a sign rule all F) -> kOver, `-FFFFFFF`
/// -> kUnder; all X or all `-` -> kInvalid (the spelling of Keyence LK-G3001, user's manual,
/// RS-232C chapter). The number of all nines, `+99.9999` -> kOver, `-99.9999` -> kUnder (the
/// spelling of Keyence DL-RS1A; no line can hold more), with its counts.
[[nodiscard]] std::optional<Value> ParseStreamLine(const StreamFormat& format,
                                                   std::string_view line);

/// The line counter of a line that ParseStreamLine reads; the format has one.
[[nodiscard]] std::int32_t LineCount(const StreamFormat& format, std::string_view line);

/// The line for `value`, with its delimiter; `number` counts the lines from 0 on, and is sent where
/// the format has a counter. kOver, kUnder: F's; any other status that is no
/// measurement: X's. Counts that do not fit the picture are written as over or under.
[[nodiscard]] std::string FormatStreamLine(const StreamFormat& format, const Value& value,
                                           std::int64_t number = 0);

}  // namespace haptometer::acquire
