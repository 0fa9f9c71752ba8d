#include "fit/grouped_noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace haptometer::fit {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kMostRounds = 50;
constexpr double kSettled = 1e-6;
// relative residuals of a record without noise are rounding; below this nothing is weighed
constexpr double kSmallestNoise = 1e-13;
constexpr double kLeastDegrees = 0.5;

LeastSquares Weighted(const LeastSquares& problem, const NoiseGroups& groups,
                      const std::vector<double>& noise) {
  return {problem.residuals, problem.parameters,
          [&](std::span<const double> at, std::span<double> residuals, std::span<double> jacobian) {
            if (!problem.evaluate(at, residuals, jacobian)) return false;
            for (std::size_t n = 0; n < residuals.size(); ++n) {
              const double weight = 1 / noise[groups.group_of[n]];
              residuals[n] *= weight;
              if (jacobian.empty()) continue;
              for (double& slope : jacobian.subspan(n * at.size(), at.size())) slope *= weight;
            }
            return true;
          }};
}

// what each residual pays for the parameters
Eigen::VectorXd Leverages(const Jacobian& jacobian, const Identifiability& seen) {
  const auto columns = static_cast<Eigen::Index>(jacobian.columns);
  const Eigen::Map<const RowMajor> slopes(jacobian.values.data(),
                                          static_cast<Eigen::Index>(jacobian.rows), columns);
  const Eigen::Map<const RowMajor> covariance(seen.covariance.data(), columns, columns);
  return (slopes * covariance).cwiseProduct(slopes).rowwise().sum();
}

double CommonNoise(const LeastSquares& problem, const std::vector<double>& point) {
  std::vector<double> residuals(problem.residuals);
  HAPTOMETER_CHECK(problem.evaluate(point, residuals, {}), "no residuals at the start of {}",
                   problem.parameters);
  double square = 0;
  for (const double residual : residuals) square += residual * residual;
  return std::sqrt(square / static_cast<double>(residuals.size()));
}

// the groups' noise by the residuals, which are in units of the present one; whether it settled
bool Update(const NoiseGroups& groups, GroupedSolution* solution) {
  const Eigen::VectorXd leverages = Leverages(solution->jacobian, solution->seen);
  std::vector<double> squares(groups.least_noise.size(), 0.0);
  solution->degrees.assign(groups.least_noise.size(), 0.0);
  for (std::size_t n = 0; n < groups.group_of.size(); ++n) {
    const double residual = solution->jacobian.residuals[n];
    squares[groups.group_of[n]] += residual * residual;
    solution->degrees[groups.group_of[n]] += 1 - leverages[static_cast<Eigen::Index>(n)];
  }
  bool settled = true;
  for (std::size_t g = 0; g < squares.size(); ++g) {
    if (solution->degrees[g] < kLeastDegrees) continue;
    const double factor = std::sqrt(squares[g] / solution->degrees[g]);
    const double next =
        std::max({solution->noise[g] * factor, groups.least_noise[g], kSmallestNoise});
    settled = settled && std::abs(next - solution->noise[g]) <= kSettled * next;
    solution->noise[g] = next;
  }
  return settled;
}

}  // namespace

GroupedSolution SolveGroups(const LeastSquares& problem, const NoiseGroups& groups,
                            const std::vector<bool>& is_free, const std::vector<bool>& is_logarithm,
                            std::vector<double>* point) {
  HAPTOMETER_CHECK(groups.group_of.size() == problem.residuals, "{} residuals, {} groups",
                   problem.residuals, groups.group_of.size());
  GroupedSolution solution;
  const double common = std::max(CommonNoise(problem, *point), kSmallestNoise);
  solution.noise.assign(groups.least_noise.size(), common);
  for (int round = 0; round < kMostRounds; ++round) {
    const LeastSquares weighted = Weighted(problem, groups, solution.noise);
    solution.solver = Minimise(weighted, is_free, point);
    solution.jacobian = Linearise(weighted, *point);
    solution.seen = FindIdentifiability(solution.jacobian, is_free, is_logarithm);
    if (Update(groups, &solution)) break;
  }
  return solution;
}

}  // namespace haptometer::fit
