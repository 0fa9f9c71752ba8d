#include "sim/guard_polynomial.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace haptometer::sim {

namespace {

constexpr double kFinest = 0x1p-52;

// the coefficients in w, u = from + w (to - from): Horner's rule, again and again
Eigen::VectorXd Seen(Eigen::VectorXd coefficients, double from, double to) {
  const Eigen::Index n = coefficients.size();
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index j = n - 1; j-- > k;) coefficients[j] += from * coefficients[j + 1];
  }
  double power = 1;
  for (Eigen::Index k = 0; k < n; ++k, power *= to - from) coefficients[k] *= power;
  return coefficients;
}

// Bernstein coefficients over [from, to]
Eigen::VectorXd Bernstein(const Eigen::VectorXd& coefficients, double from, double to) {
  const Eigen::Index n = coefficients.size();
  const Eigen::VectorXd taylor = Seen(coefficients, from, to);
  // b_i = sum over k <= i of C(i, k) / C(n - 1, k) t_k
  Eigen::VectorXd bernstein(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double sum = 0, ratio = 1;
    for (Eigen::Index k = 0; k <= i; ++k) {
      sum += ratio * taylor[k];
      ratio *= static_cast<double>(i - k) / std::max(static_cast<double>(n - 1 - k), 1.0);
    }
    bernstein[i] = sum;
  }
  return bernstein;
}

// the last place before the only crossing
double BeforeCrossing(const Eigen::VectorXd& coefficients, double above, double below) {
  while (below - above > kFinest) {
    const double middle = (above + below) / 2;
    (PolynomialValue(coefficients, middle) >= 0 ? above : below) = middle;
  }
  return above;
}

Eigen::Index SignChanges(const Eigen::VectorXd& values) {
  Eigen::Index changes = 0;
  for (Eigen::Index k = 1; k < values.size(); ++k) {
    changes += (values[k] < 0) != (values[k - 1] < 0) ? 1 : 0;
  }
  return changes;
}

// whether values only rise or only fall
bool IsMonotone(const Eigen::VectorXd& values) {
  const Eigen::Index n = values.size() - 1;
  const Eigen::VectorXd steps = values.tail(n) - values.head(n);
  return steps.size() == 0 || steps.minCoeff() >= 0 || steps.maxCoeff() <= 0;
}

}  // namespace

double PolynomialValue(const Eigen::VectorXd& coefficients, double u) {
  double value = 0;
  for (Eigen::Index k = coefficients.size(); k-- > 0;) value = value * u + coefficients[k];
  return value;
}

void ExtendRange(const Eigen::VectorXd& coefficients, double from, double to, ValueRange& range) {
  constexpr double kFlat = 0x1p-26;
  if (!coefficients.allFinite()) return;
  std::vector<std::array<double, 2>> open{{from, to}};
  while (!open.empty()) {
    const auto [left, right] = open.back();
    open.pop_back();
    const Eigen::VectorXd values = Bernstein(coefficients, left, right);
    const bool inside = values.maxCoeff() <= range.largest && values.minCoeff() >= range.least;
    if (inside || IsMonotone(values) || right - left <= kFlat) continue;
    const double middle = (left + right) / 2;
    range.Include(PolynomialValue(coefficients, middle));
    open.push_back({middle, right});
    open.push_back({left, middle});
  }
}

std::optional<double> FirstFall(const Eigen::VectorXd& coefficients, double from) {
  if (!coefficients.allFinite()) return {};
  // intervals that are still open, the leftmost last
  std::vector<std::array<double, 2>> open{{from, 1}};
  while (!open.empty()) {
    const auto [left, right] = open.back();
    open.pop_back();
    const Eigen::VectorXd values = Bernstein(coefficients, left, right);
    const double first = values[0], last = values[values.size() - 1];
    if (first < 0) return left;
    if (values.minCoeff() >= 0) continue;
    if (last < 0 && SignChanges(values) == 1) return BeforeCrossing(coefficients, left, right);
    if (right - left <= kFinest) {
      if (last < 0) return left;
      continue;
    }
    const double middle = (left + right) / 2;
    open.push_back({middle, right});
    open.push_back({left, middle});
  }
  return {};
}

double LastAbove(const Eigen::VectorXd& coefficients, double to) {
  // backwards, the negative stretch before `to` ends where -g falls below zero
  const std::optional<double> back = FirstFall(-Seen(coefficients, to, 0), 0);
  return back ? to * (1 - *back) : to;
}

}  // namespace haptometer::sim
