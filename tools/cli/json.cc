#include "tools/cli/json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"

namespace haptometer::cli {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

Json NumberOrNull(const std::optional<double>& number) {
  return number ? NumberOrNull(*number) : Json(nullptr);
}

Json CountOrNull(const std::optional<std::uint64_t>& count) {
  return count ? Json(*count) : Json(nullptr);
}

Json TextOrNull(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

std::string JsonText(const Json& document) {
  return PrintableLines(document.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
}

}  // namespace haptometer::cli
