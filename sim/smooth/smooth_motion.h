#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "sim/findings.h"
#include "sim/linear/excitation.h"
#include "sim/piecewise/energy_ledger.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/scene/scene.h"
#include "sim/smooth/semilinear_solver.h"
#include "sim/smooth/smooth_mode.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {

/// How a smooth motion is computed.
struct SmoothSettings {
  double tolerance = 1e-8;  ///< of each position and speed over its largest value; 1e-12 to 1e-2
  /// Of the fastest tone; without tones a quarter stands for an output step, or for a piece that is
  /// shorter.
  double longest_step_periods = 0.25;
  bool with_energy = false;             ///< keep the ledger
  std::int64_t most_steps = 4'000'000;  ///< of the solver, in all: half a minute
};

/// The settings that a scene with smooth effects is computed with, one after the other: with a
/// tolerance of a tenth of scene.tolerance (4e-12 to 1e-5) in steps of at most a period, and ever
/// 2048 times less with half the longest step where the answer is not good enough, down to 4e-12,
/// where the rounding of a run exceeds what its steps leave out. before() is one such step coarser
/// than the first, the run that the first is compared with. As a halved step leaves out 2^-11 of
/// what the whole one does, two of them take the same steps only near that least tolerance.
class SolverLadder {
 public:
  explicit SolverLadder(double scene_tolerance);

  [[nodiscard]] const SmoothSettings& settings() const { return settings_; }
  /// Of the run before.
  [[nodiscard]] const SmoothSettings& before() const { return before_; }
  /// Whether an error is a quarter of what is asked for, or no less tolerance is left.
  [[nodiscard]] bool EndsWith(double error) const;
  void Refine();

 private:
  double asked_;
  SmoothSettings settings_;
  SmoothSettings before_;
};

/// The motion of a scene with smooth nonlinear effects, with the face of PiecewiseMotion: outputs
/// on the same grid, events located, energies counted.
///
/// **Between events** exponential collocation (semilinear_solver.h); each step is a polynomial. A
/// guard, being affine in the states, is a polynomial too over that step, and the first place where
/// it falls below zero is found for certain (sim/piecewise/guard.h): what is missed is at most what
/// the solution's own error hides. No step is longer than a quarter (or what is set) of the
/// fastest tone's period, or without tones than an output step.
///
/// **The excitation's pieces** begin at known times, each with a new beginning of the solver. What
/// is shown for the very moment is the state before the new piece.
///
/// **At an event** the motion goes on from the map of its transition, with a new beginning of the
/// solver. A guard that begins within its own error of zero (the one just left) is no event until
/// it has risen above that, or falls below it. Accumulating bounces end by the rule of
/// sim/linear/mode.h, where those lower than the tolerance count as at rest.
///
/// **Energies** are integrals in the same integration, with the same error control.
///
/// **Error.** The tolerance steers each step's error, not what becomes of it: ErrorOf() two runs
/// (sim/scene_run.h) measures that. Below some 1e-11 rounding wins; a chaotic motion has no error
/// that stays small.
///
/// **A stall** ends the motion: a hundred events within 2^-40 of an output step, a solver that
/// cannot go on or needs more steps than it may take.
class SmoothMotion {
 public:
  SmoothMotion(SmoothSystem system, const SineDrive& drive, PiecewiseStart start, double rate_hz,
               const SmoothSettings& settings, double temperature_rise_k = 0)
      : SmoothMotion(std::move(system), drive, std::move(start), OutputGrid{.rate_hz = rate_hz},
                     settings, temperature_rise_k) {}
  SmoothMotion(SmoothSystem system, const SineDrive& drive, PiecewiseStart start,
               const OutputGrid& grid, const SmoothSettings& settings,
               double temperature_rise_k = 0)
      : SmoothMotion(std::move(system), Excitation(drive), std::move(start), grid, settings,
                     temperature_rise_k) {}
  SmoothMotion(SmoothSystem system, Excitation excitation, PiecewiseStart start,
               const OutputGrid& grid, const SmoothSettings& settings,
               double temperature_rise_k = 0);
  // problems refer to the system within
  SmoothMotion(const SmoothMotion&) = delete;
  SmoothMotion& operator=(const SmoothMotion&) = delete;

  /// Begins anew as one that never ran would, but with the matrices of steps kept; needs output 0
  /// at t = 0 and no energies.
  void Restart(PiecewiseStart start, double temperature_rise_k);

  /// Goes on to the next output. Cost: some 10 us a step of the solver, of which there are 2 to 30
  /// in a period and 5 to 10 after an event. Nothing happens after a stall.
  void Next();

  /// The number of the output that the motion stands at; 0: at its beginning.
  [[nodiscard]] std::uint64_t index() const { return index_; }
  /// The state there, in the coordinates of the mode() there.
  [[nodiscard]] const Eigen::VectorXd& x() const { return x_; }
  [[nodiscard]] std::size_t mode() const { return mode_; }
  /// The mode's positions x: what all modes have in common.
  [[nodiscard]] Eigen::VectorXd Positions() const;
  /// Their rates by time.
  [[nodiscard]] Eigen::VectorXd Rates() const;
  /// (kInputs): what acts from outside there.
  [[nodiscard]] Eigen::VectorXd Inputs() const;
  /// The coil's current there, also where it is no state.
  [[nodiscard]] double CurrentA() const;
  /// The coil's rise there; 0 without heating.
  [[nodiscard]] double temperature_rise_k() const { return temperature_rise_k_; }
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  /// The balance up to here; needs `with_energy`.
  [[nodiscard]] EnergyLedger Ledger() const;
  /// Integrals since t = 0 of the squares of the system's squared_rows; need `with_energy`.
  [[nodiscard]] std::vector<double> SquareIntegrals() const;
  /// As PiecewiseMotion's, of the steps' polynomials, each looked at once: the step that goes on
  /// beyond the output when asked.
  [[nodiscard]] const std::vector<ValueRange>& Ranges();
  /// The coil's largest rise since then, as of the last Ranges(); 0 where nothing is watched.
  [[nodiscard]] double temperature_peak_k() const { return temperature_peak_k_.largest; }
  void ForgetRanges();
  /// Integral since t = 0 of the current's square in A^2 s; needs `with_energy`.
  [[nodiscard]] double CurrentSquareIntegral() const { return IntegralsHere().back(); }
  /// When the motion stalled, if it did, and why.
  [[nodiscard]] std::optional<double> stalled_at_s() const { return stalled_at_s_; }
  [[nodiscard]] std::optional<FindingKind> stall_reason() const { return stall_reason_; }
  [[nodiscard]] const PiecewiseLinearSystem& system() const { return system_.linear; }
  /// The tolerance that was asked for, or the least that rounding lets, 1.9e-13.
  [[nodiscard]] double tolerance() const;
  /// What it cost.
  [[nodiscard]] SolverWork work() const;
  /// The solver's steps so far.
  [[nodiscard]] std::int64_t steps() const { return steps_; }

 private:
  struct ModeRun {
    ModeRun(const SmoothSystem& system, std::size_t mode, const ExcitationPiece& piece,
            bool with_energy, double relative);
    SmoothMode problem;
    SemilinearSolver solver;
    bool was_entered = false;   // since the motion's beginning
    std::vector<bool> armed{};  // of each guard: it has risen
  };
  struct Fall {
    std::size_t guard = 0;
    double tau_s = 0;
  };
  struct Flow {  // long sums, up to where the mode began
    long double impact_j = 0;
    std::vector<long double> integrals;  // as SmoothMode's
  };

  [[nodiscard]] ModeRun& Run() { return *runs_[mode_]; }
  void Enter(Eigen::VectorXd y);
  void TakePiece(std::size_t place);
  void NextPiece();
  void Pass(double tau_s);
  [[nodiscard]] double TauOfPieceEnd() const;
  [[nodiscard]] double LongestStepS() const;
  void Advance();
  void LookForFall();
  template <typename Number, typename Value>
  [[nodiscard]] Eigen::VectorXd PolynomialOf(const Number& that, const Value& value);
  [[nodiscard]] double NoiseOf(std::size_t guard);
  void Arm();
  void Fire(const Fall& fall);
  [[nodiscard]] Eigen::VectorXd Follow(std::size_t transition, const Eigen::VectorXd& y,
                                       double time_s, double guard_rate);
  [[nodiscard]] std::optional<double> RestAfter(const Transition& transition,
                                                const Eigen::VectorXd& y);
  void Stall(FindingKind reason);
  void TakeOutput(double tau_s);
  void Watch(double tau_s);
  [[nodiscard]] std::vector<double> IntegralsHere() const;
  [[nodiscard]] Eigen::VectorXd Whole() const;
  [[nodiscard]] long double TimeOf(std::uint64_t output) const;
  [[nodiscard]] double TauOfOutput() const;

  SmoothSystem system_;
  Excitation excitation_;
  std::size_t place_ = 0;  // of the piece
  ExcitationPiece piece_;
  double rate_hz_;
  long double grid_origin_s_;
  SmoothSettings settings_;
  double relative_ = 0;                         // the solver's local tolerance
  std::vector<std::unique_ptr<ModeRun>> runs_;  // one for each mode that was entered
  std::uint64_t index_ = 0;
  std::size_t mode_;
  long double origin_s_ = 0;  // the time at which the mode was entered
  Eigen::VectorXd x_;
  double temperature_rise_k_;
  std::optional<Fall> fall_;  // in the step that was taken last
  std::vector<ValueRange> ranges_;
  ValueRange temperature_peak_k_{.least = 0, .largest = 0};
  // from where the mode was entered: how far the ranges go, the last output
  double watched_until_s_ = 0, output_tau_s_ = 0;
  std::vector<Event> events_;
  int crowded_events_ = 0;
  std::int64_t steps_ = 0;
  std::optional<double> stalled_at_s_;
  std::optional<FindingKind> stall_reason_;
  double initial_j_ = 0;
  Flow flow_;
};

}  // namespace haptometer::sim
