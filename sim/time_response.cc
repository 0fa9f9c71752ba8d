#include "sim/time_response.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/check.h"
#include "sim/matrix_exponential.h"
#include "sim/steady_state.h"

namespace haptometer::sim {

namespace {

// Times are taken apart into powers of two from 2^-64 s, where even the fastest state (L/R of
// microseconds) stands still to the last bit, up to 2^19 s.
constexpr int kSmallestExponent = -64;
constexpr int kPowers = 84;

// [sin, cos] of the drive's phase; whole cycles leave in 64 bits before the sine sees the rest
Eigen::Vector2d DriveAt(double frequency_hz, long double t_s) {
  const long double cycles = static_cast<long double>(frequency_hz) * t_s;
  const double phase_rad =
      2 * std::numbers::pi * static_cast<double>(cycles - std::nearbyint(cycles));
  return {std::sin(phase_rad), std::cos(phase_rad)};
}

// G of z = [x, sin w t, cos w t]
Eigen::MatrixXd Generator(const LinearModel& model, const SineDrive& drive) {
  const Eigen::Index n = model.states();
  const double omega = 2 * std::numbers::pi * drive.frequency_hz;
  Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(n + 2, n + 2);
  generator.topLeftCorner(n, n) = model.a;
  generator.block(0, n, n, 1) = drive.amplitude_v * model.b;
  generator(n, n + 1) = omega;
  generator(n + 1, n) = -omega;
  return generator;
}

Eigen::VectorXd InitialState(const LinearModel& model, const SineDrive& drive, Start start) {
  if (start == Start::kRest) return Eigen::VectorXd::Zero(model.states());
  return SolveSteadyState(model, drive, Skin{}).phasors.imag();
}

// S(h) = integral of exp(G' s) c c' exp(G s) over [0, h] as its Taylor series, |G| h <= 1/4:
// its terms h^(k+1) / (k+1)! M_k with M_0 = c c', M_(k+1) = G' M_k + M_k G fall faster than 2^-k/k!
Eigen::MatrixXd ShortGramian(const Eigen::MatrixXd& g, const Eigen::VectorXd& c, double h) {
  constexpr int kTerms = 16;
  Eigen::MatrixXd term = h * c * c.transpose();
  Eigen::MatrixXd sum = term;
  for (int k = 1; k <= kTerms; ++k) {
    term = (h / (k + 1)) * (g.transpose() * term + term * g).eval();
    sum += term;
  }
  return sum;
}

}  // namespace

TimeResponse::TimeResponse(const LinearModel& model, const SineDrive& drive, Start start)
    : TimeResponse(model, drive, InitialState(model, drive, start)) {}

TimeResponse::TimeResponse(const LinearModel& model, const SineDrive& drive,
                           Eigen::VectorXd initial)
    : states_(model.states()),
      frequency_hz_(drive.frequency_hz),
      generator_(Generator(model, drive)),
      initial_(std::move(initial)) {
  HAPTOMETER_CHECK(initial_.size() == states_, "{} of {} states", initial_.size(), states_);
  // each exponential on its own: squaring the smallest would lose what distinguishes it from 1
  powers_.reserve(kPowers);
  for (int k = 0; k < kPowers; ++k) {
    powers_.push_back(StepOver(std::ldexp(1.0, k + kSmallestExponent)));
  }
}

// exp(G h) = [[E, V], [0, R]], R the drive's turn over h. [E, V R^-1] gives the states from the
// states before and the drive *after* the step: what the bodies still feel of the drive lies near
// the end of a long step, so its phase is not carried across thousands of cycles.
Eigen::MatrixXd TimeResponse::StepOver(double h_s) const {
  const Eigen::MatrixXd exponential = MatrixExponential(h_s * generator_);
  Eigen::MatrixXd step = exponential.topRows(states_);
  const Eigen::Matrix2d turn = exponential.bottomRightCorner(2, 2);
  step.rightCols(2) *= turn.inverse();
  return step;
}

Eigen::VectorXd TimeResponse::StateAt(double t_s) const {
  HAPTOMETER_CHECK(t_s >= 0 && t_s < std::ldexp(1.0, kPowers + kSmallestExponent), "t_s = {}", t_s);
  Eigen::VectorXd z(states_ + 2);
  z.head(states_) = initial_;

  // largest power first; what has passed is a sum of powers of two, hence exact
  double passed_s = 0;
  for (int k = kPowers - 1; k >= 0; --k) {
    const double step_s = std::ldexp(1.0, k + kSmallestExponent);
    if (t_s - passed_s < step_s) continue;
    passed_s += step_s;
    z.tail(2) = DriveAt(frequency_hz_, static_cast<long double>(passed_s));
    z.head(states_) = (powers_[static_cast<std::size_t>(k)] * z).eval();
  }
  return z.head(states_);
}

Eigen::MatrixXd TimeResponse::Sample(double start_s, double rate_hz, std::size_t count) const {
  HAPTOMETER_CHECK(rate_hz > 0, "rate_hz = {}", rate_hz);
  Eigen::MatrixXd samples(states_, static_cast<Eigen::Index>(count));
  if (count == 0) return samples;
  const Eigen::MatrixXd step = StepOver(1 / rate_hz);
  Eigen::VectorXd z(states_ + 2);
  samples.col(0) = StateAt(start_s);
  for (Eigen::Index i = 1; i < samples.cols(); ++i) {
    // the drive at this sample, from its number and not from a sum of steps
    const long double t_s = static_cast<long double>(start_s) +
                            static_cast<long double>(i) / static_cast<long double>(rate_hz);
    z.head(states_) = samples.col(i - 1);
    z.tail(2) = DriveAt(frequency_hz_, t_s);
    samples.col(i).noalias() = step * z;
  }
  return samples;
}

double TimeResponse::WindowRms(Eigen::Index state, double begin_s, double end_s) const {
  HAPTOMETER_CHECK(begin_s >= 0 && end_s > begin_s, "[{}, {}] s", begin_s, end_s);
  const double length_s = end_s - begin_s;
  const BalancedMatrix balanced = Balance(generator_);

  // an interval so short that its series converges at once, 2^-doublings of the window
  const double norm = balanced.matrix.cwiseAbs().colwise().sum().maxCoeff() * length_s;
  const int doublings = std::max(0, 2 + std::ilogb(norm) + 1);
  const double short_s = std::ldexp(length_s, -doublings);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(states_ + 2);
  c(state) = balanced.scale(state);
  Eigen::MatrixXd gramian = ShortGramian(balanced.matrix, c, short_s);

  // twice the interval: its first half, and its second half seen from the beginning
  for (int k = 0; k < doublings; ++k) {
    const Eigen::MatrixXd e = MatrixExponential(std::ldexp(short_s, k) * balanced.matrix);
    gramian += (e.transpose() * gramian * e).eval();
  }
  Eigen::VectorXd z(states_ + 2);
  z << StateAt(begin_s), DriveAt(frequency_hz_, static_cast<long double>(begin_s));
  z = z.cwiseQuotient(balanced.scale);
  return std::sqrt(std::max(0.0, z.dot(gramian * z)) / length_s);
}

}  // namespace haptometer::sim
