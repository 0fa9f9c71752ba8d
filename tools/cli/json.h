#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace haptometer::cli {

/// What is not known is null: never absent, 0 or NaN. Infinities are null too.
[[nodiscard]] nlohmann::ordered_json NumberOrNull(double number);
[[nodiscard]] nlohmann::ordered_json NumberOrNull(const std::optional<double>& number);
[[nodiscard]] nlohmann::ordered_json CountOrNull(const std::optional<std::uint64_t>& count);
[[nodiscard]] nlohmann::ordered_json TextOrNull(const std::string& text);  ///< empty is null

/// `document` as a verb prints it: indented, with a line end. Names and paths may hold bytes that
/// are no UTF-8; they become U+FFFD. What is not printable stands as its \u escape, so a terminal
/// shows the document as it is.
[[nodiscard]] std::string JsonText(const nlohmann::ordered_json& document);

}  // namespace haptometer::cli
