#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "dsp/statistics/repeated_measures.h"

namespace haptometer::dsp {

/// A value that stands apart from what the others let expect of its place.
struct Outlier {
  std::size_t group = 0;  ///< or subject
  std::size_t place = 0;  ///< within the group, or condition
  double deviation = 0;   ///< less what the others let expect, in the values' unit
  double t = 0;           ///< externally studentized residual
  double p = 0;           ///< of the whole test: after Bonferroni's correction over all values
};

/// The values that do not fit a model with one mean a group and one variance of all groups.
///
/// With residual r, leverage h = 1/n of a group of n, sum of squares SS on df degrees of freedom,
///   t = r / sqrt((1 - h) s^2),   s^2 = (SS - r^2 / (1 - h)) / (df - 1)
/// is Student's t with df - 1 degrees of freedom (R. D. Cook and S. Weisberg, Residuals and
/// Influence in Regression, 1982, 2.2.1). The largest |t| of m values is an outlier where m P(|T|
/// >= |t|) <= `false_alarms`; it is then taken out, and the rest is tested again. So the chance of
/// any outlier in normal values of one variance is at most `false_alarms`. A value of a group of
/// one is not tested. The two of a group of two deviate alike: they are one value of m, and both
/// are named.
///
/// `least` has for each value, in the same shape, the least s that it is judged by, above 0: it
/// only lowers the chance. Cost: one pass an outlier.
[[nodiscard]] std::vector<Outlier> OutliersOfGroups(std::vector<std::vector<double>> groups,
                                                    const std::vector<std::vector<double>>& least,
                                                    double false_alarms);

/// The same of a model with a mean for each subject and each condition: 1 - h = (n - 1)(k - 1) / (n
/// k), df = (n - 1)(k - 1). A subject with an outlier is taken out, and the others are tested
/// again. Of two conditions both of the subject are named. None of fewer than 3 subjects or 2
/// conditions.
[[nodiscard]] std::vector<Outlier> OutliersOfTable(const CompleteTable& table,
                                                   const CompleteTable& least, double false_alarms);

}  // namespace haptometer::dsp
