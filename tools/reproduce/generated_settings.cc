#include "tools/reproduce/generated_settings.h"

#include <fmt/core.h>

#include <cmath>
#include <random>

#include "tools/reproduce/generated_trials.h"

namespace haptometer::tools {
namespace {

constexpr double kSettingsBetweenSubjects = 0.10;
constexpr double kBetweenSettings = 0.03;
constexpr double kStartBias = 1.05;

}  // namespace

TextTable GenerateSettings(const std::vector<GeneratedMatch>& matches, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> between_settings(0, kBetweenSettings);
  TextTable table;
  table.name = "generated settings";
  const auto add = [&](const std::string& column, std::string cell) {
    table.columns[column].push_back(std::move(cell));
  };
  for (const GeneratedMatch& match : matches) {
    for (const auto& [level_v, ratio] : match.ratio_at_v) {
      const auto own = CentredDeviates(random, kGeneratedSubjects, kSettingsBetweenSubjects);
      for (std::size_t s = 0; s < own.size(); ++s) {
        for (const bool high : {true, false}) {
          const double bias = (high ? 1 : -1) * std::log(kStartBias);
          const double log = std::log(ratio) + own[s] + bias + between_settings(random);
          add("reference_v", fmt::format("{:g}", level_v));
          add("condition", match.condition);
          add("subject", fmt::format("s{}", s + 1));
          add("matched_v", fmt::format("{:.3f}", level_v * std::exp(log)));
          add("started", high ? "high" : "low");
          table.lines.push_back(table.lines.size() + 1);
        }
      }
    }
  }
  return table;
}

}  // namespace haptometer::tools
