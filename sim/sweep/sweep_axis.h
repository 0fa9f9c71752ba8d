#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace haptometer::sim {

/// One value of a scene's key.
struct SweepValue {
  std::string literal;  ///< as a scene holds it, TOML: `225`, `"skin"`, `true`
  std::string text;     ///< as a table shows it: `225`, `skin`, `true`
};

/// A number, with as many digits as give it back exactly.
[[nodiscard]] SweepValue NumberValue(double number);
/// A whole number, `true` or `false`, as written.
[[nodiscard]] SweepValue PlainValue(std::string_view word);
[[nodiscard]] SweepValue TextValue(std::string_view text);

/// How the values of a range lie.
enum class Spacing : std::uint8_t { kLinear, kLogarithmic };

/// Numbers from `begin` to `end`.
struct SweepRange {
  double begin = 0;
  double end = 0;  ///< not `begin`; may be below it. Logarithmic: both above 0
  Spacing spacing = Spacing::kLinear;
  std::size_t count = 0;  ///< of a grid, 2 or more, both ends among them; 0: to be sampled
};

/// The value at `numerator`/`denominator` of the way; the ends are exact, and so are the values
/// between where their products with `denominator` are.
[[nodiscard]] double ValueAt(const SweepRange& range, double numerator, double denominator);

/// A key of a scene and the values that it takes.
struct SweepAxis {
  std::string key;  ///< "drive.frequency_hz"
  std::variant<SweepRange, std::vector<SweepValue>> values;
};

/// How many values a list or a grid has; 0 for a range that is to be sampled.
[[nodiscard]] std::size_t CountOf(const SweepAxis& axis);

/// Value `index` of a list or a grid.
[[nodiscard]] SweepValue ValueOf(const SweepAxis& axis, std::size_t index);

/// The axis in SI as the command line takes it: "100:400:301", "log:1:1000:4", "600,1200".
[[nodiscard]] std::string WordOf(const SweepAxis& axis);

}  // namespace haptometer::sim
