#pragma once

#include <optional>

#include "dsp/statistics/complete_table.h"

namespace haptometer::dsp {

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

}  // namespace haptometer::dsp
