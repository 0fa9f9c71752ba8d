#pragma once

#include <initializer_list>
#include <string>

#include "fit/drop_test/drop_test_fit.h"

namespace haptometer::fit {

/// The constant whose logarithm was fitted.
///
///     value = exp(l),  u(value) = value u(l).
///
/// Determined: finite, and its statistical standard uncertainty below 25 % of it, beyond which an
/// interval symmetric in the constant or in its logarithm no longer says the same. The 95 %
/// interval is that of a normal distribution; see SetIntervals for few residuals.
///
/// @param logarithm l
/// @param statistical_variance of l, from scatter (type A)
/// @param input_variance of l, from what was given (type B)
/// @param unit of the constant
[[nodiscard]] FittedValue FromLogarithm(double logarithm, double statistical_variance,
                                        double input_variance, std::string unit);

/// Whether n values scatter by more than what they state explains: a Birge ratio (consistency.h)
/// beyond which 1 of 100 sets lies by chance, chi^2 = (n - 1) R^2 above its 99 % quantile.
[[nodiscard]] bool Scatters(double birge_ratio, double degrees);

/// The 95 % coverage factor of a result whose variance V, all causes, holds a part S that was
/// found from the scatter of few values, n - 1 of them free (GUM, G.4.1: Welch and Satterthwaite):
///
///     t(v),   v = (n - 1) (V / S)^2,
///
/// t Student's factor: 1.96 without scatter, t(n - 1) where there is nothing else.
///
/// @param variance V, >= S
/// @param scatter_variance S >= 0
/// @param degrees n - 1, >= 1
[[nodiscard]] double ScatterCoverage(double variance, double scatter_variance, double degrees);

/// Sets the 95 % intervals to `coverage` combined standard uncertainties on both sides.
void SetIntervals(double coverage, std::initializer_list<FittedValue*> values);

}  // namespace haptometer::fit
