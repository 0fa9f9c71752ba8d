#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "acquire/protocol/keyence/dl_line.h"
#include "acquire/protocol/wire.h"
#include "base/clock.h"

/// The Keyence DL-RS1A (RS-232C unit of the IL series): ASCII lines, one command at a time. Pure
/// functions between lines and meanings, both directions; no time, no port.
///
/// Source: Keyence, DL-RS1A User's Manual, IL Edition (96081E), p. 13-14 for values and data
/// numbers; GT-70A Edition, p. 15, for the error numbers, which the editions share.
namespace haptometer::acquire::dl_rs1a {

/// The only rates of the unit; the first is the factory setting.
inline constexpr std::array<int, 5> kBauds = {9600, 2400, 4800, 19200, 38400};
/// Identification numbers run from 00 (main amplifier) to 14.
inline constexpr std::size_t kMostUnits = dl::kMostUnits;
/// Counts of the display's five digits that mean above the range; below it: the same, negative.
inline constexpr std::int32_t kMostCounts = 99'999;
/// Characters of the longest legal line: MS with two-digit outputs of 15 amplifiers.
inline constexpr std::size_t kLongestLine = 2 + kMostUnits * 11;
/// Processing of M0 and MS between the request's last and the reply's first character, at most.
inline constexpr MonotonicNs kProcessingNs = 4'000'000;
/// How often the unit refreshes the values that M0 reads, with one amplifier.
inline constexpr MonotonicNs kRefreshNs = 7'000'000;

/// Data numbers of the IL series used here (IL Edition, p. 13; the DL-EN1's are the same).
inline constexpr int kZeroShift = 1;  ///< writing 0, then 1, shifts the zero to where it is now
inline constexpr int kZeroShiftReset = 2;
inline constexpr int kErrorFlags = 33;
inline constexpr int kOutputs = 36;
inline constexpr int kPresentValue = 37;  ///< what M0 gives
inline constexpr int kRawValue = 38;
inline constexpr int kPeak = 39;
inline constexpr int kBottom = 40;
inline constexpr int kAnalogOutput = 42;
inline constexpr int kZeroShiftResult = 54;  ///< 0 busy, 1 done, 2 failed
inline constexpr int kBank = 98;
inline constexpr int kSamplingCycle = 132;
inline constexpr int kAveraging = 133;
inline constexpr int kHold = 136;
inline constexpr int kZeroShiftMemory = 152;
inline constexpr int kHighPassCutoff = 159;
inline constexpr int kProductCode = 193;
inline constexpr int kConnectedHead = 195;
inline constexpr int kProductName = 200;

/// Error numbers of `ER`.
inline constexpr int kInvalidCommand = 0;
inline constexpr int kDataLength = 20;
inline constexpr int kParameterCount = 21;
inline constexpr int kParameter = 22;
inline constexpr int kCommunication = 29;
inline constexpr int kUnitNumber = 65;
inline constexpr int kExpansionLine = 66;
inline constexpr int kWriteControl = 67;

/// What an error number means, in words a user can act on; "unknown error" for others.
[[nodiscard]] std::string_view ErrorText(int number);

// --- values ---

/// Reads the 7 characters of a value: `-00.007`, `+018.25`, `+0123.4`.
///
/// Strings that are no measurement get a status: any E -> kDeviceError; +99999 digits -> kOver;
/// -99999 -> kUnder; -99998 -> kInvalid. Nothing is returned when the characters are not sign,
/// digits and one point in 7 characters.
[[nodiscard]] std::optional<Value> ParseValue(std::string_view text);

/// The inverse of ParseValue: the status decides first, then counts and decimals (1 to 3).
/// Counts beyond 5 digits are a programmer's error.
[[nodiscard]] std::string FormatValue(const Value& value);

/// The analog output in the error state and for an invalid value: no measurement (IL Edition, p.
/// 14).
inline constexpr int kAnalogErrorMv = 5500;
/// Reads the analog output of data 042, in mV: `+1.234`; nothing for other text, as for the 5
/// characters of a current output (`12.00`).
[[nodiscard]] std::optional<int> ParseAnalogMv(std::string_view text);
/// The inverse of ParseAnalogMv; |mv| <= 9999.
[[nodiscard]] std::string FormatAnalogMv(int mv);

/// How this unit spells the lines that it shares with the DL-EN1.
[[nodiscard]] const dl::Spelling& Spelling();

// --- what the numbers of SR mean ---

/// A sensor head of the IL series.
struct Head {
  int code = 0;             ///< data 195
  std::string_view name;    ///< "IL-030"
  int decimals = 0;         ///< of a value in mm
  double reference_mm = 0;  ///< distance at value 0
  double nearest_mm = 0;    ///< measuring range as distances; 0 where the data sheet is not at hand
  double farthest_mm = 0;
  double linear_half_range_mm = 0;  ///< linear within +- this of reference_mm; 0 as above
};

/// The head with code `code` of data 195, or nullptr.
[[nodiscard]] const Head* FindHead(int code);
/// The head called `name` ("IL-030"), or nullptr.
[[nodiscard]] const Head* FindHead(std::string_view name);

/// Sampling periods of an IL amplifier in s, by the codes 1 to 4 of data 132, the fastest first.
inline constexpr std::array<double, 4> kSamplings_s = {0.33e-3, 1e-3, 2e-3, 5e-3};
/// That of code 0, "default".
inline constexpr double kDefaultSampling_s = 1e-3;

/// Sampling period in s of data 132 (1..4); nothing for 0, "default", and for other codes.
[[nodiscard]] std::optional<double> SamplingSeconds(int code);
/// Averages of data 133 (0..12 -> 1..4096); nothing for the filters 13 and 14 and for other codes.
[[nodiscard]] std::optional<int> Averages(int code);
/// The codes that the two above belong to: the code whose period is within 1 ns of `sampling_s`,
/// the one that averages `averages`; nothing where there is none.
[[nodiscard]] std::optional<int> SamplingCode(double sampling_s);
[[nodiscard]] std::optional<int> AveragingCode(int averages);
/// Codes of data 133 beyond the averages.
inline constexpr int kDifferenceFilter = 13;
inline constexpr int kHighPassFilter = 14;
/// Name of data 136: "sample", "peak", "bottom", "peak-to-peak", "auto peak", "auto bottom"; "" for
/// other codes.
[[nodiscard]] std::string_view HoldName(int code);
/// High-pass corner in Hz of data 159 (0..9).
[[nodiscard]] std::optional<double> HighPassHz(int code);

// --- what the wire allows ---

/// Time of one exchange of M0 or MS in ns: request, processing, reply, at 10 bits a character.
///
/// 4 characters out, 4 ms, 4 + 8 n characters back (MS: 4 + 11 n): 8.17 ms at 38400 baud with one
/// amplifier.
[[nodiscard]] MonotonicNs PollPeriodNs(int baud, std::size_t units,
                                       dl::Command command = dl::Command::kM0);

/// What request and reply of M0 or MS need on the wire at least, in ns: no reply comes sooner. The
/// outputs of MS have one digit in some editions.
[[nodiscard]] MonotonicNs LeastExchangeNs(int baud, std::size_t units,
                                          dl::Command command = dl::Command::kM0);

/// How often the unit refreshes the values that M0 reads, in ns: 7, 9, 13, 15, 19, 21, 25, 27 ms
/// with 1 to 8 amplifiers (IB and GT-70A Editions, as the longest time; the figure for IL was not
/// at hand), 27 ms beyond.
[[nodiscard]] MonotonicNs RefreshNs(std::size_t units);

}  // namespace haptometer::acquire::dl_rs1a
