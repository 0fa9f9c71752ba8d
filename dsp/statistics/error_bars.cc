#include "dsp/statistics/error_bars.h"

#include <cmath>

#include "dsp/statistics/distributions.h"
#include "dsp/statistics/moments.h"

namespace haptometer::dsp {

std::vector<double> MoreyHalfWidths(const CompleteTable& table) {
  const std::size_t subjects = table.subjects();
  const std::size_t conditions = table.conditions();
  HAPTOMETER_CHECK(subjects >= 2 && conditions >= 2, "{} x {}", subjects, conditions);
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

}  // namespace haptometer::dsp
