#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "tools/document/render.h"
#include "tools/study/study.h"

// The results of a study against earlier ones.

namespace haptometer::tools {
namespace {

using Json = nlohmann::json;

// relative; last digits differ with the mathematical library of another processor
constexpr double kTolerance = 1e-9;

// keys of earlier versions, and their present names
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kRenamed{
    {{"ratio_interval", "ratio_interval_95"},
     {"mean_difference_interval_m", "mean_difference_interval_95_m"},
     {"effect_interval", "effect_interval_95"},
     {"ratio_of_means_interval", "ratio_of_means_interval_95"},
     {"mean_interval_m", "mean_interval_95_m"},
     {"icc_interval", "icc_interval_95"},
     {"log_slope_interval", "log_slope_per_trial_interval_95"}}};

// text, and the origin of the document: not numbers of the answer
constexpr std::array<std::string_view, 4> kNotCompared{"provenance", "findings", "reasons",
                                                       "deviations"};

// the name of the present version for a key of an earlier one
std::string_view PresentName(const std::string& key) {
  const auto* found = std::ranges::find(kRenamed, key, [](const auto& pair) { return pair.first; });
  return found == kRenamed.end() ? std::string_view(key) : found->second;
}

bool IsSame(const Json& a, const Json& b) {
  // texts, lists and booleans have to be equal, numbers within the tolerance
  if (!a.is_number() || !b.is_number()) return a == b;
  const double x = a.get<double>();
  const double y = b.get<double>();
  // relative to the larger, so that the order of the two does not matter
  return std::abs(x - y) <= kTolerance * std::max(std::abs(x), std::abs(y));
}

// a sentence for each part of `before`, at `place`, that is missing or different in `now`
void Compare(const Json& before, const Json& now, const std::string& place,
             ResultsComparison& compared) {
  std::vector<std::string>& differences = compared.differences;
  if (before.is_object() && now.is_object()) {
    // keys that only the new document has are no difference
    for (const auto& [key, part] : before.items()) {
      if (std::ranges::count(kNotCompared, key) > 0) continue;
      const auto found = now.find(PresentName(key));
      const std::string inner = fmt::format("{}/{}", place, key);
      if (found == now.end()) {
        differences.push_back(inner + " is gone");
      } else {
        Compare(part, *found, inner, compared);
      }
    }
  } else if (before.is_array() && now.is_array()) {
    if (now.size() != before.size()) {
      differences.push_back(
          fmt::format("{} had {} entries, has {}", place, before.size(), now.size()));
    }
    // elements in common are compared even if the lengths differ
    for (std::size_t k = 0; k < std::min(before.size(), now.size()); ++k) {
      Compare(before[k], now[k], fmt::format("{}/{}", place, k), compared);
    }
  } else if (IsSame(before, now)) {
    ++compared.equal;
  } else {
    differences.push_back(fmt::format("{} was {}, is {}", place, before.dump(), now.dump()));
  }
}

}  // namespace

Result<ResultsComparison> CompareResults(std::string_view earlier, const std::string& where,
                                         const document::Document& now) {
  // what is nested deeper than any result is left out, as it may be of any depth
  constexpr int kMostDepth = 32;
  const auto is_kept = [](int depth, Json::parse_event_t /*event*/, const Json& /*part*/) {
    return depth < kMostDepth;
  };
  const Json before = Json::parse(earlier, is_kept, false);
  if (before.is_discarded() || !before.is_object()) {
    return CannotAnswer(where, "is not a JSON document", "give what study --json printed");
  }
  ResultsComparison compared;
  Compare(before, Json::parse(document::JsonOf(now)), "", compared);
  return compared;
}

}  // namespace haptometer::tools
