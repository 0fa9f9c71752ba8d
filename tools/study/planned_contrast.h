#pragma once

#include <string>
#include <vector>

#include "base/error.h"

namespace haptometer::tools {

/// What is compared in a planned contrast: the ratio is treatment / control.
struct PlannedContrast {
  std::string treatment;
  std::string control;
};

/// "ia1:stock". Errors (Cause::kUsage): no pair of two names.
[[nodiscard]] Result<PlannedContrast> ParseContrast(const std::string& word);

/// Each as ParseContrast.
[[nodiscard]] Result<std::vector<PlannedContrast>> ParseContrasts(
    const std::vector<std::string>& words);

/// Every condition against the first: what is compared where nothing was planned.
[[nodiscard]] std::vector<PlannedContrast> AllAgainstTheFirst(
    const std::vector<std::string>& conditions);

/// Errors (Cause::kUsage): one of the two is none of `conditions`; with the nearest.
[[nodiscard]] Result<void> CheckConditions(const PlannedContrast& planned,
                                           const std::vector<std::string>& conditions);

}  // namespace haptometer::tools
