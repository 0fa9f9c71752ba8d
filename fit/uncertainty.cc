#include "fit/uncertainty.h"

#include <cmath>
#include <utility>

#include "dsp/statistics/distributions.h"

namespace haptometer::fit {

FittedValue FromLogarithm(double logarithm, double statistical_variance, double input_variance,
                          std::string unit) {
  // relative statistical standard uncertainty below which a constant is determined (uncertainty.md)
  constexpr double kMostShare = 0.25;
  FittedValue fitted;
  fitted.unit = std::move(unit);
  fitted.value = std::exp(logarithm);
  // u(value) = value u(ln value); type A and B add in squares
  fitted.standard_uncertainty = fitted.value * std::sqrt(statistical_variance);
  fitted.combined_standard_uncertainty =
      fitted.value * std::sqrt(statistical_variance + input_variance);
  fitted.determined = std::isfinite(fitted.combined_standard_uncertainty) && fitted.value > 0 &&
                      statistical_variance < kMostShare * kMostShare;
  SetIntervals(kCoverage95, {&fitted});
  return fitted;
}

bool Scatters(double birge_ratio, double degrees) {
  constexpr double kByChance = 0.01;
  return degrees * birge_ratio * birge_ratio > dsp::ChiSquareQuantile(1 - kByChance, degrees);
}

double ScatterCoverage(double variance, double scatter_variance, double degrees) {
  // beyond so many degrees of freedom the factor is a normal distribution's to 2e-6
  constexpr double kMany = 1e6;
  const double effective = degrees * std::pow(variance / scatter_variance, 2);
  return effective < kMany ? dsp::StudentCritical(effective) : kCoverage95;
}

void SetIntervals(double coverage, std::initializer_list<FittedValue*> values) {
  for (FittedValue* value : values) {
    const double half = coverage * value->combined_standard_uncertainty;
    value->lower = value->value - half;
    value->upper = value->value + half;
  }
}

}  // namespace haptometer::fit
