#include "sim/time_response.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "sim/driven_step.h"
#include "sim/matrix_exponential.h"
#include "sim/steady_state.h"
#include "sim/uniform_motion.h"

namespace haptometer::sim {

namespace {

// Times are taken apart into powers of two from 2^-64 s, where even the fastest state (L/R of
// microseconds) stands still to the last bit, up to 2^19 s.
constexpr int kSmallestExponent = -64;
constexpr int kPowers = 84;

Eigen::VectorXd StateAtStart(const LinearModel& model, const SineDrive& drive, Start start) {
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
    : TimeResponse(model, drive, StateAtStart(model, drive, start)) {}

TimeResponse::TimeResponse(const LinearModel& model, const SineDrive& drive,
                           Eigen::VectorXd initial)
    : states_(model.states()),
      model_(model),
      drive_(drive),
      generator_(DrivenGenerator(model, drive)),
      initial_(std::move(initial)) {
  HAPTOMETER_CHECK(initial_.size() == states_, "{} of {} states", initial_.size(), states_);
  // each exponential on its own: squaring the smallest would lose what distinguishes it from 1
  powers_.reserve(kPowers);
  for (int k = 0; k < kPowers; ++k) {
    powers_.push_back(DrivenStep(model_, drive_, std::ldexp(1.0, k + kSmallestExponent)));
  }
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
    z.tail(2) = DriveAt(drive_.frequency_hz, static_cast<long double>(passed_s));
    z.head(states_) = (powers_[static_cast<std::size_t>(k)] * z).eval();
  }
  return z.head(states_);
}

Eigen::MatrixXd TimeResponse::Sample(double start_s, double rate_hz, std::size_t count) const {
  return UniformMotion(model_, drive_, StateAt(start_s), start_s, rate_hz, count);
}

Eigen::MatrixXd TimeResponse::Exponential(double h_s) const {
  if (model_.a_rest.size() == 0) return MatrixExponential(h_s * generator_);
  const auto length_s = static_cast<long double>(h_s);
  return LongMatrixExponential(LongDrivenGenerator(model_, drive_), length_s).cast<double>();
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
    const Eigen::MatrixXd e = balanced.scale.cwiseInverse().asDiagonal() *
                              Exponential(std::ldexp(short_s, k)) * balanced.scale.asDiagonal();
    gramian += (e.transpose() * gramian * e).eval();
  }
  Eigen::VectorXd z(states_ + 2);
  z << StateAt(begin_s), DriveAt(drive_.frequency_hz, static_cast<long double>(begin_s));
  z = z.cwiseQuotient(balanced.scale);
  return std::sqrt(std::max(0.0, z.dot(gramian * z)) / length_s);
}

}  // namespace haptometer::sim
