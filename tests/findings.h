#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/finding.h"

namespace haptometer::tests {

/// "rate_hz=1000 unit=V": the numbers of a finding, to six digits.
template <typename Kind>
std::string NumbersOf(const FindingOf<Kind>& finding) {
  std::string text;
  for (const FindingNumber& number : finding.numbers) {
    text += fmt::format("{}{}=", text.empty() ? "" : " ", number.name);
    std::visit(
        [&](const auto& value) {
          if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
            text += fmt::format("{:.6g}", value);
          } else {
            text += fmt::format("{}", value);
          }
        },
        number.value);
  }
  return text;
}

/// The numbers of the first finding of the kind; "none" where there is none.
template <typename Kind>
std::string NumbersOf(const Findings<Kind>& findings, Kind kind) {
  const auto found = std::ranges::find(findings.list(), kind, &FindingOf<Kind>::kind);
  return found == findings.list().end() ? "none" : NumbersOf(*found);
}

/// The kinds of the findings of a severity, in their order.
template <typename Kind>
std::vector<Kind> KindsOf(const Findings<Kind>& findings, Severity severity) {
  std::vector<Kind> kinds;
  for (const FindingOf<Kind>& finding : findings.list()) {
    if (finding.severity == severity) kinds.push_back(finding.kind);
  }
  return kinds;
}

template <typename Kind>
std::vector<Kind> DoubtsOf(const Findings<Kind>& findings) {
  return KindsOf(findings, Severity::kDoubt);
}

/// A number of the first finding of a kind; T{} where there is none.
template <typename T = double, typename Kind>
T NumberOf(const Findings<Kind>& findings, Kind kind, std::string_view name) {
  const auto found = std::ranges::find(findings.list(), kind, &FindingOf<Kind>::kind);
  if (found == findings.list().end()) return T{};
  const auto number = std::ranges::find(found->numbers, name, &FindingNumber::name);
  const T* value = number == found->numbers.end() ? nullptr : std::get_if<T>(&number->value);
  return value == nullptr ? T{} : *value;
}

}  // namespace haptometer::tests
