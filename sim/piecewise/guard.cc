#include "sim/piecewise/guard.h"

#include <algorithm>
#include <cmath>

#include "sim/linear/driven_step.h"

namespace haptometer::sim {
namespace {

// grid of the bounds: spacing x |G|_1, and its points at the longest horizon (guard.h)
constexpr double kSpacingTimesNorm = 0.25;
constexpr double kMostPoints = 256;

double BalancedNorm(const Eigen::MatrixXd& generator) {
  return Balance(generator).matrix.cwiseAbs().colwise().sum().maxCoeff();
}

}  // namespace

GuardVerdict Judge(const GuardJet& begin, const GuardJet& end, const GuardBounds& bounds,
                   double h_s) {
  const auto [m2, m3, m4] = bounds;
  const GuardVerdict by_end = end[0] < 0 ? GuardVerdict::kCrosses : GuardVerdict::kClear;
  // g lies at most M2 h^2 / 8 below its chord
  if (std::min(begin[0], end[0]) > m2 * h_s * h_s / 8) return GuardVerdict::kClear;
  // g(s) >= g(0) + s (g'(0) - M2 s / 2)
  if (begin[1] > m2 * h_s / 2) return GuardVerdict::kClear;
  // g falls over the whole interval
  if (std::min(begin[1], end[1]) < -m2 * h_s) return by_end;

  // where g'' keeps its sign: concave, the lesser end is the least value; convex, it may dip
  const double least = std::min(begin[2], end[2]);
  const double most = std::max(begin[2], end[2]);
  if (least < -m3 * h_s) return by_end;
  if (most > m3 * h_s) {
    if (begin[1] >= 0) return GuardVerdict::kClear;
    return end[1] <= 0 ? by_end : GuardVerdict::kDips;
  }
  // g, g' and g'' begin at 0 or more and g''' stays positive
  if (begin[3] > m4 * h_s && begin[1] >= 0 && begin[2] >= 0) return GuardVerdict::kClear;
  return GuardVerdict::kUnknown;
}

std::optional<double> TimeToRest(const Bounce& bounce, const GuardJet& after, double height) {
  // largest relative change of the acceleration until the bounces end
  constexpr double kSteadyAcceleration = 1e-3;
  const double speed = std::max(after[1], 0.0);
  const double acceleration = -after[2];
  if (bounce.restitution >= 1 || !(acceleration > 0)) return {};
  // sum of the flights of all bounces, T = 2 u / (a (1 - e)); the first is u^2 / (2 a) high
  const double rest_s = 2 * speed / (acceleration * (1 - bounce.restitution));
  const bool low = speed * speed / (2 * acceleration) <= height;
  const bool steady = std::abs(after[3]) * rest_s <= kSteadyAcceleration * acceleration;
  return low && steady ? std::optional(rest_s) : std::nullopt;
}

double GuardBound::LongestHorizon(const Eigen::MatrixXd& generator) {
  return kMostPoints * kSpacingTimesNorm / BalancedNorm(generator);
}

GuardBound::GuardBound(const Eigen::MatrixXd& generator, const Eigen::RowVectorXd& row,
                       double offset, const ExcitationShape& shape, double horizon_s)
    : generator_(generator),
      pairs_(shape.pairs),
      horizon_s_(horizon_s),
      row_(row.transpose()),
      offset_(offset),
      feeds_(!row_.tail(shape.generator.rows()).isZero(0)),
      derivatives_(4, generator.rows()) {
  const Eigen::Index n = generator.rows() - shape.generator.rows();
  for (Eigen::Index& pair : pairs_) pair += n;
  derivatives_.row(0) = row;
  // g^(k) = row G^k z
  for (Eigen::Index k = 1; k < 4; ++k) derivatives_.row(k) = derivatives_.row(k - 1) * generator;
  second_bound_ = LargestOver(derivatives_.row(2)).transpose();
}

// The largest entries of |rows exp(G s)| over s in [0, horizon], pairs by their magnitude.
Eigen::MatrixXd GuardBound::LargestOver(Eigen::MatrixXd rows) const {
  const auto points = static_cast<int>(std::clamp(
      std::ceil(horizon_s_ * BalancedNorm(generator_) / kSpacingTimesNorm), 1.0, 2 * kMostPoints));
  const double spacing_s = horizon_s_ / points;
  const Eigen::MatrixXd step = MatrixExponential(generator_ * spacing_s);
  Eigen::MatrixXd largest = Eigen::MatrixXd::Zero(rows.rows(), rows.cols());
  for (int point = 0; point < points; ++point) {
    if (point > 0) rows = (rows * step).eval();
    Eigen::MatrixXd sizes = rows.cwiseAbs();
    // a rotation mixes the entries of a pair, so both take the pair's magnitude
    for (const Eigen::Index pair : pairs_) {
      sizes.middleCols(pair, 2) = rows.middleCols(pair, 2).rowwise().norm().replicate(1, 2);
    }
    largest = largest.cwiseMax(sizes);
  }
  // between grid points |y exp(G r)| <= |y| exp(|G| r); 1 + 2^-20 covers rounding
  largest =
      (1 + std::ldexp(1.0, -20)) * largest * MatrixExponential(generator_.cwiseAbs() * spacing_s);
  for (const Eigen::Index pair : pairs_) {
    largest.col(pair) = largest.middleCols(pair, 2).rowwise().norm().eval();
  }
  return largest;
}

GuardJet GuardBound::Jet(const Eigen::VectorXd& x, const Eigen::VectorXd& w) const {
  GuardJet jet{};
  const Eigen::Vector4d values =
      derivatives_.leftCols(x.size()) * x + derivatives_.rightCols(w.size()) * w;
  Eigen::Vector4d::Map(jet.data()) = values;
  // the value rounded as by Value(), so that all decisions use one number
  jet[0] = Value(x, w);
  return jet;
}

GuardBounds GuardBound::Bounds(const Eigen::VectorXd& x, const Eigen::VectorXd& largest) {
  if (higher_bounds_.size() == 0) {
    Eigen::MatrixXd higher(2, generator_.rows());
    higher << derivatives_.row(3), derivatives_.row(3) * generator_;
    higher_bounds_ = LargestOver(higher);
  }
  const Eigen::Vector2d higher = higher_bounds_.leftCols(x.size()) * x.cwiseAbs() +
                                 higher_bounds_.rightCols(largest.size()) * largest;
  return {SecondBound(x, largest), higher(0), higher(1)};
}

double GuardBound::Noise(const Eigen::VectorXd& x) const {
  return std::ldexp(row_.head(x.size()).cwiseAbs().dot(x.cwiseAbs()) + std::abs(offset_), -44);
}

namespace {

// resolution of a place in [0, 1]
constexpr double kFinest = 0x1p-52;

// the coefficients in w, u = from + w (to - from): Taylor's shift by repeated Horner's rule
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

// the last place before the only crossing, by bisection
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
  // an extreme is flat to rounding over this width
  constexpr double kFlat = 0x1p-26;
  if (!coefficients.allFinite()) return;
  std::vector<std::array<double, 2>> open{{from, to}};
  while (!open.empty()) {
    const auto [left, right] = open.back();
    open.pop_back();
    const Eigen::VectorXd values = Bernstein(coefficients, left, right);
    // a polynomial lies between its least and its largest Bernstein coefficient
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
    // no negative coefficient, no fall; one change of sign, one root (Descartes)
    if (values.minCoeff() >= 0) continue;
    if (last < 0 && SignChanges(values) == 1) return BeforeCrossing(coefficients, left, right);
    if (right - left <= kFinest) {
      if (last < 0) return left;
      continue;
    }
    // the left half is examined first
    const double middle = (left + right) / 2;
    open.push_back({middle, right});
    open.push_back({left, middle});
  }
  return {};
}

double LastAbove(const Eigen::VectorXd& coefficients, double to) {
  // seen backwards from `to`, the negative segment ends where -g falls below zero
  const std::optional<double> back = FirstFall(-Seen(coefficients, to, 0), 0);
  return back ? to * (1 - *back) : to;
}

}  // namespace haptometer::sim
