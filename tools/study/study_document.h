#pragma once

#include <string>
#include <vector>

#include "tools/document/document.h"
#include "tools/plot/gnuplot.h"
#include "tools/study/linearity.h"
#include "tools/study/matching.h"
#include "tools/study/study_result.h"

/// What `study`, `study matching` and `study linearity` show (docs/reference/study.md).
namespace haptometer::tools {

// The answers as documents, with their figures where these are asked for.
[[nodiscard]] document::Document StudyDocument(const StudyResult& study, bool has_figures);
[[nodiscard]] document::Document MatchingDocument(const MatchingResult& result, bool has_figures);
[[nodiscard]] document::Document LinearityDocument(const LinearityResult& result, bool has_figures);

/// What the trials with a value have of their own: how their analysis differs from what was asked,
/// missing repeats, outliers.
[[nodiscard]] StudyFindings ExceptionsOf(const StudyResult& study);

/// Why a trial has no value, a sentence each.
[[nodiscard]] std::vector<std::string> ReasonsOf(const StudyTrial& trial);

/// A row a trial, in the order of the files.
[[nodiscard]] document::Section LongTable(const StudyResult& study);
/// A row a subject: mean, and number of trials, of each condition.
[[nodiscard]] document::Section WideTable(const StudyResult& study);

/// The paragraph for the paper: what was measured, excluded, tested and corrected, with every trial
/// that differs from it and the provenance.
[[nodiscard]] std::string MethodsText(const StudyResult& study,
                                      const document::Provenance& provenance);

/// Bars of the conditions' means with standard deviations over subjects, the subjects as points: a
/// panel a contrast.
[[nodiscard]] std::vector<plot::Panel> StudyPanels(const StudyResult& study);
/// Matched against reference voltage, mean and standard deviation over subjects, a panel a
/// condition.
[[nodiscard]] std::vector<plot::Panel> MatchingPanels(const MatchingResult& result);
/// RMS against drive with the fitted lines, one panel.
[[nodiscard]] std::vector<plot::Panel> LinearityPanels(const LinearityResult& result);

}  // namespace haptometer::tools
