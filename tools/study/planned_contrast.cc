#include "tools/study/planned_contrast.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "base/text.h"

namespace haptometer::tools {

Result<PlannedContrast> ParseContrast(const std::string& word) {
  const std::size_t colon = word.find(':');
  PlannedContrast contrast{word.substr(0, colon),
                           colon == std::string::npos ? "" : word.substr(colon + 1)};
  if (contrast.treatment.empty() || contrast.control.empty() ||
      contrast.treatment == contrast.control) {
    return Usage("--contrast", fmt::format("'{}' is no pair of conditions", word),
                 "write TREATMENT:CONTROL, as ia1:stock");
  }
  return contrast;
}

Result<std::vector<PlannedContrast>> ParseContrasts(const std::vector<std::string>& words) {
  std::vector<PlannedContrast> contrasts;
  contrasts.reserve(words.size());
  for (const std::string& word : words) {
    auto contrast = ParseContrast(word);
    if (!contrast) return std::unexpected(contrast.error());
    contrasts.push_back(*std::move(contrast));
  }
  return contrasts;
}

std::vector<PlannedContrast> AllAgainstTheFirst(const std::vector<std::string>& conditions) {
  std::vector<PlannedContrast> planned;
  planned.reserve(conditions.size());
  for (std::size_t c = 1; c < conditions.size(); ++c) {
    planned.push_back({conditions[c], conditions[0]});
  }
  return planned;
}

Result<void> CheckConditions(const PlannedContrast& planned,
                             const std::vector<std::string>& conditions) {
  for (const std::string* name : {&planned.treatment, &planned.control}) {
    if (std::ranges::find(conditions, *name) != conditions.end()) continue;
    const std::string nearest = Nearest(*name, conditions);
    return Usage(*name, "is the condition of no trial",
                 nearest.empty() ? fmt::format("the trials have {}", fmt::join(conditions, ", "))
                                 : fmt::format("did you mean {}?", nearest));
  }
  return {};
}

}  // namespace haptometer::tools
