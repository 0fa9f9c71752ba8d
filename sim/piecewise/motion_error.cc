#include "sim/piecewise/motion_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/piecewise/piecewise_motion.h"

namespace haptometer::sim {
namespace {

// error of a guard over g'^2 / (2 abs(g'')) up to which an event is moved in time only
constexpr double kLinearPart = 0.05;

}  // namespace

void MotionError::Step(const Eigen::Ref<const Eigen::MatrixXd>& phi,
                       const Eigen::VectorXd& rounding) {
  // P <- Phi P Phi' + diag(rounding^2)
  // products of so few rows are faster without blocks
  work_.noalias() = phi.lazyProduct(covariance_);
  covariance_.noalias() = work_.lazyProduct(phi.transpose());
  covariance_.diagonal() += rounding.cwiseAbs2();
}

void MotionError::Add(const Eigen::VectorXd& error) {
  covariance_.noalias() += error * error.transpose();
}

void MotionError::Map(const Eigen::MatrixXd& map, const Eigen::VectorXd& error) {
  covariance_ = (map * covariance_ * map.transpose()).eval();
  Add(error);
}

void MotionError::Event(const EventJump& jump) {
  // f+ - R f-, the jump of the rate
  const Eigen::VectorXd rate_step = jump.rate_after - jump.map * jump.rate_before;
  const double error = Bound(jump.guard), speed = std::abs(jump.guard_rate);
  const double bend = std::abs(jump.guard_curvature);
  if (2 * error * bend <= kLinearPart * speed * speed && speed > 0) {
    // saltation matrix S = R + (f+ - R f-) (dg/dx) / g'
    const Eigen::VectorXd by_guard = rate_step / jump.guard_rate;
    Map(jump.map + by_guard * jump.guard, jump.guard_rounding * by_guard);
    return;
  }
  // near a graze the time is uncertain by this much, and the event itself may not occur
  double time_s = bend > 0 ? std::sqrt(2 * error / bend) : error / speed;
  if (!std::isfinite(time_s)) time_s = 0;
  Map(jump.map, 2 * time_s / kSafety * rate_step);
  if (jump.step_of_state.size() > 0) Add(jump.step_of_state / kSafety);
}

// kSafety standard deviations of row x
double MotionError::Bound(const Eigen::RowVectorXd& row) const {
  const double square = row.dot(covariance_ * row.transpose());
  if (!std::isfinite(square)) return std::numeric_limits<double>::infinity();
  return kSafety * std::sqrt(std::max(square, 0.0));
}

// The error that a piecewise motion carries (motion_error.h).

namespace {

// unit roundoff of a double
constexpr double kRounding = 0x1p-53;
// outputs that the error is carried over at once before anything happens
constexpr std::size_t kFarPower = 6;
// the steps of an event's place beyond these halvings
constexpr int kStillLevels = 12;
constexpr double kStillSteps = 8;  // the root of their number, and more
// a guard that turns so near zero, as a part of its terms, may come within the error
constexpr double kNearZero = 0x1p-30;

// a guard that turns between two points
struct Turn {
  double least = 0;
  double bend = 0;  // g'' as a difference
};

std::optional<Turn> TurnBetween(const GuardJet& begin, const GuardJet& end, double h_s) {
  if (begin[1] >= 0 || end[1] <= 0) return {};
  const HermiteQuintic between({begin[0], begin[1], begin[2]}, {end[0], end[1], end[2]}, h_s);
  return Turn{between.Range().least, (end[1] - begin[1]) / h_s};
}

}  // namespace

// rounding of a step's sums, and of the entries of its matrix
Eigen::VectorXd PiecewiseMotion::RoundingOf(const Point& from, int level, const Point& to) {
  const Eigen::MatrixXd& step = Stepper().Step(level);
  const Eigen::Index n = from.x.size();
  const double h_s = std::ldexp(1 / rate_hz_, -level);
  Eigen::VectorXd terms = step.leftCols(n).cwiseAbs() * from.x.cwiseAbs();
  terms += step.rightCols(to.drive.size()).cwiseAbs() * to.drive.cwiseAbs();
  // a state that decays faster than the step retains rounding for its decay time only
  const Eigen::MatrixXd& a = Stepper().mode().a;
  const Eigen::VectorXd forgets_s = a.diagonal().cwiseAbs().cwiseInverse().cwiseMin(h_s);
  terms += forgets_s.cwiseProduct(a.cwiseAbs() * from.x.cwiseAbs());
  return kRounding * terms;
}

void PiecewiseMotion::CarryError(const Point& from, int level, const Point& to) {
  // so short a step turns nothing by more than a hundredth; its rounding is included in the event's
  if (level > Stepper().CoarsestLevel() + kStillLevels) return;
  NoticeNearMiss(from, to);
  flow_.error->Step(Stepper().Step(level).leftCols(from.x.size()), RoundingOf(from, level, to));
}

// Over outputs in which nothing happened.
void PiecewiseMotion::CarryErrorFar() {
  constexpr std::uint64_t kFar = std::uint64_t{1} << kFarPower;
  if (!flow_.error || flow_.error_by_steps || index_ % kFar != 0) return;
  CarryErrorTo(index_);
}

// in as few long steps as the number of outputs has binary digits that are set
void PiecewiseMotion::CarryErrorTo(std::uint64_t output) {
  for (std::size_t power = kFarPower + 1; power-- > 0;) {
    const std::uint64_t outputs = std::uint64_t{1} << power;
    if (flow_.error_index + outputs > output) continue;
    const Eigen::Index n = now_.x.size();
    const Eigen::MatrixXd far = Stepper().LongStep(power).leftCols(n).cast<double>();
    // the rounding of that many steps, as if all had the same sign
    flow_.error->Step(far, static_cast<double>(outputs) * RoundingOf(now_, 0, now_));
    flow_.error_index += outputs;
  }
}

// From the output before now on.
void PiecewiseMotion::CarryErrorBySteps() {
  if (!flow_.error || flow_.error_by_steps) return;
  CarryErrorTo(index_);
  flow_.error_by_steps = true;
}

Eigen::VectorXd PiecewiseMotion::RateIn(std::size_t mode, const Point& point) const {
  const Mode& that = system_.modes[mode];
  return that.a * point.x + that.Inputs() * (shape().rows * point.drive);
}

void PiecewiseMotion::CarryErrorOver(std::size_t guard, const Transition& way, const Point& before,
                                     std::size_t mode_before) {
  const Guard& that = system_.modes[mode_before].guards[guard];
  const GuardBound& bound = shapes_[active_].steppers[mode_before].Guards()[guard];
  const GuardJet jet = bound.Jet(before.x, before.drive);
  const double terms = that.row.cwiseAbs().dot(before.x.cwiseAbs()) + std::abs(that.offset);
  const double tick_s = std::ldexp(1 / rate_hz_, -kFinestLevel);
  // the guard's own sum, and the motion within the tick to which the event is located
  EventJump jump{.map = way.map,
                 .guard = that.row,
                 .guard_rate = jet[1],
                 .guard_curvature = jet[2],
                 .guard_rounding = 2 * kRounding * terms + tick_s * std::abs(jet[1]),
                 .rate_before = RateIn(mode_before, before),
                 .rate_after = RateIn(mode_, now_),
                 .step_of_state = {}};
  if (mode_ == mode_before) jump.step_of_state = now_.x - before.x;
  const Eigen::Index n = before.x.size();
  // rounding of the shorter and shorter steps that located the event
  flow_.error->Step(Eigen::MatrixXd::Identity(n, n), kStillSteps * kRounding * before.x.cwiseAbs());
  flow_.error->Event(jump);
}

// What the bounces that are not played would do to the bodies together. A relative motion d
// of height h = u^2/(2 a) and flights of 2u/a, 2ue/a ... has the integral I of d dt = 2/3 h 2u/a /
// (1 - e^3), and moves the rest by A A p I, p the direction of the relative speed.
void PiecewiseMotion::CarryErrorToRest(const Transition& rest, const Bounce& bounce,
                                       const Eigen::VectorXd& step) {
  const GuardJet jet = JetHere(departure_->guard);
  const double speed = std::max(jet[1], 0.0), acceleration = -jet[2];
  const Eigen::MatrixXd& a = Stepper().mode().a;
  const double turned = Stepper().mode().guards[departure_->guard].row.dot(a * step);
  Eigen::VectorXd tail = Eigen::VectorXd::Zero(rest.map.rows());
  if (turned > 0 && speed > 0) {
    const double e = bounce.restitution;
    const double integral =
        2 * speed * speed * speed / (3 * acceleration * acceleration) / (1 - e * e * e);
    tail = integral / turned * (rest.map * (a * (a * step)));
  }
  flow_.error->Map(rest.map, tail);
}

// Whether a guard turns where the error may decide whether it falls.
bool PiecewiseMotion::TurnsNearZero(const Point& from, const Point& to) {
  const double h_s = std::ldexp(static_cast<double>(to.tick - from.tick) / rate_hz_, -kFinestLevel);
  const std::vector<GuardBound>& guards = Stepper().Guards();
  for (std::size_t k = 0; k < guards.size(); ++k) {
    const Guard& guard = Stepper().mode().guards[k];
    const double terms = guard.row.cwiseAbs().dot(from.x.cwiseAbs()) + std::abs(guard.offset);
    const auto turn =
        TurnBetween(guards[k].Jet(from.x, from.drive), guards[k].Jet(to.x, to.drive), h_s);
    if (turn && turn->least <= kNearZero * terms) return true;
  }
  return false;
}

// A guard that turns just above zero may have fallen: the jump of that event, added as an error.
void PiecewiseMotion::NoticeNearMiss(const Point& from, const Point& to) {
  const double h_s = std::ldexp(static_cast<double>(to.tick - from.tick) / rate_hz_, -kFinestLevel);
  const std::vector<GuardBound>& guards = Stepper().Guards();
  for (std::size_t k = 0; k < guards.size(); ++k) {
    const Guard& guard = Stepper().mode().guards[k];
    const Transition& way = system_.transitions[guard.transition];
    if (way.mode != mode_) continue;
    const auto turn =
        TurnBetween(guards[k].Jet(from.x, from.drive), guards[k].Jet(to.x, to.drive), h_s);
    if (!turn) continue;
    const double error = flow_.error->Bound(guard.row);
    if (turn->least > error) continue;
    // jump of the rate at the event that may have occurred, over twice the uncertainty of its time
    const Eigen::VectorXd rate = RateIn(mode_, from);
    flow_.error->Add(2 * std::sqrt(2 * error / turn->bend) / MotionError::kSafety *
                     (way.map * rate - rate));
  }
}

double PiecewiseMotion::ErrorOf(const Eigen::RowVectorXd& positions_row) const {
  const Mode& mode = system_.modes[mode_];
  if (mode.positions.size() == 0) return flow_.error->Bound(positions_row);
  return flow_.error->Bound(positions_row * mode.positions);
}

double PiecewiseMotion::ErrorOfCurrent() const {
  return flow_.error->Bound(system_.modes[mode_].current_row);
}

}  // namespace haptometer::sim
