#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "sim/findings.h"
#include "sim/linear/driven_step.h"
#include "sim/linear/excitation.h"
#include "sim/linear/mode.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/energy_ledger.h"
#include "sim/piecewise/mode_stepper.h"
#include "sim/piecewise/motion_error.h"
#include "sim/scene/scene.h"

namespace haptometer::sim {

/// A guard fell below zero.
struct Event {
  double time_s = 0;
  std::size_t transition = 0;
  double guard_rate = 0;  ///< g' just before, <= 0: of a gap, the speed of closing in m/s
};

/// Where a motion begins, at t = 0.
struct PiecewiseStart {
  std::size_t mode = 0;
  Eigen::VectorXd x;  ///< in the mode's coordinates
};

/// When a motion is handed out: output i at origin_s + i / rate_hz. The motion begins at t = 0.
struct OutputGrid {
  double rate_hz = 0;  ///< > 0
  /// In (-1 / rate_hz, 0]: where output 0 would be, before the motion begins. So outputs can be
  /// counted back from the end of a run.
  double origin_s = 0;
};

/// The motion of a piecewise-linear system under an excitation: exact within each mode, with its
/// events located, handed out on a grid of equal steps.
///
/// **Between outputs.** An output step without events is one product with one matrix, so guards
/// that are never reached leave no trace: the samples are, bit for bit, those of the same mode
/// without guards (and of StepUniformly over its first 16384 samples). Every 16384 outputs
/// the state is computed anew from where the mode was entered, in long double: rounding does not
/// pile up (undamped, 1e6 cycles at 10 kHz: energy to 1e-10 instead of 3e-9).
///
/// **No event is missed.** Every guard is judged over every interval (sim/piecewise/guard.h): an
/// interval is passed only with a proof that g >= 0 all over it, or that it holds exactly one
/// crossing or one minimum; else it is halved. All guards are judged over the same interval before
/// the earliest event in it is taken, so events cannot change places.
///
/// **The excitation's pieces** begin at known times: an output step is split there, to 2^-50 of it,
/// or at the output itself where the two agree to rounding. What is shown for the very moment is
/// the state before the new piece.
///
/// **Located** by descent through steps of halves to 2^-50 of an output step, left of the crossing
/// (a gap is never negative). What remains is rounding of the state: max(1e-12 s, 1e-13 A/|v|), v
/// the speed of crossing and A the size of the motion; a graze, where v vanishes, is decided by g
/// at its minimum to 1e-13 A and timed to sqrt(1e-13 A/|g''|).
///
/// **Accumulation** of bounces: see PiecewiseLinearSystem. **A stall** ends the motion:
/// a hundred events with less than 2^-40 of an output step from each to the next, or more than
/// 2e6 intervals judged, and 10 more for each output so far (some 2 s, and 10 us an output), as
/// happens where a body or a current settles a million times faster than the rest moves.
class PiecewiseMotion {
 public:
  /// `with_energy` keeps the ledger: 0.2 us more for a step, and some
  /// ms for each mode in which there are events.
  PiecewiseMotion(PiecewiseLinearSystem system, Excitation excitation, PiecewiseStart start,
                  const OutputGrid& grid, bool with_energy = false);
  /// The same under a sine.
  PiecewiseMotion(PiecewiseLinearSystem system, const SineDrive& drive, PiecewiseStart start,
                  const OutputGrid& grid, bool with_energy = false)
      : PiecewiseMotion(std::move(system), Excitation(drive), std::move(start), grid, with_energy) {
  }
  PiecewiseMotion(PiecewiseLinearSystem system, const SineDrive& drive, PiecewiseStart start,
                  double rate_hz, bool with_energy = false)
      : PiecewiseMotion(std::move(system), drive, std::move(start), OutputGrid{.rate_hz = rate_hz},
                        with_energy) {}
  // steppers refer to the system within
  PiecewiseMotion(const PiecewiseMotion&) = delete;
  PiecewiseMotion& operator=(const PiecewiseMotion&) = delete;

  /// Begins anew at t = 0, with the matrices that it has; no energies, and a grid without an
  /// origin.
  void Restart(PiecewiseStart start);

  /// Goes on to the next output. Cost without events: 0.03 to 0.1 us; some 15 us for each
  /// event. Nothing happens after a stall.
  void Next();
  /// Goes on by as many outputs as nothing can happen in (no guards, no energies, one sine of the
  /// drive, no new state from where the mode began), `most` at most, and calls take(i, x,
  /// voltage_v) for i = 0, 1, ...; how many, 0: Next() is called for. The same bits at
  /// StepUniformly's cost.
  template <typename Take>
  Eigen::Index NextUnwatched(Eigen::Index most, const Take& take) {
    const Eigen::Index count = std::min(OutputsUnwatched(), most);
    if (count == 0) return 0;
    const double amplitude_v = shape().rows(kVoltage, 0);
    StepUniformly(Stepper().Step(0), sequences_[0], index_, count, now_.x,
                  [&](Eigen::Index i, const auto& x, const Eigen::Vector2d& drive) {
                    take(i, x, amplitude_v * drive[0]);
                  });
    index_ += static_cast<std::uint64_t>(count);
    SignalsAtOutput(index_, now_.drive);
    return count;
  }

  /// The number of the output that the motion stands at; 0: at its beginning.
  [[nodiscard]] std::uint64_t index() const { return index_; }
  /// The state there, in the coordinates of the mode() there.
  [[nodiscard]] const Eigen::VectorXd& x() const { return now_.x; }
  [[nodiscard]] std::size_t mode() const { return mode_; }
  /// The mode's positions x: what all modes have in common.
  [[nodiscard]] Eigen::VectorXd Positions() const;
  /// Their rates by time.
  [[nodiscard]] Eigen::VectorXd Rates() const;
  /// (kInputs): what acts from outside there.
  [[nodiscard]] Eigen::VectorXd Inputs() const { return shape().rows * now_.drive; }
  /// The coil's current there, also where it is no state.
  [[nodiscard]] double CurrentA() const;
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  /// The balance up to here; needs `with_energy`.
  [[nodiscard]] EnergyLedger Ledger() const;
  /// Integrals since t = 0 of the squares of the system's squared_rows; need `with_energy`.
  [[nodiscard]] std::vector<double> SquareIntegrals() const;
  /// The ranges of the modes' watched numbers since the beginning or the last ForgetRanges(),
  /// between outputs and on either side of events too: located, not sampled, to rounding. Where
  /// something settles so fast that an output step is longer than what bounds hold for, one extreme
  /// in a step is found. Cost: 0.1 us for a step, some 5 us for each that may hold an extreme.
  [[nodiscard]] const std::vector<ValueRange>& Ranges() const { return flow_.ranges; }
  void ForgetRanges();
  /// Bounds of what rounding, located events and bounces that were not played leave uncertain
  /// (motion_error.h) of a number, row x over the positions, and of the current; at the last
  /// output, or of the last multiple of 64 where nothing happened yet and no guard turned within
  /// 1e-9 of its terms. Need `with_energy`.
  [[nodiscard]] double ErrorOf(const Eigen::RowVectorXd& positions_row) const;
  [[nodiscard]] double ErrorOfCurrent() const;
  /// How many intervals may be judged one by one, each in some 1 us, until that output.
  [[nodiscard]] static double MostSteps(std::uint64_t output) {
    return 2e6 + 10 * static_cast<double>(output);
  }
  /// How many were so far.
  [[nodiscard]] std::int64_t steps() const { return static_cast<std::int64_t>(intervals_); }
  /// When the motion stalled, if it did.
  [[nodiscard]] std::optional<double> stalled_at_s() const { return stalled_at_s_; }
  /// Why: kEventsWithoutEnd or kBodiesTooFast.
  [[nodiscard]] std::optional<FindingKind> stall_reason() const { return stall_reason_; }
  [[nodiscard]] const PiecewiseLinearSystem& system() const { return system_; }

 private:
  static constexpr std::uint64_t kOutputsBetweenAnchors = 1 << 14;
  struct Point {
    Eigen::VectorXd x;
    Eigen::VectorXd drive;   // the signals w of the piece
    std::uint64_t tick = 0;  // since the output before
  };
  struct Ahead {
    bool known = true;
    std::optional<std::size_t> guard;  // the one that falls first
    std::uint64_t ticks = 0;           // from here to there
  };
  struct Flow {  // long sums
    long double input_j = 0;
    long double impact_j = 0;
    std::vector<long double> dissipated_j;
    std::vector<long double> squares;
    std::vector<ValueRange> ranges;  // no sums, but gathered in the same places
    std::optional<MotionError> error;
    std::uint64_t error_index = 0;  // the output up to which it is carried in long steps
    bool error_by_steps = false;    // from there on with every step
  };

  struct Shape {  // pieces that share their matrices
    ExcitationPiece first;
    ExcitationShape shape;
    std::deque<ModeStepper> steppers;  // one for each mode
  };

  [[nodiscard]] ModeStepper& Stepper() { return shapes_[active_].steppers[mode_]; }
  [[nodiscard]] const ExcitationShape& shape() const { return shapes_[active_].shape; }
  void BeginPiece(std::size_t place);
  void SetSequences();
  [[nodiscard]] std::size_t PlaceOfShape();
  [[nodiscard]] bool PieceEndsWithin() const { return piece_end_index_ == index_; }
  void SignalsAtOutput(std::uint64_t output, Eigen::VectorXd& w);
  [[nodiscard]] bool PlainSine() const;
  [[nodiscard]] Eigen::Index OutputsUnwatched();
  void Pass();
  void PassOver(std::uint64_t ticks);
  [[nodiscard]] long double TimeAt(std::uint64_t tick) const;
  void Step(const Point& from, int level, Point& to);  // not in place
  [[nodiscard]] Point Travelled(Point from, std::uint64_t ticks, bool take_stock);
  void TakeStock(const Point& from, int level, const Point& to);
  void CarryError(const Point& from, int level, const Point& to);
  void CarryErrorFar();
  void CarryErrorTo(std::uint64_t output);
  void CarryErrorBySteps();
  void CarryErrorOver(std::size_t guard, const Transition& way, const Point& before,
                      std::size_t mode_before);
  void CarryErrorToRest(const Transition& rest, const Bounce& bounce, const Eigen::VectorXd& step);
  void NoticeNearMiss(const Point& from, const Point& to);
  [[nodiscard]] bool TurnsNearZero(const Point& from, const Point& to);
  [[nodiscard]] Eigen::VectorXd RateIn(std::size_t mode, const Point& point) const;
  [[nodiscard]] Eigen::VectorXd RoundingOf(const Point& from, int level, const Point& to);
  void CountEnergy(const Point& from, int level);
  void Watch(const Point& from, int level, const Point& to);
  void LookForExtremes(GuardBound& number, const Point& from, int level, const Point& to,
                       int deepest, ValueRange& range);
  [[nodiscard]] double ValueAtExtreme(const GuardBound& number, const Point& from, int level);
  [[nodiscard]] bool ClearAtOnce(const Point& end);
  void Play();
  [[nodiscard]] Ahead LookAhead(const Point& end, std::uint64_t ticks);
  [[nodiscard]] std::optional<std::uint64_t> FallOf(std::size_t guard, const Point& end,
                                                    std::uint64_t ticks, bool& known);
  template <typename Predicate>
  [[nodiscard]] std::uint64_t LastWhere(std::uint64_t ticks, const Predicate& holds);
  [[nodiscard]] GuardJet JetHere(std::size_t guard);
  void Fire(std::size_t guard);
  void Follow(std::size_t transition, double time_s, double guard_rate);
  [[nodiscard]] std::optional<double> RestAfter(const Transition& transition, double gap_error);
  void NoticeStall();
  void NoticeWork();
  void Stall(double time_s, FindingKind reason);
  void Forget();
  void Reanchor();
  [[nodiscard]] double StoredNow() const;

  PiecewiseLinearSystem system_;
  Excitation excitation_;
  double rate_hz_;
  long double origin_s_;
  bool with_energy_;
  std::deque<Shape> shapes_;
  std::size_t active_ = 0;  // of shapes_
  std::size_t place_ = 0;   // of the piece
  ExcitationPiece piece_;
  Eigen::VectorXd largest_signals_;  // of the piece
  std::uint64_t piece_end_index_ = 0, piece_end_tick_ = 0;
  std::vector<DriveSequence> sequences_;  // of the piece's tones; none: asked for one by one
  std::uint64_t index_ = 0;
  std::size_t mode_;
  Point now_;
  Point next_;                // work space
  Eigen::VectorXd energy_z_;  // the same: [x, w] of CountEnergy
  std::optional<Departure> departure_;
  Eigen::VectorXd anchor_;  // the state at output anchor_index_, all since in one mode
  std::uint64_t anchor_index_ = 0;
  std::vector<Event> events_;
  std::uint64_t intervals_ = 0;  // judged so far
  int crowded_events_ = 0;
  std::uint64_t last_event_tick_ = 0;
  std::optional<double> stalled_at_s_;
  std::optional<FindingKind> stall_reason_;
  double initial_j_ = 0;
  Flow flow_;
};

}  // namespace haptometer::sim
