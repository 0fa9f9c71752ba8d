// Figure 2.3: displacement over time from rest.
#include <fmt/core.h>

#include <numbers>

#include "sim/linear/steady_state.h"
#include "tools/reproduce/rise.h"
#include "tools/reproduce/rounded_inputs.h"
#include "tools/reproduce/row_groups.h"

namespace haptometer::tools {
namespace {

constexpr double kEarlyLevelM = 25e-6;
constexpr double kFullPart = 0.9;
constexpr double kErrorsFromS = 25e-3;  // Lindsay 2013, p. 4

double PeakOf(const sim::Scene& scene) {
  return std::numbers::sqrt2 * sim::SolveSteadyState(scene).skin_rms_m;
}

std::optional<double> Over(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return std::nullopt;
  return *a / *b;
}

std::string Judged(const std::optional<double>& full_s) {
  if (!full_s) return "not reached within 1 s";
  return fmt::format(
      "{} the 25 ms from which latency costs errors (p. 4); the first micrometres "
      "come at once",
      *full_s > kErrorsFromS ? "beyond" : "within");
}

double FullTime(const ThesisModel& model) {
  const sim::Scene adapter = WithAdapter(model, kIa2AreaM2);
  return TimeToReach(adapter, kFullPart * PeakOf(adapter)).value_or(1);
}

double StartRatio(const ThesisModel& model) {
  return Over(TimeToReach(WithAdapter(model, kIa2AreaM2), kEarlyLevelM),
              TimeToReach(WithoutAdapter(model, kCaseAreaM2), kEarlyLevelM))
      .value_or(10);
}

}  // namespace

std::vector<ThesisRow> RiseRows(const ThesisModel& model) {
  const sim::Scene direct = WithoutAdapter(model, kCaseAreaM2);
  const sim::Scene cone = WithoutAdapter(model, kSimulatedConeAreaM2);
  const sim::Scene adapter = WithAdapter(model, kIa2AreaM2);
  const auto direct_full_s = TimeToReach(direct, kFullPart * PeakOf(direct));
  const auto adapter_full_s = TimeToReach(adapter, kFullPart * PeakOf(adapter));
  const auto direct_s = TimeToReach(direct, kEarlyLevelM);
  const auto cone_s = TimeToReach(cone, kEarlyLevelM);
  const auto adapter_s = TimeToReach(adapter, kEarlyLevelM);
  const std::string full = direct_full_s
                               ? fmt::format("direct at 90 % after {:.2f} ms", 1e3 * *direct_full_s)
                               : std::string();
  std::vector<ThesisRow> rows{
      {.key = "rise-ratio", .ours = Over(adapter_full_s, direct_full_s), .remark = full},
      {.key = "amplitude-ratio", .ours = PeakOf(adapter) / PeakOf(direct)},
      {.key = "start-ratio",
       .ours = Over(adapter_s, direct_s),
       .remark = "the curves are not the same: the heavier skin side starts later"},
      {.key = "latency-adapter", .ours = adapter_full_s, .remark = Judged(adapter_full_s)},
      {.key = "start-direct", .ours = direct_s},
      {.key = "start-cone", .ours = cone_s},
      {.key = "start-adapter", .ours = adapter_s}};
  ExplainByRounding(model, {{"latency-adapter", FullTime}, {"start-ratio", StartRatio}}, &rows);
  return rows;
}

}  // namespace haptometer::tools
