// study matching FILE.csv: voltages set until two vibrations felt alike.
#include <fmt/core.h>

#include <string>
#include <vector>

#include "tools/cli/options.h"
#include "tools/cli/report.h"
#include "tools/study/matching_result.h"
#include "tools/study/words.h"

namespace haptometer::tools {
namespace {

constexpr std::string_view kVerb = "study matching";

constexpr cli::VerbText kText{
    .name = kVerb,
    .summary =
        "How much lower a matched voltage is than its reference, level by level, and what "
        "power that saves.",
    .examples = {"haptometer study matching fixtures/matching.csv --contrast ia1:stock",
                 "haptometer study matching settings.csv --plot matching.svg",
                 "haptometer study matching settings.csv --json"}};

// 3 where a condition or contrast cannot be tested at all
int StatusOf(const MatchingResult& result) {
  for (const MatchedCondition& condition : result.conditions) {
    if (!condition.overall.log_ratio.test) return ExitStatus(Cause::kCannotAnswer);
  }
  for (const MatchedContrast& contrast : result.contrasts) {
    if (!contrast.overall || !contrast.overall->log_ratio.test) {
      return ExitStatus(Cause::kCannotAnswer);
    }
  }
  return 0;
}

}  // namespace

int RunStudyMatching(int argc, const char* const* argv) {
  cli::Options options(kText);
  std::string file;
  std::string plot;
  std::vector<std::string> words;
  options.Positional("file", &file, "CSV with reference_v,condition,subject,matched_v,started");
  options.Repeated("--contrast", &words, "TREATMENT:CONTROL",
                   "A planned contrast; may be repeated (default: every condition against the "
                   "first)");
  options.Output("--plot", &plot, "FILE.svg|png|pdf", "Draw matched against reference voltage");
  if (const auto status = options.Parse(argc, argv)) return *status;
  if (!plot.empty()) {
    if (auto drawable = plot::CheckPlotPath(plot); !drawable) {
      return cli::ReportError(kVerb, drawable.error());
    }
  }
  const auto contrasts = ParseContrasts(words);
  if (!contrasts) return cli::ReportError(kVerb, contrasts.error());
  const auto table =
      ReadTextTable(file, {"reference_v", "condition", "subject", "matched_v", "started"});
  if (!table) return cli::ReportError(kVerb, table.error());
  const auto result = AnalyzeMatching(*table, *contrasts);
  if (!result) return cli::ReportError(kVerb, result.error());
  cli::Print(options.json() ? MatchingJson(*result) : MatchingText(*result));
  if (!plot.empty()) {
    if (auto drawn = plot::DrawPanels(plot, MatchingPanels(*result)); !drawn) {
      return cli::ReportError(kVerb, drawn.error());
    }
  }
  return StatusOf(*result);
}

}  // namespace haptometer::tools
