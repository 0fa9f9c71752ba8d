#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dsp/statistics/moments.h"
#include "tools/document/document.h"
#include "tools/document/keys.h"
#include "tools/plot/gnuplot.h"
#include "tools/study/linearity.h"
#include "tools/study/matching.h"
#include "tools/study/study_findings.h"
#include "tools/study/study_table.h"

/// What `study`, `study matching` and `study linearity` show (docs/reference/study.md).
namespace haptometer::tools {

// The answers as documents, with their figures where these are asked for.
[[nodiscard]] document::Document StudyDocument(const StudyResult& study, bool has_figures);
[[nodiscard]] document::Document MatchingDocument(const MatchingResult& result, bool has_figures);
[[nodiscard]] document::Document LinearityDocument(const LinearityResult& result, bool has_figures);

/// What there is to say of the trials and of the contrasts.
[[nodiscard]] StudyFindings FindingsOf(const StudyResult& study);
/// The sources of the answered trials' data.
[[nodiscard]] std::vector<document::DataSource> SourcesOf(const StudyTable& table);

/// What the trials with a value have of their own: how their analysis differs from what was asked,
/// missing repeats, outliers.
[[nodiscard]] StudyFindings ExceptionsOf(const StudyResult& study);

/// Why a trial has no value, a sentence each.
[[nodiscard]] std::vector<std::string> ReasonsOf(const StudyTrial& trial);

/// A row a trial, in the order of the files.
[[nodiscard]] document::Section LongTable(const StudyResult& study);
/// A row a subject: mean, and number of trials, of each condition.
[[nodiscard]] document::Section WideTable(const StudyResult& study);

/// The sentences of that paragraph by what they are of: data, filter, window, corrections,
/// subjects, tests, outliers, program.
[[nodiscard]] std::vector<std::pair<std::string_view, std::string>> MethodsOf(
    const StudyResult& study);

/// The paragraph for the paper: what was measured, excluded, tested and corrected, with every trial
/// that differs from it and the provenance.
[[nodiscard]] std::string MethodsText(const StudyResult& study,
                                      const document::Provenance& provenance);

/// Bars of the conditions' means with standard deviations over subjects, and a line for each
/// subject from control to treatment; then differences and ratios of the contrasts with their 95 %
/// intervals and numbers of subjects. Panels of one quantity have one axis.
[[nodiscard]] std::vector<plot::Panel> StudyPanels(const StudyResult& study);
/// Matched against reference voltage, mean and standard deviation over subjects, a panel a
/// condition.
[[nodiscard]] std::vector<plot::Panel> MatchingPanels(const MatchingResult& result);
/// RMS against drive with the fitted lines, one panel.
[[nodiscard]] std::vector<plot::Panel> LinearityPanels(const LinearityResult& result);

// How the numbers of statistics stand in these documents, and the keys that they share.
inline constexpr document::Key kCondition{"condition", "condition"};
inline constexpr document::Key kRepeat{"repeat", "repeat"};
inline constexpr document::Key kStudy{"study"};
inline constexpr document::Key kTreatment{"treatment"};
inline constexpr document::Key kControl{"control"};
inline constexpr document::Key kUnitOfAnalysis{"unit_of_analysis"};
inline constexpr document::Key kContrastsPlanned{"contrasts_planned"};
inline constexpr document::Key kLeftOutSubjects{"left_out_subjects", "without subject"};
inline constexpr document::Key kSubjects{"subjects", "subjects"};
inline constexpr document::Key kN{"n", "subjects"};
inline constexpr document::Key kP{"p"};
inline constexpr document::Key kRatio{"ratio", "ratio", document::kNone, document::Form::kInterval};
inline constexpr document::Key kConditions{"conditions"};
inline constexpr document::Key kContrasts{"contrasts"};

/// "1 trial", "2 trials".
[[nodiscard]] std::string Counted(std::size_t count, std::string_view noun);

/// s / sqrt(n), the standard uncertainty of the mean; nothing of fewer than 2 values.
[[nodiscard]] std::optional<double> StandardUncertaintyOf(const dsp::OneSample& sample);

/// That of which `interval` is Student's interval with `df` degrees of freedom.
[[nodiscard]] double StandardUncertaintyOf(const dsp::Interval& interval, double df);

/// The decimal place to which a number beside one of this standard uncertainty is shown: that of
/// the second digit. 0 (no limit) where it is not known.
[[nodiscard]] double ResolutionBy(std::optional<double> standard_uncertainty);

/// Adds a doubt for each pair of names that may be one, written in two ways (alike_names.h).
void AddLabelsAlike(const std::string& label, const std::vector<std::string>& names,
                    StudyFindings& findings);

/// Adds how the analyses of trials with a value differ from what was asked, each difference once.
void AddDeviations(const std::vector<StudyTrial>& trials, StudyFindings& findings);

/// Adds a doubt for each group of files whose contents are equal, in the order of `paths`; a file
/// that cannot be read is equal to none. Cost: a SHA-256 a file, which the provenance then has.
void AddEqualFiles(const std::vector<std::string>& paths, StudyFindings& findings);

/// Refuses a test that `sample` has not, as it is of too few subjects or without spread.
void RefuseUntested(const std::string& subject, const dsp::OneSample& sample,
                    StudyFindings& findings);

/// A mean with its standard uncertainty and interval; not known of no values.
document::Item& AddMean(document::Section& section, const document::Key& key,
                        const dsp::OneSample& sample);

/// exp(mean) of logarithms; the standard uncertainty in the first order, the interval's ends as
/// they are.
document::Item& AddRatio(document::Section& section, const document::Key& key,
                         const dsp::OneSample& logarithms);

/// t, df and p for JSON, and all three in a line: "t(7) = 8.66, p = 0.0131". `p_holm`: p after
/// Holm's correction, of one of several tests.
void AddTest(document::Section& section, std::string_view label,
             const std::optional<dsp::StudentTest>& test);
void AddTest(document::Section& section, std::string_view label,
             const std::optional<dsp::StudentTest>& test, const std::optional<double>& p_holm);

}  // namespace haptometer::tools
