#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "trial/record.h"

namespace haptometer::trial {

/// `text` without blanks at its ends.
[[nodiscard]] std::string_view Trimmed(std::string_view text);

/// `text` in ASCII lower case.
[[nodiscard]] std::string LowerCase(std::string_view text);

/// The whole of `text` as a number; infinities and NaN count as numbers here.
[[nodiscard]] std::optional<double> ReadNumber(std::string_view text);

/// The same with a decimal comma or point.
[[nodiscard]] std::optional<double> ReadNumberWithComma(std::string_view text);

/// What an instrument prints where it has no number: "∞", "inf", "OVER", "OL" are kOver, with a
/// minus (or "UNDER") kUnder; "****" is kClipped, because it says nothing of the sign; "", "nan",
/// "---", Saleae's "X" and a spreadsheet's "#NUM!" are kInvalid. Nothing for any other text.
[[nodiscard]] std::optional<SampleStatus> ReadNoNumber(std::string_view cell);

/// Seconds since midnight of a time on the clock, "12:00:47.056435" or with a decimal comma; a date
/// before it ("5/7/2021  12:00:47.056435", "2021-07-05T12:00:47Z") is passed over. Nothing where
/// `text` is none.
[[nodiscard]] std::optional<double> ReadClock(std::string_view text);

}  // namespace haptometer::trial
