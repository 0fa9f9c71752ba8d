#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace haptometer::tools {

/// The kinds of an answer's findings, in their order.
inline std::vector<std::string> KindsOf(const nlohmann::json& answer) {
  std::vector<std::string> kinds;
  for (const auto& finding : answer.at("findings")) kinds.push_back(finding.at("kind"));
  return kinds;
}

/// What an answer's findings of a severity say, a line each: "SUBJECT: TEXT".
inline std::string SaidIn(const nlohmann::json& answer, const std::string& severity) {
  std::string lines;
  for (const auto& finding : answer.at("findings")) {
    if (finding.at("severity") != severity) continue;
    const auto& subject = finding.at("subject");
    if (subject.is_string()) lines += subject.get<std::string>() + ": ";
    lines += finding.at("text").get<std::string>() + "\n";
  }
  return lines;
}

}  // namespace haptometer::tools
