#include "tools/acquire/check/check_output.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "dsp/analysis/band_analysis.h"
#include "tools/cli/json.h"

namespace haptometer::tools {
namespace {

using nlohmann::ordered_json;

std::string_view Mark(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kFix:
      return "FIX";
    case Verdict::kUnknown:
      return "?";
  }
  return "";
}

ordered_json ItemJson(const CheckItem& item) {
  return {{"name", item.name},
          {"verdict", Name(item.verdict)},
          {"finding", item.finding},
          {"remedy", cli::TextOrNull(item.remedy)}};
}

}  // namespace

std::string CheckText(const std::vector<CheckItem>& items) {
  std::string text;
  for (const CheckItem& item : items) {
    text += fmt::format("  {:<4} {:<10} {}\n", Mark(item.verdict), item.name, item.finding);
    if (!item.remedy.empty()) text += fmt::format("{:17}-> {}\n", "", item.remedy);
  }
  const auto fixes = std::ranges::count(items, Verdict::kFix, &CheckItem::verdict);
  return text + (fixes == 0 ? "ready\n" : fmt::format("not ready: {} to fix\n", fixes));
}

std::string CheckJson(const trial::TrialHeader& header, const CheckFindings& findings,
                      const CheckQuestion& question, const std::vector<CheckItem>& items) {
  ordered_json list = ordered_json::array();
  for (const CheckItem& item : items) list.push_back(ItemJson(item));
  ordered_json gains = ordered_json::array();
  for (const ToneGain& tone : AveragingGains(header.metadata, question.band)) {
    gains.push_back({{"frequency_hz", tone.frequency_hz}, {"gain", tone.gain}});
  }
  const acquire::RecordingSummary& summary = findings.summary;
  const ordered_json document{
      {"ready", IsReady(items)},
      {"sensor", header.metadata.sensor},
      {"source", header.metadata.source},
      {"band", {{"lower_hz", question.band.lower_hz}, {"upper_hz", question.band.upper_hz}}},
      {"items", list},
      {"readings", summary.readings},
      {"bad", summary.bad()},
      {"repeated", summary.repeated()},
      {"gaps", summary.gaps},
      {"duration_s", findings.duration_s},
      {"new_readings_per_s", findings.fresh_rate_hz},
      {"observable_upper_hz", findings.fresh_rate_hz / dsp::kLeastRatePerUpperCorner},
      {"jitter_s", cli::NumberOrNull(summary.interval_sd_s)},
      {"time_uncertainty_s", findings.time_uncertainty_s},
      {"level_m", cli::NumberOrNull(findings.level_m)},
      {"least_m", cli::NumberOrNull(findings.least_m)},
      {"greatest_m", cli::NumberOrNull(findings.greatest_m)},
      {"averaging_gains", gains.empty() ? ordered_json(nullptr) : gains},
      {"noise_rms_m", cli::NumberOrNull(findings.noise_m)},
      {"smallest_rms_10_percent_m", cli::NumberOrNull(SmallestRmsOf(findings, question.band, 0.1))},
      {"smallest_rms_1_percent_m", cli::NumberOrNull(SmallestRmsOf(findings, question.band, 0.01))},
      {"tone_frequency_hz", cli::NumberOrNull(findings.tone_hz)},
      {"tone_rms_m", cli::NumberOrNull(findings.tone_rms_m)}};
  return cli::JsonText(document);
}

}  // namespace haptometer::tools
