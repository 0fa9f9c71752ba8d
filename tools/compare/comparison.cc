#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/compare/compare.h"

namespace haptometer::tools {
namespace {

// directions of V below this share of its largest are not determined
constexpr double kLeastDirection = 1e-12;
// share of an input's variance that the measurement explains at least, where it depends on it
constexpr double kLeastInfluence = 1e-12;

// the inverse of a symmetric matrix in the scale of its diagonal
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& v) {
  const Eigen::VectorXd scale = v.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * v * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const double least = kLeastDirection * values.maxCoeff();
  const Eigen::VectorXd inverse =
      values.unaryExpr([&](double value) { return value > least ? 1 / value : 0.0; });
  const Eigen::MatrixXd vectors = scale.asDiagonal() * solver.eigenvectors();
  return vectors * inverse.asDiagonal() * vectors.transpose();
}

// inputs by falling |pull|, each with those that cannot be told apart from it
std::vector<std::vector<std::size_t>> SetsOf(const Agreement& agreement) {
  std::vector<std::size_t> left;
  for (Eigen::Index j = 0; j < agreement.pull.size(); ++j) {
    if (std::isfinite(agreement.pull(j))) left.push_back(static_cast<std::size_t>(j));
  }
  const auto pull = [&](std::size_t j) {
    return -std::abs(agreement.pull(static_cast<Eigen::Index>(j)));
  };
  std::ranges::stable_sort(left, {}, pull);
  std::vector<std::vector<std::size_t>> sets;
  while (!left.empty()) {
    const auto first = static_cast<Eigen::Index>(left.front());
    const auto apart = std::ranges::stable_partition(left, [&](std::size_t j) {
      return std::abs(agreement.correlation(first, static_cast<Eigen::Index>(j))) > kToldApart;
    });
    sets.emplace_back(left.begin(), apart.begin());
    left.erase(left.begin(), apart.begin());
  }
  return sets;
}

// columns of the factor along which a compared quantity is not linear, as inputs
std::vector<std::size_t> CurvedInputs(const ComparedScene& scene, const Propagation& propagation,
                                      const std::vector<ComparedQuantity>& quantities) {
  std::vector<std::size_t> curved;
  for (Eigen::Index k = 0; k < propagation.changes.cols(); ++k) {
    const bool is_curved = std::ranges::any_of(quantities, [&](const ComparedQuantity& one) {
      const double second_order = propagation.curvature(static_cast<Eigen::Index>(one.quantity), k);
      return std::abs(second_order) > kMostCurvature * one.deviation_uncertainty;
    });
    if (is_curved) curved.push_back(scene.InputOf(k));
  }
  return curved;
}

}  // namespace

Agreement Agree(const Eigen::VectorXd& deviation, const Eigen::VectorXd& own,
                const Eigen::MatrixXd& changes, const Eigen::MatrixXd& factor) {
  // V = T T^T + diag(own), S C = T F^T
  Eigen::MatrixXd v = changes * changes.transpose();
  v.diagonal() += own;
  const Eigen::MatrixXd inverse = InverseOf(v);
  const Eigen::MatrixXd sc = changes * factor.transpose();
  const Eigen::MatrixXd p = sc.transpose() * inverse * sc;
  Agreement agreement{.variance = v.diagonal(),
                      .adjustment = sc.transpose() * inverse * deviation,
                      .pull = {},
                      .explained = p.diagonal(),
                      .correlation = {},
                      .chi_squared = deviation.dot(inverse * deviation)};
  // 1 / sqrt(P_jj); NaN where the measurement does not depend on the input
  const Eigen::VectorXd scale = p.diagonal().unaryExpr([](double variance) {
    return variance > kLeastInfluence ? 1 / std::sqrt(variance)
                                      : std::numeric_limits<double>::quiet_NaN();
  });
  agreement.pull = agreement.adjustment.cwiseProduct(scale);
  agreement.correlation = scale.asDiagonal() * p * scale.asDiagonal();
  return agreement;
}

bool ComparisonResult::Differs() const {
  return std::ranges::any_of(quantities,
                             [](const auto& one) { return std::abs(one.NormalizedError()) > 1; });
}

ComparisonResult Compare(const OfCompared<dsp::Estimate>& measured, const ComparedScene& scene,
                         const Propagation& propagation) {
  ComparisonResult result{.target = scene.target()};
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < kComparedCount; ++k) {
    const auto quantity = static_cast<Compared>(k);
    const auto row = static_cast<Eigen::Index>(k);
    const dsp::Estimate& simulated = propagation.at[k];
    const bool is_simulated =
        std::isfinite(simulated.value) && propagation.changes.row(row).allFinite();
    if (measured[k] && is_simulated) {
      const double method = simulated.uncertainty;
      const double u = std::hypot(propagation.changes.row(row).norm(), method);
      double deviation = measured[k]->value - simulated.value;
      if (quantity == Compared::kPhase) {
        deviation = std::remainder(deviation, 2 * std::numbers::pi);
      }
      result.quantities.push_back(
          {.quantity = quantity,
           .measured = *measured[k],
           .simulated = {simulated.value, u},
           .deviation = deviation,
           .deviation_uncertainty = std::hypot(u, measured[k]->uncertainty)});
      rows.push_back(row);
    } else if (measured[k]) {
      result.only_measured.push_back(quantity);
    } else if (is_simulated) {
      result.only_simulated.push_back(quantity);
    }
  }
  // d, and the variances that no input has a part in
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::VectorXd deviation(count), own(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ComparedQuantity& one = result.quantities[static_cast<std::size_t>(i)];
    const double method = propagation.at[static_cast<std::size_t>(one.quantity)].uncertainty;
    deviation(i) = one.deviation;
    own(i) = one.measured.uncertainty * one.measured.uncertainty + method * method;
  }
  if (count == 0) return result;
  result.agreement = Agree(deviation, own, propagation.changes(rows, Eigen::all), scene.factor());
  result.sets = SetsOf(result.agreement);
  result.curved = CurvedInputs(scene, propagation, result.quantities);
  return result;
}

}  // namespace haptometer::tools
