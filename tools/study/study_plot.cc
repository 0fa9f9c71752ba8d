#include <fmt/core.h>

#include <algorithm>

#include "tools/study/study_result.h"

namespace haptometer::tools {
namespace {


// the means as bars, their standard deviations over subjects, and each subject as a point
void AppendCondition(const StudyResult& study, std::size_t condition, double x,
                     plot::Panel& panel) {
  const ConditionSummary& summary = study.further.conditions[condition];
  panel.ticks.push_back({x, summary.name});
  if (summary.subjects.n == 0) return;
  const double mean_um = summary.subjects.mean / kUm;
  panel.series.push_back(
      {"", plot::Style{.mark = plot::Mark::kBoxes, .colour = plot::kBlue}, {x}, {mean_um}, {}});
  if (const auto& sd = summary.subjects.standard_deviation) {
    panel.series.push_back({"",
                            plot::Style{plot::Mark::kErrorBars, plot::kBlack, 1.5, 1, 0.7},
                            {x},
                            {mean_um},
                            {*sd / kUm}});
  }
  plot::Series points{"", plot::Points(plot::kOrange, 0.5), {}, {}, {}};
  const auto& cells = study.table.cells;
  for (std::size_t s = 0; s < cells.size(); ++s) {
    const auto mean_m = cells[s][condition].mean_m();
    if (!mean_m) continue;
    // beside each other, in the order of the subjects
    const double share = (static_cast<double>(s) + 0.5) / static_cast<double>(cells.size());
    points.x.push_back(x + 0.3 * (share - 0.5));
    points.y.push_back(*mean_m / kUm);
  }
  panel.series.push_back(std::move(points));
}

plot::Panel EmptyPanel(std::string title) {
  plot::Panel panel;
  panel.title = std::move(title);
  panel.y_label = "RMS displacement / um";
  panel.y_from_zero = true;
  return panel;
}

}  // namespace

std::vector<plot::Panel> StudyPanels(const StudyResult& study) {
  constexpr std::string_view kWhat = "mean and standard deviation over subjects; points: subjects";
  std::vector<plot::Panel> panels;
  for (const Contrast& contrast : study.contrasts) {
    panels.push_back(EmptyPanel(fmt::format("{} against {}: {}", contrast.planned.treatment,
                                            contrast.planned.control, kWhat)));
    double x = 0;
    for (const auto& name : {contrast.planned.control, contrast.planned.treatment}) {
      AppendCondition(study, *study.table.Condition(name), x++, panels.back());
    }
  }
  if (!panels.empty()) return panels;
  panels.push_back(EmptyPanel(std::string(kWhat)));
  for (std::size_t c = 0; c < study.table.conditions.size(); ++c) {
    AppendCondition(study, c, static_cast<double>(c), panels.back());
  }
  return panels;
}

}  // namespace haptometer::tools
