#pragma once

#include <algorithm>
#include <string_view>
#include <variant>
#include <vector>

#include "fit/findings.h"

namespace haptometer::tests {

/// The kinds of the findings of a severity, in their order.
inline std::vector<fit::FindingKind> KindsOf(const fit::Findings& findings, Severity severity) {
  std::vector<fit::FindingKind> kinds;
  for (const fit::Finding& finding : findings.list()) {
    if (finding.severity == severity) kinds.push_back(finding.kind);
  }
  return kinds;
}

inline std::vector<fit::FindingKind> DoubtsOf(const fit::Findings& findings) {
  return KindsOf(findings, Severity::kDoubt);
}

/// A number of the first finding of a kind; T{} where there is none.
template <typename T = double>
T NumberOf(const fit::Findings& findings, fit::FindingKind kind, std::string_view name) {
  const auto found = std::ranges::find(findings.list(), kind, &fit::Finding::kind);
  if (found == findings.list().end()) return T{};
  const auto number = std::ranges::find(found->numbers, name, &FindingNumber::name);
  const T* value = number == found->numbers.end() ? nullptr : std::get_if<T>(&number->value);
  return value == nullptr ? T{} : *value;
}

}  // namespace haptometer::tests
