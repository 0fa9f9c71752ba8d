#include "sim/linear/time_response.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/circular_functions.h"
#include "sim/linear/excitation.h"
#include "sim/linear/mode.h"
#include "sim/linear/steady_state.h"

namespace haptometer::sim {

HermiteQuintic::HermiteQuintic(const MotionJet& begin, const MotionJet& end, double h_s) {
  // in units of u = t / h, 0 <= u <= 1
  const double v0 = begin.v * h_s, v1 = end.v * h_s;
  const double a0 = begin.a * h_s * h_s, a1 = end.a * h_s * h_s, d = end.x - begin.x;
  // position, speed and acceleration at both ends fix six coefficients
  c_ = {begin.x,
        v0,
        a0 / 2,
        10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
        -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
        6 * d - 3 * (v0 + v1) + 0.5 * (a1 - a0)};
}

double HermiteQuintic::At(double u) const {
  return c_[0] + u * (c_[1] + u * (c_[2] + u * (c_[3] + u * (c_[4] + u * c_[5]))));
}

double HermiteQuintic::Slope(double u) const {
  return c_[1] + u * (2 * c_[2] + u * (3 * c_[3] + u * (4 * c_[4] + u * 5 * c_[5])));
}

ValueRange HermiteQuintic::Range() const {
  constexpr int kHalvings = 40;  // an extreme is flat: 2^-26 would do
  ValueRange range;
  range.Include(At(0));
  range.Include(At(1));
  const bool rises = Slope(0) > 0;
  // a slope of one sign: the extremes are at the ends
  if ((Slope(1) > 0) == rises) return range;
  double low = 0, high = 1;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = 0.5 * (low + high);
    ((Slope(middle) > 0) == rises ? low : high) = middle;
  }
  range.Include(At(low));
  return range;
}

namespace {

// A time is a sum of powers of two from 2^-64 s, where even the fastest state (L/R of
// microseconds) does not change in any bit, up to 2^19 s.
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
    : states_(model.states()), model_(model), drive_(drive), initial_(std::move(initial)) {
  HAPTOMETER_CHECK(initial_.size() == states_, "{} of {} states", initial_.size(), states_);
  const Mode mode{.name = {},
                  .a = model.a,
                  .b = model.b,
                  .positions = {},
                  .stored_j = {},
                  .current_row = {},
                  .a_rest = model.a_rest,
                  .b_rest = model.b_rest};
  const SineDrive sine{.amplitude_v = drive.amplitude_v, .frequency_hz = drive.frequency_hz};
  const ExcitationShape shape = ShapeOf(Excitation(sine).Piece(0));
  generator_ = DrivenGenerator(mode.a, mode.Inputs(), shape);
  if (mode.a_rest.size() > 0) long_generator_ = LongDrivenGenerator(mode, shape);
  // each exponential on its own: squaring the smallest would lose what distinguishes it from 1
  powers_.reserve(kPowers);
  for (int k = 0; k < kPowers; ++k) powers_.push_back(Step(std::ldexp(1.0, k + kSmallestExponent)));
}

Eigen::VectorXd TimeResponse::StateAt(double t_s) const {
  return StateAt(t_s, initial_, Motion::kDriven);
}

Eigen::VectorXd TimeResponse::StateAt(double t_s, const Eigen::VectorXd& initial,
                                      Motion motion) const {
  HAPTOMETER_CHECK(t_s >= 0 && t_s < std::ldexp(1.0, kPowers + kSmallestExponent), "t_s = {}", t_s);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(states_ + 2);
  z.head(states_) = initial;

  // largest power first; what has passed is a sum of powers of two, hence exact
  double passed_s = 0;
  for (int k = kPowers - 1; k >= 0; --k) {
    const double step_s = std::ldexp(1.0, k + kSmallestExponent);
    if (t_s - passed_s < step_s) continue;
    passed_s += step_s;
    if (motion == Motion::kDriven) {
      z.tail(2) = DriveAt(drive_.frequency_hz, static_cast<long double>(passed_s));
    }
    z.head(states_) = (powers_[static_cast<std::size_t>(k)] * z).eval();
  }
  return z.head(states_);
}

Eigen::MatrixXd TimeResponse::Step(double h_s) const {
  if (long_generator_.size() == 0) return DrivenStep(generator_, h_s, 2);
  return LongDrivenStep(long_generator_, static_cast<long double>(h_s), 2).cast<double>();
}

Eigen::MatrixXd TimeResponse::Exponential(double h_s, Motion motion) const {
  Eigen::MatrixXd e = long_generator_.size() == 0
                          ? MatrixExponential(h_s * generator_)
                          : LongMatrixExponential(long_generator_, static_cast<long double>(h_s))
                                .cast<double>()
                                .eval();
  if (motion == Motion::kFree) e.topRightCorner(states_, 2).setZero();
  return e;
}

double TimeResponse::OutputRms(const Eigen::VectorXd& output, const Eigen::VectorXd& initial,
                               Motion motion, double begin_s, double end_s) const {
  const double length_s = end_s - begin_s;
  Eigen::MatrixXd generator = generator_;
  if (motion == Motion::kFree) generator.topRightCorner(states_, 2).setZero();
  const BalancedMatrix balanced = Balance(generator);

  // an interval so short that its series converges at once, 2^-doublings of the window
  const double norm = balanced.matrix.cwiseAbs().colwise().sum().maxCoeff() * length_s;
  const int doublings = std::max(0, 2 + std::ilogb(norm) + 1);
  const double short_s = std::ldexp(length_s, -doublings);
  Eigen::MatrixXd gramian =
      ShortGramian(balanced.matrix, output.cwiseProduct(balanced.scale), short_s);

  // S(2h) = S(h) + exp(G' h) S(h) exp(G h): the first half and the second, from the begin
  for (int k = 0; k < doublings; ++k) {
    const Eigen::MatrixXd e = balanced.scale.cwiseInverse().asDiagonal() *
                              Exponential(std::ldexp(short_s, k), motion) *
                              balanced.scale.asDiagonal();
    gramian += (e.transpose() * gramian * e).eval();
  }
  Eigen::VectorXd z(states_ + 2);
  z << StateAt(begin_s, initial, motion),
      DriveAt(drive_.frequency_hz, static_cast<long double>(begin_s));
  z = z.cwiseQuotient(balanced.scale);
  // integral of the output's square = z' S z at the begin of the window
  return std::sqrt(std::max(0.0, z.dot(gramian * z)) / length_s);
}

double TimeResponse::WindowRms(Eigen::Index state, double begin_s, double end_s) const {
  HAPTOMETER_CHECK(begin_s >= 0 && end_s > begin_s, "[{}, {}] s", begin_s, end_s);
  constexpr double kKnown = 1e-9;  // relative error of the phasors
  Eigen::VectorXd output = Eigen::VectorXd::Zero(states_ + 2);
  output(state) = 1;
  const SteadyState steady = SolveSteadyState(model_, drive_, Skin{});
  if (steady.error_estimate < kKnown) {
    Eigen::VectorXd parts = output;
    parts.tail(2) << steady.phasors(state).real(), steady.phasors(state).imag();
    const double rms =
        OutputRms(parts, initial_ - steady.phasors.imag(), Motion::kFree, begin_s, end_s);
    // a steady part that is far larger than the motion: a resonance that still builds up
    if (Abs(steady.phasors(state)) <= 2 * rms) return rms;
  }
  return OutputRms(output, initial_, Motion::kDriven, begin_s, end_s);
}

}  // namespace haptometer::sim
