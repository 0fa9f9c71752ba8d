#pragma once

#include <string_view>

#include "base/quantity.h"
#include "base/toml.h"

namespace haptometer::sim {

/// Refuses a number that no actuator, adapter or skin of this kind has: outside 1e-9 to 1e9 in SI
/// units the arithmetic, not the mechanics, would be under test.
void RefuseUnlessReal(TomlTable& table, std::string_view key, double value);

/// The number under a key that must be there, greater than 0 and real in the sense above.
[[nodiscard]] double Positive(TomlTable& table, std::string_view key, Dimension dimension);

/// The same where 0 is a value too.
[[nodiscard]] double NotNegative(TomlTable& table, std::string_view key, Dimension dimension);

/// The number of either sign under a key that may be absent, which is 0.
[[nodiscard]] double Signed(TomlTable& table, std::string_view key, Dimension dimension);

/// NotNegative where the key is present, `absent` where it is not.
[[nodiscard]] double NotNegativeOr(TomlTable& table, std::string_view key, Dimension dimension,
                                   double absent);

}  // namespace haptometer::sim
