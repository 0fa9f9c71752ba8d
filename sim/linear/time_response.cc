#include "sim/linear/time_response.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/circular_functions.h"
#include "sim/linear/excitation.h"
#include "sim/linear/mode.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/window_rms.h"

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

}  // namespace

TimeResponse::TimeResponse(const LinearModel& model, const SineDrive& drive, Start start)
    : TimeResponse(model, drive, StateAtStart(model, drive, start)) {
  is_steady_ = start == Start::kSteady;
}

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
  HAPTOMETER_CHECK(t_s >= 0 && t_s < std::ldexp(1.0, kPowers + kSmallestExponent), "t_s = {}", t_s);
  Eigen::VectorXd z = Eigen::VectorXd::Zero(states_ + 2);
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

Eigen::MatrixXd TimeResponse::Step(double h_s) const {
  if (long_generator_.size() == 0) return DrivenStep(generator_, h_s, 2);
  return LongDrivenStep(long_generator_, static_cast<long double>(h_s), 2).cast<double>();
}

double TimeResponse::WindowRms(Eigen::Index state, double begin_s, double end_s) const {
  LinearMotion motion{.a = model_.a.cast<long double>(),
                      .b = model_.b.cast<long double>(),
                      .amplitude_v = drive_.amplitude_v,
                      .frequency_hz = drive_.frequency_hz,
                      .initial = {}};
  if (model_.a_rest.size() > 0) {
    motion.a += model_.a_rest.cast<long double>();
    motion.b += model_.b_rest.cast<long double>();
  }
  if (!is_steady_) motion.initial = initial_.cast<long double>();
  return WindowRmsOf(motion, state, static_cast<long double>(begin_s),
                     static_cast<long double>(end_s))
      .rms;
}

}  // namespace haptometer::sim
