#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/error.h"
#include "dsp/statistics/distributions.h"

namespace haptometer::dsp {

/// Subjects x conditions without a hole: value (s, c) is that of subject s in condition c.
class CompleteTable {
 public:
  CompleteTable(std::size_t subjects, std::size_t conditions)
      : subjects_(subjects), conditions_(conditions), values_(subjects * conditions) {}

  [[nodiscard]] std::size_t subjects() const { return subjects_; }
  [[nodiscard]] std::size_t conditions() const { return conditions_; }
  [[nodiscard]] double& At(std::size_t s, std::size_t c) {
    HAPTOMETER_CHECK(s < subjects_ && c < conditions_, "{}, {}", s, c);
    return values_[s * conditions_ + c];
  }
  [[nodiscard]] double At(std::size_t s, std::size_t c) const {
    HAPTOMETER_CHECK(s < subjects_ && c < conditions_, "{}, {}", s, c);
    return values_[s * conditions_ + c];
  }
  /// All values of subject `s`.
  [[nodiscard]] std::span<const double> Subject(std::size_t s) const {
    HAPTOMETER_CHECK(s < subjects_, "{}", s);
    return std::span(values_).subspan(s * conditions_, conditions_);
  }
  /// All values of condition `c`, a copy.
  [[nodiscard]] std::vector<double> Condition(std::size_t c) const {
    std::vector<double> column(subjects_);
    for (std::size_t s = 0; s < subjects_; ++s) column[s] = At(s, c);
    return column;
  }
  [[nodiscard]] std::span<const double> values() const { return values_; }

 private:
  std::size_t subjects_;
  std::size_t conditions_;
  std::vector<double> values_;  // subject by subject
};

/// One-way analysis of variance with repeated measures.
struct RepeatedMeasuresAnova {
  double f = 0;
  double df_conditions = 0;         ///< k - 1
  double df_error = 0;              ///< (k - 1)(n - 1)
  double p = 0;                     ///< where sphericity holds
  double greenhouse_geisser = 0;    ///< epsilon, 1/(k-1) to 1
  double p_greenhouse_geisser = 0;  ///< both degrees of freedom multiplied by epsilon
  double partial_eta_squared = 0;   ///< SS conditions / (SS conditions + SS error)
};

/// F = MS conditions / MS (subjects x conditions), and Box's epsilon from the covariance S of the
/// conditions, centred by rows and columns: (tr S)^2 / ((k - 1) tr(S S)) (S. W. Greenhouse and
/// S. Geisser, Psychometrika 24(2), 1959, eq. 10).
///
/// Nothing with fewer than 2 subjects or conditions, or without any residual.
[[nodiscard]] std::optional<RepeatedMeasuresAnova> AnalyzeRepeatedMeasures(
    const CompleteTable& table);

/// Half the length of each condition's within-subject 95 % error bar after Cousineau and Morey, for
/// figures: the values less their subject's mean, and
///   t_crit(n-1) sd(condition) / sqrt(n) sqrt(k / (k-1))
/// (R. D. Morey, Tutorials in Quantitative Methods for Psychology 4(2), 2008, eq. 2).
///
/// These bars tell differences between conditions. They are no confidence interval of a condition's
/// mean: what subjects differ by is taken out. At least 2 subjects and 2 conditions.
[[nodiscard]] std::vector<double> MoreyHalfWidths(const CompleteTable& table);

/// How well repeats agree, against how much subjects differ.
struct Reliability {
  double icc = 0;        ///< ICC(1,1): between-subject variance / (between + within)
  Interval interval;     ///< of the population's ICC
  double within_sd = 0;  ///< of one repeat about its subject's mean, in the values' unit
};

/// One-way random effects over `cells`: the repeats of each subject, as many for each. With
/// F = MS between / MS within and k repeats
///   icc = (F - 1) / (F + k - 1),   ends the same of F / F_.975(n-1, n(k-1)) and
///   F F_.975(n(k-1), n-1)
/// (K. O. McGraw and S. P. Wong, Psychological Methods 1(1), 1996, case 1, table 7).
///
/// Nothing with fewer than 2 subjects or repeats, unequal repeats, or repeats that do not differ.
[[nodiscard]] std::optional<Reliability> AssessRepeats(std::span<const std::vector<double>> cells);

/// The coefficient of variation of exp(X), X normal with standard deviation `sd` (of a lognormal
/// value, sd / mean): sqrt(exp(sd^2) - 1).
[[nodiscard]] double VariationOfLogs(double sd);

}  // namespace haptometer::dsp
