#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace haptometer::tests {

/// The Cramer-Rao bound of parameters p from residuals in units of their noise: standard deviations
/// out of the inverse of J'J, J by central differences of fourth order and the inverse by
/// elimination. Written without the code under test.
inline std::vector<double> CramerRaoDeviations(
    const std::function<std::vector<double>(const std::vector<double>&)>& residuals,
    const std::vector<double>& at, const std::vector<double>& steps) {
  const std::size_t n = at.size();
  std::vector<std::vector<double>> slopes;
  for (std::size_t k = 0; k < n; ++k) {
    const auto shifted = [&](double by) {
      auto p = at;
      p[k] += by * steps[k];
      return residuals(p);
    };
    const auto a = shifted(-2), b = shifted(-1), c = shifted(1), d = shifted(2);
    std::vector<double> slope(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      slope[i] = (a[i] - 8 * b[i] + 8 * c[i] - d[i]) / (12 * steps[k]);
    }
    slopes.push_back(std::move(slope));
  }
  // [J'J | 1] in units of the columns' lengths, so that pivots compare
  std::vector<double> lengths(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    for (const double slope : slopes[k]) lengths[k] += slope * slope;
    lengths[k] = std::sqrt(lengths[k]);
  }
  std::vector<std::vector<double>> rows(n, std::vector<double>(2 * n, 0.0));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t m = 0; m < slopes[i].size(); ++m) rows[i][k] += slopes[i][m] * slopes[k][m];
      rows[i][k] /= lengths[i] * lengths[k];
    }
    rows[i][n + i] = 1;
  }
  for (std::size_t pivot = 0; pivot < n; ++pivot) {
    const double scale = rows[pivot][pivot];  // of a positive definite matrix: above 0
    for (double& value : rows[pivot]) value /= scale;
    for (std::size_t i = 0; i < n; ++i) {
      if (i == pivot) continue;
      const double factor = rows[i][pivot];
      for (std::size_t k = 0; k < 2 * n; ++k) rows[i][k] -= factor * rows[pivot][k];
    }
  }
  std::vector<double> deviations(n);
  for (std::size_t k = 0; k < n; ++k) deviations[k] = std::sqrt(rows[k][n + k]) / lengths[k];
  return deviations;
}

}  // namespace haptometer::tests
