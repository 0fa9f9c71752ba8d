#include "sim/smooth/smooth_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/circular_functions.h"
#include "base/error.h"
#include "sim/piecewise/guard.h"

namespace haptometer::sim {
namespace {

// what a step may leave out, over the tolerance of the whole motion
constexpr double kLocalPart = 0.3;
// below this the rounding of a step exceeds what it leaves out
constexpr double kLeastRelative = 0x1p-44;
// error of a guard's value, over the tolerance times the size of its terms
constexpr double kNoisePart = 0.01;
// the first tolerance over the scene's, its limits, and what ends the refinement
constexpr double kPart = 0.1;
constexpr double kLeastSolverTolerance = 4e-12;
constexpr double kMostSolverTolerance = 1e-5;
constexpr double kErrorPart = 0.25;
// what a halved step leaves out: 2^-11 with polynomials of degree 10
constexpr double kFiner = 2048;
// so many events, each within kCrowdedPart of an output step of the one before, are a stall
constexpr int kMostCrowdedEvents = 100;
constexpr double kCrowdedPart = 0x1p-40;  // of an output step
// Coefficients in u, 0 <= u <= 1, of a smooth function over a step: the polynomial through
// Chebyshev's points. Over a quarter of a period its error is 2e-15 of what a sine adds.
template <typename Function>
Eigen::VectorXd ThroughPoints(const Function& value) {
  constexpr Eigen::Index kPoints = 13;
  Eigen::MatrixXd powers(kPoints, kPoints);
  Eigen::VectorXd values(kPoints);
  for (Eigen::Index k = 0; k < kPoints; ++k) {
    // zeros of Chebyshev's polynomial on [0, 1]
    const double angle = (static_cast<double>(k) + 0.5) / kPoints * std::numbers::pi;
    const double u = (1 - Cos(angle)) / 2;
    values[k] = value(u);
    for (Eigen::Index j = 0; j < kPoints; ++j) powers(k, j) = j == 0 ? 1 : powers(k, j - 1) * u;
  }
  return powers.partialPivLu().solve(values);
}

// First u at which a guard falls below zero. One with an error of `noise` must fall below -noise;
// the event is then at its last zero before that.
std::optional<double> FallWithin(const Eigen::VectorXd& coefficients, double noise) {
  Eigen::VectorXd raised = coefficients;
  raised[0] += noise;
  const std::optional<double> u = FirstFall(raised, 0);
  if (!u || noise == 0) return u;
  return LastAbove(coefficients, *u);
}

}  // namespace

SolverLadder::SolverLadder(double scene_tolerance)
    : asked_(scene_tolerance),
      settings_{.tolerance = std::clamp(kPart * scene_tolerance, kLeastSolverTolerance,
                                        kMostSolverTolerance),
                .longest_step_periods = 1},
      before_(settings_) {
  before_.tolerance *= kFiner;
  before_.longest_step_periods *= 2;
}

bool SolverLadder::EndsWith(double error) const {
  return error <= kErrorPart * asked_ || settings_.tolerance <= kLeastSolverTolerance;
}

void SolverLadder::Refine() {
  before_ = settings_;
  settings_.tolerance = std::max(settings_.tolerance / kFiner, kLeastSolverTolerance);
  settings_.longest_step_periods /= 2;
}

SmoothMotion::ModeRun::ModeRun(const SmoothSystem& system, std::size_t mode,
                               const ExcitationPiece& piece, bool with_energy, double relative)
    : problem(system, mode, piece, with_energy), solver(problem, relative) {}

SmoothMotion::SmoothMotion(SmoothSystem system, Excitation excitation, PiecewiseStart start,
                           const OutputGrid& grid, const SmoothSettings& settings,
                           double temperature_rise_k)
    : system_(std::move(system)),
      excitation_(std::move(excitation)),
      rate_hz_(grid.rate_hz),
      grid_origin_s_(static_cast<long double>(grid.origin_s)),
      settings_(settings),
      runs_(system_.linear.modes.size()),
      mode_(start.mode),
      x_(std::move(start.x)),
      temperature_rise_k_(temperature_rise_k) {
  HAPTOMETER_CHECK(rate_hz_ > 0 && mode_ < runs_.size(), "{} Hz, mode {}", rate_hz_, mode_);
  HAPTOMETER_CHECK(grid.origin_s <= 0 && -grid.origin_s * rate_hz_ < 1, "origin {} s at {} Hz",
                   grid.origin_s, rate_hz_);
  HAPTOMETER_CHECK(x_.size() == system_.linear.modes[mode_].a.rows(), "{} states", x_.size());
  TakePiece(0);
  relative_ = std::max(kLocalPart * settings_.tolerance, kLeastRelative);
  Enter(Whole());
  ForgetRanges();
  if (!settings_.with_energy) return;
  flow_.integrals.assign(static_cast<std::size_t>(Run().problem.integrals()), 0);
  initial_j_ = Run().problem.StoredEnergy(0, x_);
}

void SmoothMotion::Restart(PiecewiseStart start, double temperature_rise_k) {
  HAPTOMETER_CHECK(!settings_.with_energy && grid_origin_s_ == 0,
                   "a motion with energies begins once");
  mode_ = start.mode;
  x_ = std::move(start.x);
  temperature_rise_k_ = temperature_rise_k;
  for (const std::unique_ptr<ModeRun>& run : runs_) {
    if (!run) continue;
    run->was_entered = false;
    run->solver.Reset();
  }
  index_ = 0;
  origin_s_ = 0;
  events_.clear();
  crowded_events_ = 0;
  steps_ = 0;
  stalled_at_s_.reset();
  stall_reason_.reset();
  TakePiece(0);
  Enter(Whole());
  ForgetRanges();
}

void SmoothMotion::Enter(Eigen::VectorXd y) {
  std::unique_ptr<ModeRun>& run = runs_[mode_];
  if (!run) {
    run = std::make_unique<ModeRun>(system_, mode_, piece_, settings_.with_energy, relative_);
  }
  run->problem.Begin(piece_, origin_s_);
  Eigen::VectorXd scale = run->problem.ScaleFrom(y);
  // scales only grow when a mode is entered again: a state may be small at the moment
  if (run->was_entered) scale = scale.cwiseMax(run->solver.scale());
  run->was_entered = true;
  const Eigen::VectorXd largest = scale.cwiseMax(y.cwiseAbs());
  run->solver.Begin({.y = std::move(y),
                     .scale = scale,
                     .integral_scale = run->problem.IntegralScale(largest),
                     .longest_step_s = LongestStepS()});
  // no guard counts as risen yet: the one just left is zero to within its error
  run->armed.assign(system_.linear.modes[mode_].guards.size(), false);
  fall_.reset();
  watched_until_s_ = output_tau_s_ = 0;
  Arm();
}

void SmoothMotion::TakePiece(std::size_t place) {
  place_ = place;
  piece_ = excitation_.Piece(place);
}

// s; a part of the fastest tone's period, without tones of an output step, of a short piece
double SmoothMotion::LongestStepS() const {
  const double highest_hz = HighestFrequencyHz(piece_);
  const double part = settings_.longest_step_periods / SmoothSettings{}.longest_step_periods;
  const double longest_s =
      highest_hz > 0 ? settings_.longest_step_periods / highest_hz : part / rate_hz_;
  const auto piece_s = static_cast<double>(piece_.end_s - piece_.begin_s);
  return piece_s > 0 ? std::min(longest_s, part * piece_s) : longest_s;
}

double SmoothMotion::TauOfPieceEnd() const {
  if (place_ + 1 == excitation_.size()) return std::numeric_limits<double>::infinity();
  return static_cast<double>(piece_.end_s - origin_s_);
}

void SmoothMotion::NextPiece() {
  const double tau_s = std::min(TauOfPieceEnd(), Run().solver.end_s());
  // ranges, state and integrals at the piece's end, before the solver begins again
  Watch(tau_s);
  Eigen::VectorXd y = Run().solver.At(tau_s);
  Pass(tau_s);
  origin_s_ = piece_.end_s;
  TakePiece(place_ + 1);
  Enter(std::move(y));
}

// adds the mode's integrals since its entry to the sums of the motion
void SmoothMotion::Pass(double tau_s) {
  if (!settings_.with_energy) return;
  const Eigen::VectorXd integrals = Run().solver.IntegralsAt(tau_s);
  for (std::size_t k = 0; k < flow_.integrals.size(); ++k) {
    flow_.integrals[k] += static_cast<long double>(integrals[static_cast<Eigen::Index>(k)]);
  }
}

void SmoothMotion::Next() {
  if (stalled_at_s_) return;
  const long double target_s = TimeOf(index_ + 1);
  for (;;) {
    // the first of: an event, the end of the piece, the output; else one more step of the solver
    const auto tau_s = static_cast<double>(target_s - origin_s_);
    const double piece_end_s = TauOfPieceEnd(), known_s = Run().solver.end_s();
    if (fall_ && fall_->tau_s <= std::min(tau_s, piece_end_s)) {
      Fire(*fall_);
    } else if (piece_end_s < tau_s && known_s >= piece_end_s) {
      NextPiece();
    } else if (known_s >= tau_s) {
      TakeOutput(tau_s);
      break;
    } else if (++steps_ > settings_.most_steps) {
      Stall(FindingKind::kTooManySteps);
    } else {
      Advance();
    }
    if (stalled_at_s_) return;
  }
  ++index_;
}

void SmoothMotion::TakeOutput(double tau_s) {
  output_tau_s_ = tau_s;
  const Eigen::VectorXd y = Run().solver.At(tau_s);
  const Eigen::Index n = system_.linear.modes[mode_].a.rows();
  x_ = y.head(n);
  if (system_.heating) temperature_rise_k_ = y(n);
}

const std::vector<ValueRange>& SmoothMotion::Ranges() {
  Watch(output_tau_s_);
  return ranges_;
}

void SmoothMotion::ForgetRanges() {
  const Mode& mode = system_.linear.modes[mode_];
  watched_until_s_ = output_tau_s_;
  ranges_.assign(mode.watched.size(), {});
  for (std::size_t k = 0; k < ranges_.size(); ++k) {
    ranges_[k].Include(Run().problem.Value(mode.watched[k], TauOfOutput(), x_));
  }
  if (!ranges_.empty()) temperature_peak_k_ = {temperature_rise_k_, temperature_rise_k_};
}

// Extends the ranges of the watched numbers and of the coil's rise from where they ended last.
void SmoothMotion::Watch(double tau_s) {
  const SemilinearSolver& solver = Run().solver;
  const double begin_s = solver.begin_s(), step_s = solver.end_s() - begin_s;
  if (ranges_.empty() || !(step_s > 0 && tau_s > watched_until_s_)) return;
  // the part of the last step not watched yet, in units of the step
  const double from = std::max(0.0, (watched_until_s_ - begin_s) / step_s);
  const double to = std::min(1.0, (tau_s - begin_s) / step_s);
  for (std::size_t k = 0; k < ranges_.size(); ++k) {
    const WatchedNumber& number = system_.linear.modes[mode_].watched[k];
    const Eigen::VectorXd polynomial = PolynomialOf(
        number,
        [&](double t_s, const Eigen::VectorXd& y) { return Run().problem.Value(number, t_s, y); });
    // both ends, then the extremes between them
    ranges_[k].Include(PolynomialValue(polynomial, from));
    ranges_[k].Include(PolynomialValue(polynomial, to));
    ExtendRange(polynomial, from, to, ranges_[k]);
  }
  if (system_.heating) {
    temperature_peak_k_.Include(solver.At(tau_s).tail(1).value());
    ExtendRange(solver.StepTerms().bottomRows(1).transpose(), from, to, temperature_peak_k_);
  }
  watched_until_s_ = tau_s;
}

void SmoothMotion::Advance() {
  // the new step's polynomial replaces the old one's
  Watch(Run().solver.end_s());
  if (!Run().solver.Step()) {
    Stall(FindingKind::kSolverStopped);
    return;
  }
  LookForFall();
  if (!fall_) Arm();
}

// bound of a guard's error: the tolerance of all its terms at their largest
double SmoothMotion::NoiseOf(std::size_t guard) {
  const Guard& that = system_.linear.modes[mode_].guards[guard];
  const double terms = that.row.cwiseAbs().dot(Run().solver.scale().head(that.row.size()));
  return kNoisePart * tolerance() * (terms + std::abs(that.offset));
}

// arms the guards that have risen above their own error; from then on any fall below zero counts
void SmoothMotion::Arm() {
  ModeRun& run = Run();
  if (std::ranges::all_of(run.armed, [](bool armed) { return armed; })) return;
  const Eigen::VectorXd y = run.solver.At(run.solver.end_s());
  for (std::size_t guard = 0; guard < run.armed.size(); ++guard) {
    run.armed[guard] =
        run.armed[guard] || run.problem.Value(guard, run.solver.end_s(), y) > NoiseOf(guard);
  }
}

// the guard that falls first within the step, with its time since the mode's entry
void SmoothMotion::LookForFall() {
  ModeRun& run = Run();
  const double begin_s = run.solver.begin_s(), step_s = run.solver.end_s() - begin_s;
  for (std::size_t guard = 0; guard < run.armed.size(); ++guard) {
    const Eigen::VectorXd polynomial = PolynomialOf(
        system_.linear.modes[mode_].guards[guard],
        [&](double t_s, const Eigen::VectorXd& y) { return run.problem.Value(guard, t_s, y); });
    const std::optional<double> u = FallWithin(polynomial, run.armed[guard] ? 0 : NoiseOf(guard));
    if (!u) continue;
    // rounding must not put the event after the end of the step
    const double tau_s = std::min(begin_s + *u * step_s, run.solver.end_s());
    if (!fall_ || tau_s < fall_->tau_s) fall_ = Fall{.guard = guard, .tau_s = tau_s};
  }
}

// Coefficients in u of a guard or a watched number over the step; `value` gives it at a time and a
// state. With a direct feed of the inputs it is no polynomial and is interpolated.
template <typename Number, typename Value>
Eigen::VectorXd SmoothMotion::PolynomialOf(const Number& that, const Value& value) {
  const SemilinearSolver& solver = Run().solver;
  const double begin_s = solver.begin_s(), step_s = solver.end_s() - begin_s;
  if (that.feed.size() > 0) {
    return ThroughPoints([&](double u) {
      const double t_s = begin_s + u * step_s;
      return value(t_s, solver.At(t_s));
    });
  }
  Eigen::VectorXd coefficients =
      (that.row * solver.StepTerms().topRows(that.row.size())).transpose();
  // the row alone lacks the offset
  coefficients[0] = value(begin_s, solver.StepTerms().col(0));
  return coefficients;
}

void SmoothMotion::Fire(const Fall& fall) {
  ModeRun& run = Run();
  Watch(fall.tau_s);
  const Eigen::VectorXd y = run.solver.At(fall.tau_s);
  // g' before the event: for a gap, minus the speed of approach in m/s
  const double rate = run.problem.Jet(fall.guard, fall.tau_s, y)[1];
  const std::size_t place = system_.linear.modes[mode_].guards[fall.guard].transition;
  // times count from the event from here on
  Pass(fall.tau_s);
  origin_s_ += static_cast<long double>(fall.tau_s);
  crowded_events_ = fall.tau_s * rate_hz_ < kCrowdedPart ? crowded_events_ + 1 : 0;
  const auto time_s = static_cast<double>(origin_s_);
  Eigen::VectorXd after = Follow(place, y, time_s, rate);
  const Transition& transition = system_.linear.transitions[place];
  // bounces too low to be computed: the bodies rest at once, the event has the time of their end
  if (const std::optional<double> rest_s = RestAfter(transition, after)) {
    after = Follow(transition.bounce->rest_via, after, time_s + *rest_s, 0);
  }
  Enter(std::move(after));
  if (crowded_events_ >= kMostCrowdedEvents) Stall(FindingKind::kEventsWithoutEnd);
}

Eigen::VectorXd SmoothMotion::Follow(std::size_t transition, const Eigen::VectorXd& y,
                                     double time_s, double guard_rate) {
  const Transition& way = system_.linear.transitions[transition];
  const Eigen::Index n = way.map.cols(), m = way.map.rows();
  Eigen::VectorXd after(m + y.size() - n);
  // x+ = map x + shift; the coil's temperature is continuous
  after.head(m) = way.map * y.head(n) + way.shift;
  after.tail(y.size() - n) = y.tail(y.size() - n);
  const auto stored_j = [&](std::size_t mode, const Eigen::VectorXd& state) {
    SmoothMode problem(system_, mode, piece_, true);
    problem.Begin(piece_, origin_s_);
    return problem.StoredEnergy(0, state);
  };
  // the decrease of the stored energy at the event is the loss of the impact, J
  if (settings_.with_energy) {
    flow_.impact_j += static_cast<long double>(stored_j(mode_, y) - stored_j(way.mode, after));
  }
  mode_ = way.mode;
  events_.push_back({.time_s = time_s, .transition = transition, .guard_rate = guard_rate});
  return after;
}

// bounces lower than the guard's error are not computed
std::optional<double> SmoothMotion::RestAfter(const Transition& transition,
                                              const Eigen::VectorXd& y) {
  if (!transition.bounce || !transition.departure) return {};
  SmoothMode problem(system_, mode_, piece_, false);
  problem.Begin(piece_, origin_s_);
  const std::size_t guard = transition.departure->guard;
  const double height = std::max(transition.bounce->rest_height, NoiseOf(guard));
  return TimeToRest(*transition.bounce, problem.Jet(guard, 0, y), height);
}

void SmoothMotion::Stall(FindingKind reason) {
  stalled_at_s_ = static_cast<double>(origin_s_ + static_cast<long double>(Run().solver.end_s()));
  stall_reason_ = reason;
  // in the coordinates of the mode that it ended in
  TakeOutput(Run().solver.end_s());
}

double SmoothMotion::tolerance() const { return relative_ / kLocalPart; }

SolverWork SmoothMotion::work() const {
  SolverWork work;
  for (const std::unique_ptr<ModeRun>& run : runs_) {
    if (run) work += run->solver.work();
  }
  return work;
}

long double SmoothMotion::TimeOf(std::uint64_t output) const {
  return grid_origin_s_ + static_cast<long double>(output) / static_cast<long double>(rate_hz_);
}

// from where the mode was entered to the output; output 0 is the beginning
double SmoothMotion::TauOfOutput() const {
  return index_ == 0 ? 0 : static_cast<double>(TimeOf(index_) - origin_s_);
}

// The state and the sums at the last output.

Eigen::VectorXd SmoothMotion::Positions() const {
  const Mode& mode = system_.linear.modes[mode_];
  if (mode.positions.size() == 0) return x_;
  return mode.positions * x_;
}

// the integrals up to the output
std::vector<double> SmoothMotion::IntegralsHere() const {
  HAPTOMETER_CHECK(settings_.with_energy, "no energies were kept");
  // after a stall the output lies behind the solver's last step
  const SemilinearSolver& solver = runs_[mode_]->solver;
  const double tau_s = std::clamp(TauOfOutput(), solver.begin_s(), solver.end_s());
  const Eigen::VectorXd since = solver.IntegralsAt(tau_s);
  std::vector<double> integrals;
  integrals.reserve(flow_.integrals.size());
  for (std::size_t k = 0; k < flow_.integrals.size(); ++k) {
    integrals.push_back(static_cast<double>(flow_.integrals[k]) +
                        since[static_cast<Eigen::Index>(k)]);
  }
  return integrals;
}

EnergyLedger SmoothMotion::Ledger() const {
  const std::vector<double> integrals = IntegralsHere();
  // order of the integrals: input, dissipating elements, squared rows, i^2
  const auto squares =
      integrals.end() - 1 - static_cast<std::ptrdiff_t>(system_.linear.squared_rows.size());
  return {.initial_j = initial_j_,
          .stored_j = runs_[mode_]->problem.StoredEnergy(TauOfOutput(), x_),
          .input_j = integrals.front(),
          .impact_j = static_cast<double>(flow_.impact_j),
          .dissipated_j{integrals.begin() + 1, squares}};
}

std::vector<double> SmoothMotion::SquareIntegrals() const {
  const std::vector<double> integrals = IntegralsHere();
  const auto end = integrals.end() - 1;
  return {end - static_cast<std::ptrdiff_t>(system_.linear.squared_rows.size()), end};
}

// the state with the coil's rise
Eigen::VectorXd SmoothMotion::Whole() const {
  Eigen::VectorXd y = x_;
  if (!system_.heating) return y;
  y.conservativeResize(y.size() + 1);
  y(y.size() - 1) = temperature_rise_k_;
  return y;
}

Eigen::VectorXd SmoothMotion::Rates() const {
  const Eigen::VectorXd rate = runs_[mode_]->problem.Rate(TauOfOutput(), Whole());
  const Mode& mode = system_.linear.modes[mode_];
  if (mode.positions.size() == 0) return rate.head(x_.size());
  return mode.positions * rate.head(x_.size());
}

Eigen::VectorXd SmoothMotion::Inputs() const {
  Eigen::VectorXd signals;
  FillSignals(piece_, std::max(0.0L, TimeOf(index_)), signals);
  return ShapeOf(piece_).rows * signals;
}

double SmoothMotion::CurrentA() const {
  return runs_[mode_]->problem.Current(TauOfOutput(), Whole());
}

}  // namespace haptometer::sim
