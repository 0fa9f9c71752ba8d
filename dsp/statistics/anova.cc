#include "dsp/statistics/anova.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// what subject and condition means leave of each value
CompleteTable Residuals(const CompleteTable& table, const std::vector<double>& condition_means,
                        double grand_mean) {
  CompleteTable residuals = table;
  for (std::size_t s = 0; s < table.subjects(); ++s) {
    const double subject_mean = Mean(table.Subject(s));
    for (std::size_t c = 0; c < table.conditions(); ++c) {
      residuals.At(s, c) -= subject_mean + (condition_means[c] - grand_mean);
    }
  }
  return residuals;
}

// The residuals' products between conditions are the doubly centred covariance, up to a factor that
// cancels in epsilon.
double GreenhouseGeisser(const CompleteTable& residuals) {
  const std::size_t k = residuals.conditions();
  double trace = 0;
  double squares = 0;
  for (std::size_t c = 0; c < k; ++c) {
    for (std::size_t d = 0; d < k; ++d) {
      double product = 0;
      for (std::size_t s = 0; s < residuals.subjects(); ++s) {
        product += residuals.At(s, c) * residuals.At(s, d);
      }
      if (c == d) trace += product;
      squares += product * product;
    }
  }
  const auto df = static_cast<double>(k - 1);
  return std::clamp(trace * trace / (df * squares), 1 / df, 1.0);
}

}  // namespace

std::optional<RepeatedMeasuresAnova> AnalyzeRepeatedMeasures(const CompleteTable& table) {
  const std::size_t k = table.conditions();
  if (table.subjects() < 2 || k < 2) return std::nullopt;
  const auto n = static_cast<double>(table.subjects());
  const double grand_mean = Mean(table.values());
  std::vector<double> means(k);
  double conditions = 0;  // sum of squares
  for (std::size_t c = 0; c < k; ++c) {
    means[c] = Mean(table.Condition(c));
    conditions += n * (means[c] - grand_mean) * (means[c] - grand_mean);
  }
  const CompleteTable residuals = Residuals(table, means, grand_mean);
  double error = 0;
  for (const double residual : residuals.values()) error += residual * residual;
  // rounding of the values themselves is no residual
  const double scale = Rms(table.values());
  if (!(error > 1e-28 * scale * scale)) return std::nullopt;

  RepeatedMeasuresAnova anova;
  anova.df_conditions = static_cast<double>(k - 1);
  anova.df_error = anova.df_conditions * (n - 1);
  anova.f = (conditions / anova.df_conditions) / (error / anova.df_error);
  anova.p = FisherUpperP(anova.f, anova.df_conditions, anova.df_error);
  anova.greenhouse_geisser = GreenhouseGeisser(residuals);
  anova.p_greenhouse_geisser = FisherUpperP(anova.f, anova.greenhouse_geisser * anova.df_conditions,
                                            anova.greenhouse_geisser * anova.df_error);
  anova.partial_eta_squared = conditions / (conditions + error);
  return anova;
}

}  // namespace haptometer::dsp
