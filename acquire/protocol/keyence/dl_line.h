#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acquire/protocol/wire.h"

namespace haptometer::acquire {

/// The fields of one line, between its commas: `a,b,,c` -> a, b, "", c. No allocation; the fields
/// point into the line.
class Fields {
 public:
  /// MS of fifteen amplifiers: the command, and two fields for each.
  static constexpr std::size_t kMost = 31;

  explicit Fields(std::string_view line);

  /// Whether the line has more than kMost fields, of which all but the first kMost are dropped.
  [[nodiscard]] bool too_many() const { return too_many_; }
  /// How many there are: at least 1, at most kMost.
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::string_view operator[](std::size_t i) const { return fields_[i]; }
  /// Those behind the first.
  [[nodiscard]] std::span<const std::string_view> Rest() const {
    return std::span(fields_).subspan(1, size_ - 1);
  }

 private:
  std::array<std::string_view, kMost> fields_{};
  std::size_t size_ = 0;
  bool too_many_ = false;
};

}  // namespace haptometer::acquire

/// The lines that Keyence's communication units DL-RS1A (RS-232C) and DL-EN1 (Ethernet) share:
/// commands, their parts and their replies. How a value is spelled, how many digits an error number
/// has and what the numbers are is a Spelling, one for each unit.
///
/// Pure functions; reading a line does not allocate.
namespace haptometer::acquire::dl {

/// Identification numbers run to 14; so many amplifiers fit in a line.
inline constexpr std::size_t kMostUnits = 15;
/// Both units end their lines with CR LF.
inline constexpr std::string_view kLineEnd = "\r\n";

enum class Command : std::uint8_t {
  kM0,  ///< P.V. of all amplifiers
  kMs,  ///< comparator outputs and P.V. of all amplifiers
  kSr,  ///< read a data number
  kSw,  ///< write a data number
  kAw,  ///< write a data number of all amplifiers
  kFr,  ///< decimal places of a data number
};

/// A request as the unit sees it.
struct Request {
  Command command = Command::kM0;
  int unit = 0;             ///< SR, SW, FR: identification number
  int number = 0;           ///< SR, SW, AW, FR: data number
  std::string_view data{};  ///< SW, AW: what to write; points into the parsed line

  friend bool operator==(const Request&, const Request&) = default;
};

/// Why the unit refuses a line: answered as `ER,COMMAND,NUMBER`.
struct Refusal {
  std::string_view command;  ///< as sent, the part before the first comma
  int number = 0;
};

/// Either a request or the refusal it deserves.
struct ParsedRequest {
  std::optional<Request> request;
  Refusal refusal;  ///< meaningful only without a request
};

/// The commands' own replies, in their order, and others.
enum class ReplyKind : std::uint8_t {
  kM0,
  kMs,
  kSr,
  kSw,
  kAw,
  kFr,
  kDr,  ///< MS sent at a hardware trigger: nobody asked
  kError,
};

/// A reply; views point into the parsed line.
struct Reply {
  ReplyKind kind = ReplyKind::kM0;
  std::size_t units = 0;                   ///< M0, MS, DR: how many values
  std::array<Value, kMostUnits> values{};  ///< M0, MS, DR: by place; the first amplifier is 0
  std::array<int, kMostUnits> outputs{};   ///< MS, DR: the comparator's, as the unit codes them
  int unit = 0;                            ///< SR, SW, FR: identification number
  int number = 0;                          ///< SR, SW, AW, FR: data number; ER: error number
  std::string_view data{};                 ///< SR, FR: the data; ER: the refused command
};

/// What differs between the units.
struct Spelling {
  std::optional<Value> (*parse_value)(std::string_view text);
  std::string (*format_value)(const Value& value);
  std::span<const Command> commands;  ///< those that the unit knows
  std::size_t error_digits;           ///< of ER
  int invalid_command;                ///< error numbers of what ParseRequest() refuses
  int parameter_count;
  int parameter;
};

/// "M0", "MS", ...
[[nodiscard]] std::string_view Name(Command command);

/// The unit's side: reads a line (without its end).
[[nodiscard]] ParsedRequest ParseRequest(const Spelling& spelling, std::string_view line);

/// `M0\r\n`, `SR,00,195\r\n`: a request with its end.
[[nodiscard]] std::string FormatRequest(const Request& request);

/// Reads one line (without its end); nothing when it is not a reply of this unit. The outputs of MS
/// may have one digit or two (editions of the manuals differ).
[[nodiscard]] std::optional<Reply> ParseReply(const Spelling& spelling, std::string_view line);

/// `M0,-00.007,+00.018\r\n`.
[[nodiscard]] std::string FormatM0Reply(const Spelling& spelling, std::span<const Value> values);
/// `MS,04,-00.007,...\r\n`; outputs[i] belongs to values[i].
[[nodiscard]] std::string FormatMsReply(const Spelling& spelling, std::span<const int> outputs,
                                        std::span<const Value> values);
/// `SR,00,195,1\r\n` with the data as given (at most 10 characters); FR alike.
[[nodiscard]] std::string FormatDataReply(Command command, int unit, int number,
                                          std::string_view data);
/// `SW,00,132\r\n`, `AW,132\r\n`.
[[nodiscard]] std::string FormatWriteReply(const Request& request);
/// `ER,SR,22\r\n`.
[[nodiscard]] std::string FormatErrorReply(const Spelling& spelling, const Refusal& refusal);

/// The number that SR's data spell: `4`, `+00004`, `-000000001`; nothing for other text.
[[nodiscard]] std::optional<int> NumberOf(std::string_view data);

/// Whether `reply` answers `command`: by its own reply or by an error that names it. Half a command
/// that somebody else left in the unit may stand before its name (`ER,SM0,00`).
[[nodiscard]] bool Answers(const Reply& reply, Command command);

}  // namespace haptometer::acquire::dl
