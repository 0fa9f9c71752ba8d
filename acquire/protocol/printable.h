#pragma once

#include <string>
#include <string_view>

namespace haptometer::acquire {

/// The first 24 characters of what came, fit for one line of a message: what is not printable ASCII
/// becomes '?'.
[[nodiscard]] std::string Printable(std::string_view line);

}  // namespace haptometer::acquire
