#include "sim/poles.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/matrix_exponential.h"

namespace haptometer::sim {

std::vector<std::complex<double>> Poles(const LinearModel& model) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(Balance(model.a).matrix, false);
  const Eigen::VectorXcd& values = solver.eigenvalues();
  std::vector<std::complex<double>> poles(values.begin(), values.end());
  std::ranges::sort(poles, {},
                    [](const auto& pole) { return std::pair(std::abs(pole), pole.imag()); });
  return poles;
}

}  // namespace haptometer::sim
