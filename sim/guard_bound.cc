#include "sim/guard_bound.h"

#include <algorithm>
#include <cmath>

#include "sim/matrix_exponential.h"

namespace haptometer::sim {

namespace {

constexpr double kSpacingTimesNorm = 0.25;
constexpr double kMostPoints = 256;

double BalancedNorm(const Eigen::MatrixXd& generator) {
  return Balance(generator).matrix.cwiseAbs().colwise().sum().maxCoeff();
}

// The largest entries of |rows exp(G s)| over s in [0, horizon], the drive's pair by its amplitude.
Eigen::MatrixXd LargestOver(const Eigen::MatrixXd& generator, Eigen::MatrixXd rows,
                            double horizon_s) {
  const auto points = static_cast<int>(std::clamp(
      std::ceil(horizon_s * BalancedNorm(generator) / kSpacingTimesNorm), 1.0, 2 * kMostPoints));
  const double spacing_s = horizon_s / points;
  const Eigen::MatrixXd step = MatrixExponential(generator * spacing_s);
  Eigen::MatrixXd largest = rows.cwiseAbs();
  Eigen::VectorXd amplitude = rows.rightCols(2).rowwise().norm();
  for (int point = 1; point < points; ++point) {
    rows = (rows * step).eval();
    largest = largest.cwiseMax(rows.cwiseAbs());
    amplitude = amplitude.cwiseMax(rows.rightCols(2).rowwise().norm());
  }
  // the pair's amplitude serves both of its entries, which a turn mixes
  largest.rightCols(2) = amplitude.replicate(1, 2);
  return (1 + std::ldexp(1.0, -20)) * largest * MatrixExponential(generator.cwiseAbs() * spacing_s);
}

}  // namespace

GuardVerdict Judge(const GuardJet& begin, const GuardJet& end, const GuardBounds& bounds,
                   double h_s) {
  const auto [m2, m3, m4] = bounds;
  const GuardVerdict by_end = end[0] < 0 ? GuardVerdict::kCrosses : GuardVerdict::kClear;
  if (std::min(begin[0], end[0]) > m2 * h_s * h_s / 8) return GuardVerdict::kClear;
  if (begin[1] > m2 * h_s / 2) return GuardVerdict::kClear;
  if (std::min(begin[1], end[1]) < -m2 * h_s) return by_end;

  const double least = std::min(begin[2], end[2]);
  const double most = std::max(begin[2], end[2]);
  if (least < -m3 * h_s) return by_end;
  if (most > m3 * h_s) {
    if (begin[1] >= 0) return GuardVerdict::kClear;
    return end[1] <= 0 ? by_end : GuardVerdict::kDips;
  }
  if (begin[3] > m4 * h_s && begin[1] >= 0 && begin[2] >= 0) return GuardVerdict::kClear;
  return GuardVerdict::kUnknown;
}

double GuardBound::LongestHorizon(const Eigen::MatrixXd& generator) {
  return kMostPoints * kSpacingTimesNorm / BalancedNorm(generator);
}

GuardBound::GuardBound(const Eigen::MatrixXd& generator, const Eigen::RowVectorXd& row,
                       double offset, double horizon_s)
    : generator_(generator),
      horizon_s_(horizon_s),
      row_(row.transpose()),
      offset_(offset),
      derivatives_(4, generator.rows()) {
  const Eigen::Index n = row.size() - 2;
  derivatives_.row(0) = row;
  for (Eigen::Index k = 1; k < 4; ++k) derivatives_.row(k) = derivatives_.row(k - 1) * generator;
  const Eigen::MatrixXd largest = LargestOver(generator, derivatives_.row(2), horizon_s);
  second_bound_ = largest.leftCols(n).transpose();
  drive_bounds_[0] = largest.rightCols(2).norm();
}

GuardJet GuardBound::Jet(const Eigen::VectorXd& x, const Eigen::Vector2d& drive) const {
  const Eigen::Index n = x.size();
  GuardJet jet{};
  const Eigen::Vector4d values = derivatives_.leftCols(n) * x + derivatives_.rightCols(2) * drive;
  Eigen::Vector4d::Map(jet.data()) = values;
  // the value as Value() rounds it, so that all decisions see one number
  jet[0] = Value(x, drive);
  return jet;
}

GuardBounds GuardBound::Bounds(const Eigen::VectorXd& x) {
  if (higher_bounds_.size() == 0) {
    Eigen::MatrixXd higher(2, generator_.rows());
    higher << derivatives_.row(3), derivatives_.row(3) * generator_;
    const Eigen::MatrixXd largest = LargestOver(generator_, higher, horizon_s_);
    higher_bounds_ = largest.leftCols(x.size());
    drive_bounds_[1] = largest.row(0).tail(2).norm();
    drive_bounds_[2] = largest.row(1).tail(2).norm();
  }
  const Eigen::Vector2d higher = higher_bounds_ * x.cwiseAbs();
  return {SecondBound(x), higher(0) + drive_bounds_[1], higher(1) + drive_bounds_[2]};
}

double GuardBound::Noise(const Eigen::VectorXd& x) const {
  return std::ldexp(row_.head(x.size()).cwiseAbs().dot(x.cwiseAbs()) + std::abs(offset_), -44);
}

}  // namespace haptometer::sim
