#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/protocol/keyence/dl_line.h"
#include "acquire/protocol/wire.h"
#include "base/clock.h"

/// The Keyence DL-EN1 (Ethernet unit of the IL series): the lines of protocol/keyence/dl_line.h
/// over TCP, with values that have no point and error numbers of three digits. Data numbers and
/// their codes are those of the amplifiers (protocol/keyence/dl_rs1a.h).
///
/// Source: Keyence, DL-EN1 User's Manual (633GB), chapters 5 (socket communication) and 6 (data
/// numbers of the IL series).
namespace haptometer::acquire::dl_en1 {

/// The port as delivered; 8500 is the unit's own.
inline constexpr int kPort = 64000;
/// The unit itself is number 00; the amplifiers follow.
inline constexpr int kFirstUnit = 1;
/// Characters of the longest legal line: MS of 15 amplifiers.
inline constexpr std::size_t kLongestLine = 2 + dl::kMostUnits * 14;
/// How often the unit has fresh values with one amplifier.
inline constexpr MonotonicNs kRefreshNs = 7'800'000;

/// Error numbers of `ER`.
inline constexpr int kOutOfRange = 9;
inline constexpr int kNotExecutable = 12;
inline constexpr int kWriteProtected = 14;
inline constexpr int kReadProtected = 16;
inline constexpr int kDataNumber = 20;
inline constexpr int kUnitNumber = 22;
inline constexpr int kMode = 31;
inline constexpr int kStarting = 254;
inline constexpr int kFormat = 255;

/// `host` with the unit's port where it names none: "192.168.0.10" -> "192.168.0.10:64000", "::1"
/// -> "[::1]:64000". A path is left alone.
[[nodiscard]] std::string WithPort(std::string_view host);

/// What an error number means, in words a user can act on; "unknown error" for others.
[[nodiscard]] std::string_view ErrorText(int number);

/// Reads the 10 characters of a value: sign and nine digits, `+000012345`. The decimals are 0: they
/// are told by FR.
///
/// The unit's own values that are no measurement get a status: +099999999 -> kOver, -099999999 ->
/// kUnder, -099999998 -> kInvalid, +100000000 -> kDeviceError.
[[nodiscard]] std::optional<Value> ParseValue(std::string_view text);

/// The inverse of ParseValue: the status decides first, then the counts (at most nine digits).
[[nodiscard]] std::string FormatValue(const Value& value);

/// `value` of an IL amplifier, whose five digits have special values of their own: 99999 -> kOver,
/// -99999 -> kUnder, -99998 -> kInvalid, 100000 -> kDeviceError.
///
/// The manual gives these for SR and the unit's own for M0; since no IL amplifier shows 99999 as a
/// measurement, M0 is read by both where the head is known to be one of the IL series.
[[nodiscard]] Value WithIlSpecials(Value value);

/// The inverse of both: the status decides first, by an IL amplifier's special values.
[[nodiscard]] std::string FormatIlValue(const Value& value);

/// Sign and nine digits, as SR, SW and FR carry numbers; |number| < 10^9.
[[nodiscard]] std::string FormatNumber(std::int32_t number);

/// How this unit spells the lines that it shares with the DL-RS1A.
[[nodiscard]] const dl::Spelling& Spelling();

/// How often the unit has fresh values, in ns ("data processing time"): 7.8, 9.8, 13.8, 15.8, 19.8,
/// 21.8, 25.8, 27.8 ms with 1 to 8 amplifiers and no calculation, 27.8 ms beyond.
[[nodiscard]] MonotonicNs RefreshNs(std::size_t units);

}  // namespace haptometer::acquire::dl_en1
