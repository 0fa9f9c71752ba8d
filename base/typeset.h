#pragma once

#include <string>
#include <string_view>

namespace haptometer {

/// `text` with the signs that a page or a drawing has for what a terminal may not: "12 um^2"
/// becomes "12 µm²", "+-3 ohm" "±3 Ω", and a number stays on the line of its unit (U+00A0). A unit
/// is known by the number, bracket or slash before it ("mean / um"). "R^2" becomes "R²"; other
/// words stay as they are. O(n).
[[nodiscard]] std::string Typeset(std::string_view text);

}  // namespace haptometer
