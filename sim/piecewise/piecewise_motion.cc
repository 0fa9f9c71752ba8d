#include "sim/piecewise/piecewise_motion.h"

#include <cmath>
#include <limits>

#include "base/error.h"

namespace haptometer::sim {
namespace {

// so many events, each within kCrowdedTicks of the one before, are a stall
constexpr int kMostCrowdedEvents = 100;
constexpr std::uint64_t kCrowdedTicks = kTicks >> 40;
// largest factor by which an uncertain gap may raise the height of bounces that count as at rest
constexpr double kMostRestHeights = 1e4;

}  // namespace

PiecewiseMotion::PiecewiseMotion(PiecewiseLinearSystem system, Excitation excitation,
                                 PiecewiseStart start, const OutputGrid& grid, bool with_energy)
    : system_(std::move(system)),
      excitation_(std::move(excitation)),
      rate_hz_(grid.rate_hz),
      origin_s_(static_cast<long double>(grid.origin_s)),
      with_energy_(with_energy),
      mode_(start.mode),
      now_{.x = std::move(start.x), .drive = {}},
      anchor_(now_.x) {
  HAPTOMETER_CHECK(rate_hz_ > 0 && mode_ < system_.modes.size(), "{} Hz, mode {}", rate_hz_, mode_);
  const double passed = -grid.origin_s * rate_hz_;  // of the first output step
  HAPTOMETER_CHECK(passed >= 0 && passed < 1, "origin {} s at {} Hz", grid.origin_s, rate_hz_);
  // t = 0 within the first output step, in ticks of 2^-kFinestLevel of a step
  now_.tick = static_cast<std::uint64_t>(std::ldexp(passed, kFinestLevel));
  HAPTOMETER_CHECK(now_.x.size() == system_.modes[mode_].a.rows(), "{} states", now_.x.size());
  BeginPiece(0);
  ForgetRanges();
  if (!with_energy_) return;
  flow_.dissipated_j.assign(system_.dissipating_elements.size(), 0);
  flow_.squares.assign(system_.squared_rows.size(), 0);
  initial_j_ = StoredNow();
  // the initial state has its own rounding, a few times that of a solution
  const Eigen::Index n = now_.x.size();
  flow_.error.emplace(n).Step(Eigen::MatrixXd::Identity(n, n), 0x1p-50 * now_.x.cwiseAbs());
}

void PiecewiseMotion::Restart(PiecewiseStart start) {
  HAPTOMETER_CHECK(!with_energy_ && origin_s_ == 0, "a motion with energies begins once");
  HAPTOMETER_CHECK(start.x.size() == system_.modes[start.mode].a.rows(), "{} states",
                   start.x.size());
  mode_ = start.mode;
  now_ = {.x = std::move(start.x), .drive = {}};
  anchor_ = now_.x;
  index_ = anchor_index_ = 0;
  departure_.reset();
  events_.clear();
  intervals_ = 0;
  crowded_events_ = 0;
  last_event_tick_ = 0;
  stalled_at_s_.reset();
  stall_reason_.reset();
  BeginPiece(0);
  ForgetRanges();
}

// Pieces that differ in numbers only share their matrices.
std::size_t PiecewiseMotion::PlaceOfShape() {
  const auto found = std::ranges::find_if(
      shapes_, [&](const Shape& shape) { return SameShape(shape.first, piece_); });
  if (found != shapes_.end()) return static_cast<std::size_t>(found - shapes_.begin());
  Shape& shape = shapes_.emplace_back();
  shape.first = piece_;
  shape.shape = ShapeOf(piece_);
  for (const Mode& mode : system_.modes) {
    shape.steppers.emplace_back(system_, mode, shape.shape, rate_hz_);
  }
  return shapes_.size() - 1;
}

// The state at now_ stays; matrices, signals and the piece's end are those of the new piece.
void PiecewiseMotion::BeginPiece(std::size_t place) {
  place_ = place;
  piece_ = excitation_.Piece(place);
  active_ = PlaceOfShape();
  largest_signals_ = LargestSignals(piece_);
  FillSignals(piece_, std::max(TimeAt(now_.tick), piece_.begin_s), now_.drive);
  SetSequences();
  if (place + 1 == excitation_.size()) {
    piece_end_index_ = std::numeric_limits<std::uint64_t>::max();
    return;
  }
  // the piece's end as a whole number of output steps and the ticks after it
  const long double outputs = (piece_.end_s - origin_s_) * static_cast<long double>(rate_hz_);
  // a time within a double's rounding of an output is that output
  const long double nearest = std::round(outputs);
  const bool at_output = std::abs(outputs - nearest) <= 0x1p-50L * std::max(outputs, 1.0L);
  const long double whole = at_output ? nearest : std::floor(outputs);
  const long double part = std::ldexp(outputs - whole, kFinestLevel);
  piece_end_index_ = static_cast<std::uint64_t>(whole);
  piece_end_tick_ = at_output ? 0 : static_cast<std::uint64_t>(std::round(part));
  if (piece_end_tick_ > 0 || piece_end_index_ == 0) return;
  // an output ends the step before it
  --piece_end_index_;
  piece_end_tick_ = kTicks;
}

void PiecewiseMotion::SetSequences() {
  constexpr long double kWorthIt = 64;
  sequences_.clear();
  // a piece of fewer outputs has its signals evaluated one by one
  if ((piece_.end_s - piece_.begin_s) * static_cast<long double>(rate_hz_) < kWorthIt) return;
  for (const ExcitationTerm& term : piece_.terms) {
    if (term.kind == ExcitationTerm::Kind::kPolynomial) continue;
    sequences_.emplace_back(term.frequency_hz, static_cast<double>(origin_s_) - term.origin_s,
                            rate_hz_);
  }
}

bool PiecewiseMotion::PlainSine() const {
  return piece_.terms.size() == 1 && sequences_.size() == 1 &&
         piece_.terms[0].kind == ExcitationTerm::Kind::kTone && piece_.terms[0].phase_rad == 0;
}

// Number of next outputs that need no guard, range, energy or new state; the output at the next
// anchor is computed by Next().
Eigen::Index PiecewiseMotion::OutputsUnwatched() {
  const Mode& mode = Stepper().mode();
  const Eigen::Index n = now_.x.size();
  const bool watched = !mode.guards.empty() || !mode.watched.empty() || with_energy_ ||
                       departure_ || now_.tick > 0 || PieceEndsWithin();
  if (watched || mode.positions.size() > 0 || n < 4 || n > LinearModel::kMostStates) return 0;
  if (!PlainSine() || piece_.terms[0].input != kVoltage) return 0;
  const std::uint64_t since = (index_ - anchor_index_) % kOutputsBetweenAnchors;
  return static_cast<Eigen::Index>(
      std::min(kOutputsBetweenAnchors - 1 - since, piece_end_index_ - index_));
}

void PiecewiseMotion::SignalsAtOutput(std::uint64_t output, Eigen::VectorXd& w) {
  if (PlainSine()) {
    w = sequences_[0].At(output);
    return;
  }
  const long double outputs = static_cast<long double>(output);
  FillSignals(piece_, origin_s_ + outputs / static_cast<long double>(rate_hz_), w);
}

void PiecewiseMotion::Next() {
  if (stalled_at_s_) return;
  // where one matrix product covers the output step, its two ends may clear all guards at once
  const bool may_clear =
      !departure_ && now_.tick == 0 && Stepper().CoarsestLevel() == 0 && !PieceEndsWithin();
  if (may_clear) Step(now_, 0, next_);
  if (may_clear && ClearAtOnce(next_)) {
    TakeStock(now_, 0, next_);
    std::swap(now_, next_);
  } else {
    Play();
  }
  if (stalled_at_s_) return;
  ++index_;
  now_.tick = 0;
  Reanchor();
  CarryErrorFar();
}

// whether both ends of the output step prove that no guard falls within it
bool PiecewiseMotion::ClearAtOnce(const Point& end) {
  const double h_s = 1 / rate_hz_;
  return std::ranges::all_of(Stepper().Guards(), [&](const GuardBound& guard) {
    const double least = std::min(guard.Value(now_.x, now_.drive), guard.Value(end.x, end.drive));
    // g >= min(g(0), g(h)) - max abs(g'') h^2 / 8
    return least > guard.SecondBound(now_.x, largest_signals_) * h_s * h_s / 8;
  });
}

// An output step in intervals that can be judged, none of them across a piece's end.
void PiecewiseMotion::Play() {
  // restored at the end if no event occurs
  const Point begin = now_;
  const Flow before = flow_;
  const std::size_t events_before = events_.size(), place = place_;
  int level = Stepper().CoarsestLevel();
  while (now_.tick < kTicks && !stalled_at_s_) {
    if (PieceEndsWithin() && now_.tick >= piece_end_tick_) {
      BeginPiece(place_ + 1);
      level = Stepper().CoarsestLevel();
      continue;
    }
    const std::uint64_t end_tick = PieceEndsWithin() ? piece_end_tick_ : kTicks;
    // the interval: 2^-level of an output step, or up to the end of the piece
    const std::uint64_t ticks = std::min(end_tick - now_.tick, kTicks >> level);
    const Point end = Travelled(now_, ticks, false);
    NoticeWork();
    const Ahead ahead = LookAhead(end, ticks);
    // no certain verdict: the interval is halved
    if (!ahead.known) {
      while ((kTicks >> level) >= ticks) ++level;
      continue;
    }
    // to the earliest event, or over the whole interval
    now_ = Travelled(now_, ahead.guard ? ahead.ticks : ticks, true);
    if (ahead.guard) {
      Fire(*ahead.guard);
      level = Stepper().CoarsestLevel();
    } else {
      Forget();
      // a clear interval lets the next one be twice as long
      level = std::max(level - 1, Stepper().CoarsestLevel());
    }
  }
  // a piece may end with the step
  if (PieceEndsWithin() && now_.tick >= piece_end_tick_) BeginPiece(place_ + 1);
  const bool whole = begin.tick == 0 && place_ == place && !PieceEndsWithin();
  if (events_.size() == events_before) {
    // no event: the step is computed again whole, with the same bits as without guards
    flow_ = before;
    now_ = begin;
    if (place_ != place) BeginPiece(place);
    Pass();
  }
  if (events_.size() == events_before && whole) return;
  // an event or a new piece breaks the row of equal steps: a new anchor
  anchor_ = now_.x;
  anchor_index_ = index_ + 1;
}

// An output step without guards, split at ends of pieces only.
void PiecewiseMotion::Pass() {
  while (PieceEndsWithin()) {
    if (now_.tick < piece_end_tick_) PassOver(piece_end_tick_ - now_.tick);
    BeginPiece(place_ + 1);
  }
  PassOver(kTicks - now_.tick);
}

void PiecewiseMotion::PassOver(std::uint64_t ticks) {
  if (flow_.error && !flow_.error_by_steps && TurnsNearZero(now_, Travelled(now_, ticks, false))) {
    CarryErrorBySteps();
  }
  now_ = Travelled(now_, ticks, true);
}

long double PiecewiseMotion::TimeAt(std::uint64_t tick) const {
  constexpr long double kOutputsPerTick = 1.0L / static_cast<long double>(kTicks);
  const long double outputs =
      static_cast<long double>(index_) + kOutputsPerTick * static_cast<long double>(tick);
  return origin_s_ + outputs / static_cast<long double>(rate_hz_);
}

// x(t + h) = Phi x(t) + Gamma w(t + h) with h = 2^-level of an output step
void PiecewiseMotion::Step(const Point& from, int level, Point& to) {
  const Eigen::Index n = from.x.size();
  to.tick = from.tick + (kTicks >> level);
  if (to.tick == kTicks) {
    SignalsAtOutput(index_ + 1, to.drive);
  } else {
    FillSignals(piece_, TimeAt(to.tick), to.drive);
  }
  const Eigen::MatrixXd& step = Stepper().Step(level);
  if (to.drive.size() == 2) {
    // the order of StepUniformly, for equal bits
    to.x.noalias() = step.col(n) * to.drive[0] + step.col(n + 1) * to.drive[1];
  } else {
    to.x.noalias() = step.rightCols(to.drive.size()) * to.drive;
  }
  for (Eigen::Index k = 0; k < n; ++k) to.x.noalias() += step.col(k) * from.x[k];
}

// the state after `ticks`, by one step for each binary digit that is set, the longest first
PiecewiseMotion::Point PiecewiseMotion::Travelled(Point from, std::uint64_t ticks,
                                                  bool take_stock) {
  for (int level = 0; level <= kFinestLevel && ticks > 0; ++level) {
    const std::uint64_t stride = kTicks >> level;
    if (ticks < stride) continue;
    ticks -= stride;
    Step(from, level, next_);
    if (take_stock) TakeStock(from, level, next_);
    std::swap(from, next_);
  }
  return from;
}

GuardJet PiecewiseMotion::JetHere(std::size_t guard) {
  const GuardBound& bound = Stepper().Guards()[guard];
  GuardJet jet = bound.Jet(now_.x, now_.drive);
  // rounding alone may put a rising guard below zero
  if (jet[0] < 0 && jet[1] > 0 && -jet[0] <= bound.Noise(now_.x)) jet[0] = 0;
  if (!departure_ || departure_->guard != guard) return jet;
  // derivatives that are zero by construction do not count as below zero
  for (std::size_t k = 0; k < departure_->order; ++k) jet[k] = std::max(jet[k], 0.0);
  return jet;
}

// The last of `ticks` at which a condition holds that holds at first and ends once: descent through
// halved steps.
template <typename Predicate>
std::uint64_t PiecewiseMotion::LastWhere(std::uint64_t ticks, const Predicate& holds) {
  Point point = now_;
  Point next;
  std::uint64_t passed = 0;
  for (int level = 0; level <= kFinestLevel; ++level) {
    const std::uint64_t stride = kTicks >> level;
    if (passed + stride > ticks) continue;
    Step(point, level, next);
    if (!holds(next)) continue;
    std::swap(point, next);
    passed += stride;
  }
  return passed;
}

// ticks to where a guard falls below zero, none if it does not; `known` false: no certain verdict
std::optional<std::uint64_t> PiecewiseMotion::FallOf(std::size_t guard, const Point& end,
                                                     std::uint64_t ticks, bool& known) {
  GuardBound& bound = Stepper().Guards()[guard];
  const GuardJet jet = JetHere(guard);
  if (jet[0] < 0) return 0;
  const GuardJet end_jet = bound.Jet(end.x, end.drive);
  const double h_s = std::ldexp(static_cast<double>(ticks), -kFinestLevel) / rate_hz_;
  const auto above = [&](const Point& point) { return bound.Value(point.x, point.drive) >= 0; };
  switch (Judge(jet, end_jet, bound.Bounds(now_.x, largest_signals_), h_s)) {
    case GuardVerdict::kClear:
      return {};
    case GuardVerdict::kCrosses:
      return LastWhere(ticks, above);
    case GuardVerdict::kDips: {
      // the minimum lies where g' ends to be negative; a crossing only if g is below zero there
      const std::uint64_t lowest = LastWhere(
          ticks, [&](const Point& point) { return bound.Jet(point.x, point.drive)[1] < 0; });
      if (above(Travelled(now_, lowest, false))) return {};
      return LastWhere(lowest, above);
    }
    case GuardVerdict::kUnknown:
      break;
  }
  // a single tick is the finest resolution: the value at its end decides
  known = ticks == 1;
  return known && end_jet[0] < 0 ? std::optional<std::uint64_t>(0) : std::nullopt;
}

// all guards over the same interval, so that the earliest event comes first
PiecewiseMotion::Ahead PiecewiseMotion::LookAhead(const Point& end, std::uint64_t ticks) {
  Ahead ahead;
  for (std::size_t guard = 0; guard < Stepper().Guards().size(); ++guard) {
    const std::optional<std::uint64_t> fall = FallOf(guard, end, ticks, ahead.known);
    if (!ahead.known) return ahead;
    if (!fall || (ahead.guard && ahead.ticks <= *fall)) continue;
    ahead.guard = guard;
    ahead.ticks = *fall;
  }
  return ahead;
}

// a guard that has risen above rounding is treated as any other
void PiecewiseMotion::Forget() {
  if (!departure_) return;
  const GuardBound& bound = Stepper().Guards()[departure_->guard];
  if (bound.Value(now_.x, now_.drive) > bound.Noise(now_.x)) departure_.reset();
}

void PiecewiseMotion::Fire(std::size_t guard) {
  // g' and the gap's uncertainty belong to the instant before the event
  const double rate = Stepper().Guards()[guard].Jet(now_.x, now_.drive)[1];
  const std::size_t place = Stepper().mode().guards[guard].transition;
  const auto time_s = static_cast<double>(TimeAt(now_.tick));
  const Transition& transition = system_.transitions[place];
  const Point before = now_;
  const std::size_t mode_before = mode_;
  CarryErrorBySteps();
  const double error = flow_.error ? flow_.error->Bound(Stepper().mode().guards[guard].row) : 0;
  Follow(place, time_s, rate);
  if (flow_.error) CarryErrorOver(guard, transition, before, mode_before);
  // bounces too low to be computed: the bodies rest at once, the event has the time of their end
  if (const std::optional<double> rest_s = RestAfter(transition, error)) {
    const Transition& rest = system_.transitions[transition.bounce->rest_via];
    if (flow_.error) CarryErrorToRest(rest, *transition.bounce, now_.x - before.x);
    Follow(transition.bounce->rest_via, time_s + *rest_s, 0);
  }
  NoticeStall();
}

void PiecewiseMotion::Follow(std::size_t transition, double time_s, double guard_rate) {
  const Transition& way = system_.transitions[transition];
  const double before_j = with_energy_ ? StoredNow() : 0;
  // x+ = map x + shift; the decrease of the stored energy is the loss of the impact, J
  now_.x = (way.map * now_.x + way.shift).eval();
  mode_ = way.mode;
  departure_ = way.departure;
  if (with_energy_) flow_.impact_j += static_cast<long double>(before_j - StoredNow());
  events_.push_back({.time_s = time_s, .transition = transition, .guard_rate = guard_rate});
}

// bounces lower than twice the uncertainty of the gap are not computed
std::optional<double> PiecewiseMotion::RestAfter(const Transition& transition, double gap_error) {
  if (!transition.bounce || !departure_) return {};
  const double least = transition.bounce->rest_height;
  const double height = std::clamp(2 * gap_error, least, kMostRestHeights * least);
  return TimeToRest(*transition.bounce, JetHere(departure_->guard), height);
}

void PiecewiseMotion::NoticeStall() {
  const std::uint64_t tick = index_ * kTicks + now_.tick;  // may wrap: differences are what counts
  crowded_events_ = tick - last_event_tick_ < kCrowdedTicks ? crowded_events_ + 1 : 0;
  last_event_tick_ = tick;
  if (crowded_events_ >= kMostCrowdedEvents) {
    Stall(events_.back().time_s, FindingKind::kEventsWithoutEnd);
  }
}

void PiecewiseMotion::NoticeWork() {
  if (static_cast<double>(++intervals_) > MostSteps(index_)) {
    Stall(static_cast<double>(TimeAt(now_.tick)), FindingKind::kBodiesTooFast);
  }
}

void PiecewiseMotion::Stall(double time_s, FindingKind reason) {
  stalled_at_s_ = time_s;
  stall_reason_ = reason;
}

// the state from the anchor in long double, in as few steps as the number of outputs has
// binary digits that are set
void PiecewiseMotion::Reanchor() {
  if (index_ <= anchor_index_ || (index_ - anchor_index_) % kOutputsBetweenAnchors != 0) return;
  const Eigen::Index n = anchor_.size();
  const Eigen::Index m = now_.drive.size();
  LongVector z(n + m);
  z.head(n) = anchor_.cast<long double>();
  Eigen::VectorXd signals(m);
  std::uint64_t passed = anchor_index_;
  for (std::size_t power = kLongPowers; power-- > 0;) {
    const std::uint64_t stride = std::uint64_t{1} << power;
    if (passed + stride > index_) continue;
    passed += stride;
    const long double t_s =
        origin_s_ + static_cast<long double>(passed) / static_cast<long double>(rate_hz_);
    FillSignals(piece_, t_s, signals);
    z.tail(m) = signals.cast<long double>();
    z.head(n) = (Stepper().LongStep(power) * z).eval();
  }
  now_.x = z.head(n).cast<double>();
}

Eigen::VectorXd PiecewiseMotion::Positions() const {
  const Mode& mode = system_.modes[mode_];
  if (mode.positions.size() == 0) return now_.x;
  return mode.positions * now_.x;
}

Eigen::VectorXd PiecewiseMotion::Rates() const {
  const Mode& mode = system_.modes[mode_];
  // x' = A x + B u, then in positions
  Eigen::VectorXd rates = mode.a * now_.x + mode.Inputs() * Inputs();
  if (mode.positions.size() == 0) return rates;
  return mode.positions * rates;
}

double PiecewiseMotion::CurrentA() const {
  const Mode& mode = system_.modes[mode_];
  return mode.current_row.dot(now_.x) + mode.current_per_volt * Inputs()(kVoltage);
}

}  // namespace haptometer::sim
