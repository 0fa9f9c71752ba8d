#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace haptometer::tools {

/// The unit that a number is printed in: 1 `name` = `si` `si_name`.
struct ThesisUnit {
  std::string_view name;
  std::string_view si_name;
  double si = 1;
};

/// What the thesis says of a quantity.
enum class Relation : std::uint8_t {
  kEquals,      ///< a value, true to half a unit of its last digit
  kBelow,       ///< "less than 2 percent", "no later"
  kAbove,       ///< "much longer": more than this
  kNotPrinted,  ///< nothing: ours stands alone
};

/// A quantity of J. Lindsay, "A Mechanical Amplifier for Haptic Feedback", University of
/// Washington, 2013, with what that thesis prints of it.
struct ThesisNumber {
  std::string_view key;    ///< stays: scripts rely on it
  std::string_view group;  ///< of quantities that belong together
  std::string_view where;  ///< "Table 2.3, p. 12"
  std::string_view what;
  Relation relation = Relation::kEquals;
  double value = 0;      ///< in `unit`; of kNotPrinted nothing
  double half_step = 0;  ///< half a unit of the last printed digit, in `unit`
  ThesisUnit unit;
};

/// All of them, in the order of the thesis. Nothing but what is printed stands here; what we get
/// is computed (tools/reproduce/reproduction.h).
[[nodiscard]] std::span<const ThesisNumber> ThesisNumbers();

/// The one of that key, which must exist.
[[nodiscard]] const ThesisNumber& ThesisNumberOf(std::string_view key);

/// Its value in the SI unit.
[[nodiscard]] double SiValue(const ThesisNumber& number);

}  // namespace haptometer::tools
