#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/moments.h"
#include "tools/study/manifest.h"
#include "tools/study/text_table.h"

namespace haptometer::tools {

/// A ratio of voltages as a mean logarithm over subjects, one value a subject: matched / reference,
/// or one condition's matched voltage / another's.
struct MatchedRatio {
  std::optional<double> reference_v;  ///< nothing: over all levels
  dsp::OneSample log_ratio;           ///< tested against 0: a ratio of 1
  std::optional<double> p_holm = {};  ///< over the levels beside it; of a contrast's whole, over
                                      ///< the contrasts; nothing of a condition's whole

  /// exp(mean log) and what follows from it: reduction 1 - r, power saving 1 - r^2.
  [[nodiscard]] double ratio() const;
  [[nodiscard]] std::optional<dsp::Interval> ratio_interval() const;
};

/// One reference level of a condition.
struct MatchedLevel {
  MatchedRatio ratio;
  dsp::OneSample matched_v;  ///< the subjects' (geometric) mean settings
};

/// One condition of a matching experiment.
struct MatchedCondition {
  std::string name;
  std::vector<MatchedLevel> levels{};  ///< ascending
  MatchedRatio overall{};              ///< of the subjects' means over their levels
  std::optional<dsp::OneSample>
      start_log_ratio{};  ///< ln(started high / started low), over subjects
};

/// One condition's matched voltages over another's, subject by subject, at the same references.
struct MatchedContrast {
  PlannedContrast planned;
  std::vector<std::string> left_out{};  ///< subjects with no level in both
  std::vector<MatchedRatio> levels{};   ///< those that both have, ascending
  std::optional<MatchedRatio>
      overall{};  ///< of the subjects' means over the levels they have in both
};

/// A subject at a level of a condition, of whom a setting is missing.
struct MissingSetting {
  std::string subject;
  std::string condition;
  double reference_v = 0;
  std::string started;  ///< which start is missing: "high" or "low"; empty: both
};

struct MatchingResult {
  std::string source;
  std::size_t settings = 0;  ///< rows
  std::vector<std::string> subjects;
  std::vector<MatchedCondition> conditions;
  bool planned = false;  ///< the contrasts were asked for
  std::vector<MatchedContrast> contrasts;
  std::vector<MissingSetting> missing;
};

/// Works out a table with the columns reference_v, condition, subject, matched_v, started (high or
/// low).
///
/// Settings that started high and low are averaged apart, then with each other, as logarithms; a
/// missing half is named, and the other one counts alone. Each subject gives one value a level,
/// and one over all levels: the mean of its levels. A contrast takes the differences of these
/// logarithms, treatment less control, in each subject. Where none is planned, every condition is
/// compared with the first.
/// Errors: Cause::kCannotAnswer for a voltage that is not above 0 and another word for `started`,
/// Cause::kUsage for a contrast with a condition that the table lacks.
[[nodiscard]] Result<MatchingResult> AnalyzeMatching(const TextTable& table,
                                                     const std::vector<PlannedContrast>& planned);

}  // namespace haptometer::tools
