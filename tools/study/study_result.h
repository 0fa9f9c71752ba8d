#pragma once

#include <string>
#include <vector>

#include "dsp/analysis/band_analysis.h"
#include "tools/plot/gnuplot.h"
#include "tools/study/contrast.h"
#include "tools/study/further_statistics.h"
#include "tools/study/study_quality.h"
#include "tools/study/study_table.h"

namespace haptometer::tools {

/// Everything that a study answers.
struct StudyResult {
  std::string source;  ///< folder or manifest
  dsp::BandQuestion question;
  StudyTable table;
  bool planned = false;  ///< the contrasts were asked for
  std::vector<Contrast> contrasts;
  std::vector<MissingTrials> missing;
  std::vector<Outlying> outlying;
  FurtherStatistics further;
};

/// What people read: conditions, contrasts, what is missing or stands apart; with `all` the rest.
[[nodiscard]] std::string StudyText(const StudyResult& study, bool all);

/// docs/study.md has the schema.
[[nodiscard]] std::string StudyJson(const StudyResult& study);

/// A row a trial, in the order of the files.
[[nodiscard]] std::string LongTable(const StudyResult& study);
/// A row a subject: mean, and number of trials, of each condition.
[[nodiscard]] std::string WideTable(const StudyResult& study);

/// The paragraph for the paper: what was measured, left out, tested and corrected, with every trial
/// that differs from it.
[[nodiscard]] std::string MethodsText(const StudyResult& study);

/// Bars of the conditions' means with standard deviations over subjects, the subjects as points: a
/// panel a contrast.
[[nodiscard]] std::vector<plot::Panel> StudyPanels(const StudyResult& study);

/// What differs between an earlier document and this one, a sentence each: values beyond 1e-9
/// relative, keys that are gone. New keys are no difference. Errors (Cause::kCannotAnswer):
/// `earlier` is no JSON.
[[nodiscard]] Result<std::vector<std::string>> CompareDocuments(const std::string& earlier,
                                                                const std::string& now);

}  // namespace haptometer::tools
