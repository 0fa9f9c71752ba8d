#include "fit/identifiability.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace haptometer::fit {
namespace {

using Position = Eigen::Index;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// a singular value below this share of the largest counts as 0
constexpr double kZeroShare = 1e-9;
// a direction is unseen when one standard deviation along it is more than a factor e of a parameter
constexpr double kMostLogarithm = 1.0;

Eigen::Map<const RowMajor> View(const Jacobian& jacobian) {
  return {jacobian.values.data(), static_cast<Position>(jacobian.rows),
          static_cast<Position>(jacobian.columns)};
}

std::vector<Position> FreeColumns(const std::vector<bool>& is_free) {
  std::vector<Position> columns;
  for (std::size_t k = 0; k < is_free.size(); ++k) {
    if (is_free[k]) columns.push_back(static_cast<Position>(k));
  }
  return columns;
}

std::vector<double> ToRowMajor(const RowMajor& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

// a basis of the null directions that is orthonormal in its logarithms; what has none follows, of
// unit length
RowMajor LogarithmicBasis(const RowMajor& directions, const std::vector<bool>& is_logarithm) {
  if (directions.rows() == 0) return directions;
  RowMajor logarithms = directions;
  for (Position k = 0; k < directions.cols(); ++k) {
    if (!is_logarithm[static_cast<std::size_t>(k)]) logarithms.col(k).setZero();
  }
  // rotated until their logarithms' parts are orthogonal, then divided by the lengths of these
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(logarithms, Eigen::ComputeFullU);
  const Eigen::VectorXd& lengths = svd.singularValues();
  RowMajor basis = svd.matrixU().transpose() * directions;
  for (Position k = 0; k < basis.rows(); ++k) {
    const bool has_logarithms = k < lengths.size() && lengths[k] > kZeroShare;
    basis.row(k) /= has_logarithms ? lengths[k] : basis.row(k).norm();
  }
  return basis;
}

}  // namespace

Identifiability FindIdentifiability(const Jacobian& jacobian, const std::vector<bool>& is_free,
                                    const std::vector<bool>& is_logarithm) {
  HAPTOMETER_CHECK(is_free.size() == jacobian.columns && is_logarithm.size() == jacobian.columns,
                   "{} columns, {} and {} flags", jacobian.columns, is_free.size(),
                   is_logarithm.size());
  // the triangle of the free columns, without residuals: same singular values as J
  const auto columns = FreeColumns(is_free);
  const std::vector<std::size_t> used(columns.begin(), columns.end());
  const std::vector<double> nothing(jacobian.rows, 0.0);
  const auto rows = ReduceRows({jacobian.values, jacobian.columns, nothing}, used);
  const Position size = std::ssize(columns) + 1;
  Eigen::MatrixXd scaled =
      Eigen::Map<const RowMajor>(rows.data(), size, size).topLeftCorner(size - 1, size - 1);
  // unit columns; one that alone is unseen becomes empty: its rounding would mask the others
  Eigen::VectorXd lengths = scaled.colwise().norm();
  for (Position k = 0; k < lengths.size(); ++k) {
    const auto column = static_cast<std::size_t>(columns[static_cast<std::size_t>(k)]);
    const bool empty = lengths[k] == 0 || (is_logarithm[column] && lengths[k] * kMostLogarithm < 1);
    if (empty) lengths[k] = 1;
    scaled.col(k) *= empty ? 0 : 1 / lengths[k];
  }
  const Position free_count = scaled.cols();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled, Eigen::ComputeFullV);
  const Eigen::VectorXd& values = svd.singularValues();

  // a standard deviation along each direction, in the parameters' own units
  const Eigen::MatrixXd directions = lengths.cwiseInverse().asDiagonal() * svd.matrixV();
  std::vector<Position> seen;
  std::vector<Position> unseen;
  for (Position k = 0; k < free_count; ++k) {
    double most = 0;
    for (Position j = 0; j < free_count; ++j) {
      const auto column = static_cast<std::size_t>(columns[static_cast<std::size_t>(j)]);
      if (is_logarithm[column]) most = std::max(most, std::abs(directions(j, k)));
    }
    // seen: a singular value above 0, and a standard deviation along it within a factor e
    const bool is_seen = values[k] > kZeroShare * values[0] && most <= kMostLogarithm * values[k];
    (is_seen ? seen : unseen).push_back(k);
  }

  // (J'J)^+ = D^-1 V S^-2 V' D^-1 on the seen directions
  const Eigen::VectorXd seen_values = values(seen);
  const Eigen::MatrixXd deviations =
      directions(Eigen::all, seen) * seen_values.cwiseInverse().asDiagonal();
  const auto all = static_cast<Position>(jacobian.columns);
  RowMajor covariance = RowMajor::Zero(all, all);
  covariance(columns, columns) = deviations * deviations.transpose();
  RowMajor null_directions = RowMajor::Zero(std::ssize(unseen), all);
  null_directions(Eigen::all, columns) = directions(Eigen::all, unseen).transpose();
  for (Position k = 0; k < null_directions.rows(); ++k) null_directions.row(k).normalize();

  return {.columns = jacobian.columns,
          .singular_values = {values.data(), values.data() + values.size()},
          .nullity = unseen.size(),
          .covariance = ToRowMajor(covariance),
          .null_directions = ToRowMajor(LogarithmicBasis(null_directions, is_logarithm))};
}

double Blur(const Identifiability& identifiability, const std::vector<double>& weights) {
  double square = 0;
  const std::size_t columns = identifiability.columns;
  for (std::size_t d = 0; d * columns < identifiability.null_directions.size(); ++d) {
    // the sum's change along one undetermined direction
    double along = 0;
    for (std::size_t k = 0; k < columns; ++k) {
      along += weights[k] * identifiability.null_directions[d * columns + k];
    }
    square += along * along;
  }
  return std::sqrt(square);
}

double Covariance(const Identifiability& identifiability, const std::vector<double>& first,
                  const std::vector<double>& second) {
  const auto columns = static_cast<Position>(identifiability.columns);
  const Eigen::Map<const RowMajor> covariance(identifiability.covariance.data(), columns, columns);
  const Eigen::Map<const Eigen::VectorXd> left(first.data(), columns);
  const Eigen::Map<const Eigen::VectorXd> right(second.data(), columns);
  return left.dot(covariance * right);
}

double Variance(const Identifiability& identifiability, const std::vector<double>& weights) {
  return Covariance(identifiability, weights, weights);
}

std::vector<double> Correlations(const Identifiability& identifiability) {
  const std::size_t columns = identifiability.columns;
  const auto& covariance = identifiability.covariance;
  std::vector<double> correlations(columns * columns, 0.0);
  for (std::size_t i = 0; i < columns; ++i) {
    for (std::size_t k = 0; k < columns; ++k) {
      // 0 for a parameter that was held or is not determined
      const double scale = std::sqrt(covariance[i * columns + i] * covariance[k * columns + k]);
      if (scale > 0) correlations[i * columns + k] = covariance[i * columns + k] / scale;
    }
  }
  return correlations;
}

// -(J'J)^+ J' change
std::vector<double> Response(const Identifiability& identifiability, const Jacobian& jacobian,
                             const std::vector<double>& residual_change) {
  const Eigen::Map<const Eigen::VectorXd> change(residual_change.data(),
                                                 static_cast<Position>(residual_change.size()));
  const Eigen::VectorXd products = View(jacobian).transpose() * change;
  return Response(identifiability, std::vector<double>(products.begin(), products.end()));
}

std::vector<double> Response(const Identifiability& identifiability,
                             const std::vector<double>& products) {
  const auto columns = static_cast<Position>(identifiability.columns);
  const Eigen::Map<const RowMajor> covariance(identifiability.covariance.data(), columns, columns);
  const Eigen::Map<const Eigen::VectorXd> along(products.data(), columns);
  const Eigen::VectorXd response = -(covariance * along);
  return {response.data(), response.data() + response.size()};
}

}  // namespace haptometer::fit
