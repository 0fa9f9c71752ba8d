#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "fit/drop_test/drop_test_fit.h"

namespace haptometer::tools {

/// The answer of fit-lra for people: constants with 95 % intervals, what is doubtful, records,
/// inputs, assumptions.
[[nodiscard]] std::string FitLraText(const fit::DropTestFit& fit,
                                     const std::vector<std::string>& doubts);

/// A result and how it is called.
struct NamedValue {
  std::string_view name;
  fit::FittedValue value;
};

/// Kv, Bv, Km, f0, Q, the ratios to the mass and, where it was found, the mass; in the order in
/// which they are told.
[[nodiscard]] std::vector<NamedValue> ValuesOf(const fit::DropTestFit& fit);

/// "open", "33 ohm".
[[nodiscard]] std::string LoadText(double load_ohm);

/// "1.2 mV"; of a displacement "0.1 um".
[[nodiscard]] std::string AmountText(fit::RecordedSignal signal, double value);

/// What is told of a record: its ringing, its residual, what was found in it; at least two lines.
[[nodiscard]] std::vector<std::string> RecordLines(const fit::FittedRecord& record);

/// A given number and what it does: "moving mass 1.4 g", "taken as exact; +1 % of it: Kv +1.000 %".
struct GivenLine {
  std::string what;
  std::string text;
};

/// The given numbers that move a constant.
[[nodiscard]] std::vector<GivenLine> GivenLines(const fit::DropTestFit& fit);

}  // namespace haptometer::tools
