#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "dsp/statistics/moments.h"
#include "tools/document/document.h"
#include "tools/study/study_findings.h"

/// How the numbers of statistics stand in the documents of study, and the keys that they share.
namespace haptometer::tools {

inline constexpr document::Key kSubject{"subject", "subject"};
inline constexpr document::Key kCondition{"condition", "condition"};
inline constexpr document::Key kTreatment{"treatment"};
inline constexpr document::Key kControl{"control"};
inline constexpr document::Key kFile{"file"};
inline constexpr document::Key kName{"name"};
inline constexpr document::Key kUnitOfAnalysis{"unit_of_analysis"};
inline constexpr document::Key kContrastsPlanned{"contrasts_planned"};
inline constexpr document::Key kLeftOutSubjects{"left_out_subjects", "without subject"};
inline constexpr document::Key kSubjects{"subjects", "subjects"};
inline constexpr document::Key kN{"n", "subjects"};
inline constexpr document::Key kP{"p"};
inline constexpr document::Key kRatio{"ratio", "ratio", document::kNone, document::Form::kInterval};
inline constexpr const char* kConditionsName = "conditions";
inline constexpr const char* kContrastsName = "contrasts";

/// "1 trial", "2 trials".
[[nodiscard]] std::string Counted(std::size_t count, std::string_view noun);

/// Adds a number that text shows to the decimal place of `resolution`.
void AddRounded(document::Section& section, const document::Key& key, document::Value value,
                double resolution);

/// s / sqrt(n), the standard uncertainty of the mean; nothing of fewer than 2 values.
[[nodiscard]] std::optional<double> StandardUncertaintyOf(const dsp::OneSample& sample);

/// That of which `interval` is Student's interval with `df` degrees of freedom.
[[nodiscard]] double StandardUncertaintyOf(const dsp::Interval& interval, double df);

/// The decimal place to which a number beside one of this standard uncertainty is shown: that of
/// the second digit. 0 (no limit) where it is not known.
[[nodiscard]] double ResolutionBy(std::optional<double> standard_uncertainty);

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
