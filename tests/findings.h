#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <string>
#include <type_traits>
#include <variant>

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

}  // namespace haptometer::tests
