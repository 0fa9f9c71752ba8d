// What the study code answers on generated trials, settings and readings.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tools/reproduce/generated_study.h"

namespace haptometer::tools {
namespace {

using MaybeNumber = std::optional<double>;

void KeepLeast(MaybeNumber& least, double value) { least = std::min(least.value_or(value), value); }
void KeepMost(MaybeNumber& most, double value) { most = std::max(most.value_or(value), value); }

const Contrast& ContrastOf(const GeneratedStudy& study, std::string_view treatment) {
  return *std::ranges::find_if(study.trials.contrasts, [&](const Contrast& contrast) {
    return contrast.planned.treatment == treatment;
  });
}

const MatchedCondition& MatchOf(const GeneratedStudy& study, std::string_view name) {
  return *std::ranges::find(study.matching.conditions, name, &MatchedCondition::name);
}

ThesisRow FactorRow(std::string_view key, const Contrast& contrast) {
  ThesisRow row{.key = key, .ours = std::nullopt, .generated = true};
  if (!contrast.ratio) return row;
  row.ours = contrast.ratio->ratio;
  row.interval = contrast.ratio->interval;
  if (const auto& test = contrast.difference.test) {
    row.remark = fmt::format(
        "the truth they were made with; {} subjects, t({:g}) = {:.2f}, p = "
        "{:.2g}",
        contrast.difference.n, test->df, test->t, test->p);
  }
  return row;
}

ThesisRow FactorPRow(const GeneratedStudy& study) {
  MaybeNumber largest;
  for (const Contrast& contrast : study.trials.contrasts) {
    if (contrast.difference.test) KeepMost(largest, contrast.difference.test->p);
  }
  return {.key = "factor-p", .ours = largest, .generated = true};
}

ThesisRow ReductionRow(std::string_view key, const MatchedCondition& condition) {
  ThesisRow row{.key = key, .ours = 1 - condition.overall.ratio(), .generated = true};
  if (const auto ratio = condition.overall.ratio_interval()) {
    row.interval = dsp::Interval{1 - ratio->upper, 1 - ratio->lower};
  }
  row.remark = "the truth they were made with, against the reference voltage";
  return row;
}

// Student's p against a ratio of 1 of one level
MaybeNumber LevelP(const MatchedLevel& level) {
  const auto& test = level.ratio.log_ratio.test;
  return test ? MaybeNumber(test->p) : std::nullopt;
}

std::vector<ThesisRow> LevelRows(const GeneratedStudy& study) {
  MaybeNumber least_at_1v;
  MaybeNumber most_from_2v;
  for (const char* name : {"ia1", "ia2"}) {
    for (const MatchedLevel& level : MatchOf(study, name).levels) {
      const MaybeNumber p = LevelP(level);
      if (!p) continue;
      if (level.ratio.reference_v == 1) {
        KeepLeast(least_at_1v, *p);
      } else {
        KeepMost(most_from_2v, *p);
      }
    }
  }
  MaybeNumber controls;
  for (const char* name : {"stock", "cone"}) {
    if (const auto& test = MatchOf(study, name).overall.log_ratio.test) {
      KeepLeast(controls, test->p);
    }
  }
  return {{.key = "matching-p-at-1v",
           .ours = least_at_1v,
           .remark = "made with a ratio of 1 at 1 V",
           .generated = true},
          {.key = "matching-p-from-2v", .ours = most_from_2v, .generated = true},
          {.key = "matching-p-controls", .ours = controls, .generated = true}};
}

std::vector<ThesisRow> LinearityRows(const GeneratedStudy& study) {
  MaybeNumber p;
  MaybeNumber r_squared;
  std::string slopes;
  for (const DriveLine& line : study.linearity.lines) {
    if (!line.line) continue;
    KeepLeast(r_squared, line.line->r_squared);
    if (line.curvature && line.curvature->p) KeepLeast(p, *line.curvature->p);
    slopes += fmt::format("{}{} skin {:.3f} um/V", slopes.empty() ? "" : ", ", line.subject,
                          1e6 * line.line->slope);
  }
  return {{.key = "linearity-curvature-p", .ours = p, .remark = slopes, .generated = true},
          {.key = "linearity-r-squared",
           .ours = r_squared,
           .remark = "the model is linear: what bends would be the measurement",
           .generated = true}};
}

}  // namespace

std::vector<ThesisRow> StudyRows(const GeneratedStudy& study) {
  std::vector<ThesisRow> rows{FactorRow("factor-ia1", ContrastOf(study, "ia1")),
                              FactorRow("factor-ia2", ContrastOf(study, "ia2")), FactorPRow(study),
                              ReductionRow("matching-ia1", MatchOf(study, "ia1")),
                              ReductionRow("matching-ia2", MatchOf(study, "ia2"))};
  for (const auto& more : {LevelRows(study), LinearityRows(study)}) {
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace haptometer::tools
