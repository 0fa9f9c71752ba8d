#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acquire/protocol/wire.h"

/// The RS-232C of Keyence's LK-G3001 controller: ASCII lines that end with CR both ways, one
/// command at a time, upper or lower case. Pure functions between lines and meanings.
///
/// Source: Keyence, LK-G Series User's Manual, p. 5-5 (commands, errors), 5-6 (values), 5-24
/// (output of its own accord). `M0` for both outputs is not in the pages at hand.
namespace haptometer::acquire::lkg {

inline constexpr char kLineEnd = '\r';
/// OUT1 and OUT2.
inline constexpr std::size_t kMostOuts = 2;
/// Characters of the longest legal line: `M0,+01.2345,+01.2345`.
inline constexpr std::size_t kLongestLine = 20;

enum class Command : std::uint8_t {
  kM0,  ///< value of both outputs
  kM1,  ///< value of OUT1
  kM2,  ///< value of OUT2
  kQ0,  ///< to communication mode: settings can be changed, nothing is measured
  kR0,  ///< to normal mode
};

/// "M0", "M1", ...
[[nodiscard]] std::string_view Name(Command command);
/// How many values its reply has: 2, 1, 1, 0, 0.
[[nodiscard]] std::size_t ValuesOf(Command command);

/// Error numbers of `ER`.
inline constexpr int kInvalidCommand = 0;
inline constexpr int kStatus = 1;
inline constexpr int kCommandLength = 20;
inline constexpr int kParameterCount = 21;
inline constexpr int kParameter = 22;
inline constexpr int kTimeout = 88;
inline constexpr int kOther = 99;

/// What an error number means, in words a user can act on; "unknown error" for others.
[[nodiscard]] std::string_view ErrorText(int number);

/// Reads the 8 characters of a value: sign and seven digits, of which one may be a point (where it
/// stands, and whether it does, is a setting): `+01.2345`, `-00001.2`.
///
/// `XXXXXXXX` and `--------` -> kInvalid; `+FFFFFFF` -> kOver; `-FFFFFFF` -> kUnder.
[[nodiscard]] std::optional<Value> ParseValue(std::string_view text);

/// The inverse of ParseValue: the status decides first, then counts and decimals (0 to 5). Counts
/// that do not fit are a programmer's error.
[[nodiscard]] std::string FormatValue(const Value& value);

/// The controller's side: reads a line (without its end); nothing for a line that is no command.
[[nodiscard]] std::optional<Command> ParseRequest(std::string_view line);

/// `M1\r`.
[[nodiscard]] std::string FormatRequest(Command command);

enum class ReplyKind : std::uint8_t {
  kCommand,  ///< the command's own reply
  kOutput,   ///< `G1,+01.2345`: sent at the timing input, asked by nobody
  kError,
};

/// A reply; views point into the parsed line.
struct Reply {
  ReplyKind kind = ReplyKind::kCommand;
  Command command = Command::kM1;         ///< kCommand
  std::size_t outs = 0;                   ///< how many values
  std::array<Value, kMostOuts> values{};  ///< M0: OUT1, OUT2
  int error = 0;                          ///< kError
  std::string_view refused{};             ///< kError: the command, as the controller repeats it
};

/// Reads one line (without its end); nothing when it is not a reply of this controller.
[[nodiscard]] std::optional<Reply> ParseReply(std::string_view line);

/// `M1,+01.2345\r`, `Q0\r`.
[[nodiscard]] std::string FormatReply(Command command, std::span<const Value> values);
/// `ER,M1,01\r`.
[[nodiscard]] std::string FormatErrorReply(std::string_view command, int number);

/// Whether `reply` answers `command`: by its own reply or by an error that names it. Half a command
/// that somebody else left in the controller may stand before its name (`ER,SM1,00`).
[[nodiscard]] bool Answers(const Reply& reply, Command command);

}  // namespace haptometer::acquire::lkg
