#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "dsp/findings.h"

namespace haptometer::dsp {

/// The kinds of the refusals, in their order.
inline std::vector<FindingKind> RefusalsIn(const Findings& findings) {
  std::vector<FindingKind> kinds;
  for (const Finding& finding : findings.list()) {
    if (finding.severity == Severity::kRefusal) kinds.push_back(finding.kind);
  }
  return kinds;
}

/// A number of a finding; NaN and a failed expectation where it has none of that name.
inline double NumberOf(const Finding& finding, std::string_view name) {
  for (const FindingNumber& number : finding.numbers) {
    if (number.name != name) continue;
    if (const auto* count = std::get_if<std::int64_t>(&number.value)) {
      return static_cast<double>(*count);
    }
    if (const auto* value = std::get_if<double>(&number.value)) return *value;
  }
  ADD_FAILURE() << "kind " << static_cast<int>(finding.kind) << " has no number " << name;
  return std::numeric_limits<double>::quiet_NaN();
}

/// The first finding of that kind; a failed expectation where there is none.
inline Finding FirstOf(const Findings& findings, FindingKind kind) {
  for (const Finding& finding : findings.list()) {
    if (finding.kind == kind) return finding;
  }
  ADD_FAILURE() << "no finding of kind " << static_cast<int>(kind);
  return {};
}

/// A number of the first finding of that kind.
inline double NumberOf(const Findings& findings, FindingKind kind, std::string_view name) {
  return NumberOf(FirstOf(findings, kind), name);
}

/// A text of a finding; empty where it has none of that name.
inline std::string TextOf(const Finding& finding, std::string_view name) {
  for (const FindingNumber& number : finding.numbers) {
    const auto* text = std::get_if<std::string>(&number.value);
    if (number.name == name && text != nullptr) return *text;
  }
  return {};
}

}  // namespace haptometer::dsp
