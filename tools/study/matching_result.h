#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "dsp/statistics/one_sample.h"
#include "tools/plot/gnuplot.h"
#include "tools/study/text_table.h"

namespace haptometer::tools {

/// matched / reference as a mean logarithm over subjects: one value a subject.
struct MatchedRatio {
  std::optional<double> reference_v;  ///< nothing: over all levels
  dsp::OneSample log_ratio;           ///< tested against 0: a ratio of 1
  std::optional<double> p_holm;       ///< over the levels of its condition
  dsp::OneSample matched_v;           ///< the subjects' (geometric) mean settings; of a level only

  /// exp(mean log) and what follows from it: reduction 1 - r, power saving 1 - r^2.
  [[nodiscard]] double ratio() const;
  [[nodiscard]] std::optional<dsp::Interval> ratio_interval() const;
};

/// One condition of a matching experiment.
struct MatchedCondition {
  std::string name;
  std::vector<MatchedRatio> levels;               ///< ascending
  MatchedRatio overall;                           ///< of the subjects' means over their levels
  std::optional<dsp::OneSample> start_log_ratio;  ///< ln(started high / started low), over subjects
};

struct MatchingResult {
  std::string source;
  std::size_t settings = 0;  ///< rows
  std::vector<std::string> subjects;
  std::vector<MatchedCondition> conditions;
  std::vector<std::string> missing;  ///< a sentence each: halves, levels
};

/// Works out a table with the columns reference_v, condition, subject, matched_v, started (high or
/// low).
///
/// Settings that started high and low are averaged apart, then with each other, as logarithms; a
/// missing half is named, and the other one counts by itself. Each subject gives one value a level,
/// and one over all levels: the mean of its levels.
/// Errors (Cause::kCannotAnswer): a voltage that is not above 0, another word for `started`.
[[nodiscard]] Result<MatchingResult> AnalyzeMatching(const TextTable& table);

[[nodiscard]] std::string MatchingText(const MatchingResult& result);
[[nodiscard]] std::string MatchingJson(const MatchingResult& result);
/// Matched against reference voltage, mean and standard deviation over subjects, a panel a
/// condition.
[[nodiscard]] std::vector<plot::Panel> MatchingPanels(const MatchingResult& result);

}  // namespace haptometer::tools
