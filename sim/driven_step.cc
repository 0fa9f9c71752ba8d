#include "sim/driven_step.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "sim/matrix_exponential.h"

namespace haptometer::sim {

Eigen::MatrixXd DrivenGenerator(const LinearModel& model, const SineDrive& drive) {
  const Eigen::Index n = model.states();
  const double omega = 2 * std::numbers::pi * drive.frequency_hz;
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(n + 2, n + 2);
  generator.topLeftCorner(n, n) = model.a;
  generator.block(0, n, n, 1) = drive.amplitude_v * model.b;
  generator(n, n + 1) = omega;
  generator(n + 1, n) = -omega;
  return generator;
}

Eigen::Vector2d DriveAt(double frequency_hz, long double t_s) {
  // whole cycles leave in 64 bits before the sine sees the rest
  const long double cycles = static_cast<long double>(frequency_hz) * t_s;
  const double phase_rad =
      2 * std::numbers::pi * static_cast<double>(cycles - std::nearbyint(cycles));
  return {std::sin(phase_rad), std::cos(phase_rad)};
}

Eigen::MatrixXd DrivenStep(const Eigen::MatrixXd& generator, double h_s) {
  const Eigen::Index n = generator.rows() - 2;
  const Eigen::MatrixXd exponential = MatrixExponential(h_s * generator);
  Eigen::MatrixXd step = exponential.topRows(n);
  const Eigen::Matrix2d turn = exponential.bottomRightCorner(2, 2);
  step.rightCols(2) *= turn.inverse();
  return step;
}

}  // namespace haptometer::sim
