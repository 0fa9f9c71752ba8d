#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {

using Json = nlohmann::json;

// what another processor's mathematical library may change
constexpr double kTolerance = 1e-9;

bool IsSame(const Json& a, const Json& b) {
  if (!a.is_number() || !b.is_number()) return a == b;
  const double x = a.get<double>();
  const double y = b.get<double>();
  return std::abs(x - y) <= kTolerance * std::max(std::abs(x), std::abs(y));
}

// "/contrasts/0/p" of a document's value: whether it is a list or object, whose parts count
bool IsLeaf(const Json& json) { return !json.is_structured() || json.empty(); }

}  // namespace

Result<std::vector<std::string>> CompareDocuments(const std::string& earlier,
                                                  const std::string& now) {
  const Json before = Json::parse(earlier, nullptr, false);
  if (before.is_discarded() || !before.is_object()) {
    return CannotAnswer("", "is no JSON document", "give what study --json printed");
  }
  const Json after = Json::parse(now);
  std::vector<std::string> differences;
  std::vector<std::pair<Json::json_pointer, const Json*>> open{{Json::json_pointer(), &before}};
  while (!open.empty()) {
    const auto [place, value] = open.back();
    open.pop_back();
    if (!after.contains(place)) {
      differences.push_back(fmt::format("{} is gone", place.to_string()));
      continue;
    }
    const Json& other = after.at(place);
    if (IsLeaf(*value)) {
      if (IsSame(*value, other)) continue;
      differences.push_back(
          fmt::format("{} was {}, is {}", place.to_string(), value->dump(), other.dump()));
    } else if (value->is_array()) {
      if (other.is_array() && other.size() > value->size()) {
        differences.push_back(fmt::format("{} had {} entries, has {}", place.to_string(),
                                          value->size(), other.size()));
      }
      for (std::size_t i = value->size(); i > 0; --i)
        open.emplace_back(place / (i - 1), &(*value)[i - 1]);
    } else {
      for (const auto& [key, part] : value->items()) open.emplace_back(place / key, &part);
    }
  }
  return differences;
}

}  // namespace haptometer::tools
