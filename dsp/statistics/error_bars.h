#pragma once

#include <vector>

#include "dsp/statistics/complete_table.h"

namespace haptometer::dsp {

/// Half the length of each condition's within-subject 95 % error bar after Cousineau and Morey, for
/// figures: the values less their subject's mean, and
///   t_crit(n-1) sd(condition) / sqrt(n) sqrt(k / (k-1))
/// (R. D. Morey, Tutorials in Quantitative Methods for Psychology 4(2), 2008, eq. 2).
///
/// These bars tell differences between conditions. They are no confidence interval of a condition's
/// mean: what subjects differ by is taken out. At least 2 subjects and 2 conditions.
[[nodiscard]] std::vector<double> MoreyHalfWidths(const CompleteTable& table);

}  // namespace haptometer::dsp
