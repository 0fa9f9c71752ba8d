#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/line_framer.h"
#include "trial/calibration.h"
#include "trial/trial_format.h"

/// Samples of several channels as a program writes them to a pipe: pure functions of the bytes.
namespace haptometer::acquire {

/// How a row of samples is written.
enum class SampleFormat : std::uint8_t {
  kF64,   ///< little-endian IEEE 754 doubles, one a channel, without anything between
  kF32,   ///< the same with floats
  kI16,   ///< little-endian two's complement counts
  kText,  ///< one row a line: numbers with a blank, a tab, a comma or a semicolon between
};

/// "f64", "f32", "i16", "text".
[[nodiscard]] std::string_view Name(SampleFormat format);
[[nodiscard]] std::optional<SampleFormat> SampleFormatFromName(std::string_view name);
/// How a trial keeps such samples bit for bit: f64, f32; counts as i32; text as f64.
[[nodiscard]] trial::Encoding EncodingOf(SampleFormat format);

/// What SampleParser::Next() found.
enum class RowState : std::uint8_t {
  kRow,       ///< a row; its samples carry their statuses
  kBadRow,    ///< a line that is no row: all samples are kBadFrame
  kNeedMore,  ///< no whole row in the bytes fed so far
};

/// Cuts bytes into rows, however they were split on their way.
///
/// Binary rows have no marks between them, so a lost byte shifts all that follow: a pipe loses
/// none. In text, blanks around the numbers and empty lines are passed over, and a line with
/// another count of numbers, or with anything that is no number, is a bad row. A NaN or an infinity
/// is kInvalid; the limits give kClipped and kInvalid (trial::StatusOf). No allocation once the
/// buffer has grown to the largest feed.
class SampleParser {
 public:
  /// `limits`: one a channel, of the numbers as they come.
  SampleParser(SampleFormat format, std::vector<trial::RawLimits> limits);

  /// Appends bytes. Call Next() until it says kNeedMore before feeding again.
  void Feed(std::string_view bytes);

  /// The next row into `row`, one sample a channel.
  [[nodiscard]] RowState Next(std::span<trial::Sample> row);

  /// The text line of the last row, valid until the next Feed(); empty for binary rows.
  [[nodiscard]] std::string_view line() const { return line_; }
  /// Whether line() is a row where its commas are decimal signs: "1,5;2,5", and "1,5" of one
  /// channel.
  [[nodiscard]] bool IsRowWithDecimalCommas() const;
  /// Bytes of a row that is not whole yet.
  [[nodiscard]] std::size_t waiting_bytes() const;
  /// Bytes of the bad rows so far.
  [[nodiscard]] std::uint64_t discarded_bytes() const {
    return discarded_bytes_ + framer_.discarded_bytes();
  }

 private:
  RowState NextBinary(std::span<trial::Sample> row);
  RowState NextLine(std::span<trial::Sample> row);
  bool ReadLine(std::string_view line, std::span<trial::Sample> row) const;

  SampleFormat format_;
  std::vector<trial::RawLimits> limits_;
  LineFramer framer_;          ///< kText
  std::string buffer_;         ///< binary: what is left of the last feed, and what came since
  std::size_t row_begin_ = 0;  ///< in buffer_
  std::string_view line_;
  std::uint64_t discarded_bytes_ = 0;
};

}  // namespace haptometer::acquire
