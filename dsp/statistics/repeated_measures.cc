#include "dsp/statistics/repeated_measures.h"

#include <algorithm>
#include <cmath>

#include "dsp/statistics/moments.h"

namespace haptometer::dsp {
namespace {

// value less subject effect and condition effect
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
// epsilon = (tr S)^2 / ((k - 1) tr(S S)), between 1 / (k - 1) and 1
double GreenhouseGeisser(const CompleteTable& residuals) {
  const std::size_t k = residuals.conditions();
  // S symmetric: tr(S S) is the sum of its squared elements
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
  // sum of squares between conditions, n sum (mean - grand mean)^2
  std::vector<double> means(k);
  double conditions = 0;  // sum of squares
  for (std::size_t c = 0; c < k; ++c) {
    means[c] = Mean(table.Condition(c));
    conditions += n * (means[c] - grand_mean) * (means[c] - grand_mean);
  }
  // what remains after both effects is the error term of F
  const CompleteTable residuals = Residuals(table, means, grand_mean);
  double error = 0;
  for (const double residual : residuals.values()) error += residual * residual;
  // residuals of the size of the values' rounding are none
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

std::vector<double> MoreyHalfWidths(const CompleteTable& table) {
  const std::size_t subjects = table.subjects();
  const std::size_t conditions = table.conditions();
  HAPTOMETER_CHECK(subjects >= 2 && conditions >= 2, "{} x {}", subjects, conditions);
  // without the subjects' means, then the t interval corrected by sqrt(k / (k - 1))
  CompleteTable normalized = table;
  for (std::size_t s = 0; s < subjects; ++s) {
    const double mean = Mean(table.Subject(s));
    for (std::size_t c = 0; c < conditions; ++c) normalized.At(s, c) -= mean;
  }
  const auto n = static_cast<double>(subjects);
  const auto k = static_cast<double>(conditions);
  const double factor = StudentCritical(n - 1) / std::sqrt(n) * std::sqrt(k / (k - 1));
  std::vector<double> half_widths(conditions);
  for (std::size_t c = 0; c < conditions; ++c) {
    half_widths[c] = factor * StandardDeviation(normalized.Condition(c));
  }
  return half_widths;
}

std::optional<Reliability> AssessRepeats(std::span<const std::vector<double>> cells) {
  if (cells.size() < 2 || cells[0].size() < 2) return std::nullopt;
  std::vector<double> means;
  means.reserve(cells.size());
  // mean squares: within cells over n (k - 1), between cells k times the variance of the means
  double within = 0;
  for (const std::vector<double>& cell : cells) {
    if (cell.size() != cells[0].size()) return std::nullopt;
    means.push_back(Mean(cell));
    for (const double value : cell) within += (value - means.back()) * (value - means.back());
  }
  const auto n = static_cast<double>(cells.size());
  const auto k = static_cast<double>(cells[0].size());
  within /= n * (k - 1);
  const double sd = StandardDeviation(means);
  if (!(within > 0)) return std::nullopt;
  // F = MS between / MS within, ICC = (F - 1) / (F + k - 1)
  const double f = k * sd * sd / within;
  const auto icc_of = [k](double ratio) { return (ratio - 1) / (ratio + k - 1); };
  constexpr double kUpper = (1 + kConfidence) / 2;
  Reliability reliability;
  reliability.icc = icc_of(f);
  // F divided and multiplied by its 97.5 % quantiles gives the ends
  reliability.interval = {icc_of(f / FisherQuantile(kUpper, n - 1, n * (k - 1))),
                          icc_of(f * FisherQuantile(kUpper, n * (k - 1), n - 1))};
  reliability.within_sd = std::sqrt(within);
  return reliability;
}

double VariationOfLogs(double sd) { return std::sqrt(std::expm1(sd * sd)); }

}  // namespace haptometer::dsp
