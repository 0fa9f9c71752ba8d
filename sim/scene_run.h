#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/effective_scene.h"
#include "sim/findings.h"
#include "sim/piecewise/energy_ledger.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/smooth/smooth_motion.h"

namespace haptometer::sim {

/// How often something happened during a run: "impact up", 12.
struct EventCount {
  std::string_view name;
  std::size_t count = 0;
  double first_s = 0;
};

/// Where a run under a sine was at the end of one of its periods.
struct PeriodMark {
  Eigen::VectorXd positions;
  double skin_square_m2_s = 0;  ///< integral of xs^2 since t = 0
};

/// What the motion of a run comes to over its window: the last EffectiveScene::window_periods of a
/// sine, ten, or all of it where it is shorter or its drive is no sine.
struct SceneRun {
  double begin_s = 0;  ///< of the window
  double end_s = 0;
  double skin_rms_m = 0;     ///< sqrt(1/(end - begin) integral xs^2 dt), an integral, not sampled
  double case_rms_m = 0;     ///< the same of xa
  double current_rms_a = 0;  ///< the same of i
  double power_w = 0;        ///< mean of v i, and of what a moving finger puts in
  double mover_peak_m = 0;   ///< largest abs(xv - xa) in the window
  double mover_peak_of_run_m = 0;  ///< in the whole run, transients included
  /// Least of what presses on the skin beyond what does at rest (RestingForceN), in the whole run.
  double skin_force_least_n = 0;
  double outputs_rate_hz = 0;
  std::vector<PeriodMark> marks{};   ///< of the last kMostMarks ends of whole periods, counted from
                                     ///< the run's end; the last is that end
  Eigen::VectorXd skin_m;            ///< xs at the window's outputs, begin_s + i / outputs_rate_hz
  EnergyLedger ledger;               ///< of the whole run
  std::vector<EventCount> events{};  ///< of the whole run, in the order in which they first came
  std::optional<double> stalled_at_s{};  ///< nothing behind it is known
  std::optional<FindingKind> stall_reason{};
  double temperature_rise_k = 0;  ///< of the coil that heats, at the end of the run
  double temperature_peak_k = 0;  ///< the largest in the run
  double solver_tolerance = 0;    ///< SmoothMotion::tolerance(); 0: exact
  SolverWork work{};              ///< of the solver, over all runs that led to this one
  /// A bound of the relative error of every number here (the least force apart) and of the
  /// waveform over its peak; infinite where it is not known. Of an exact motion what rounding,
  /// events and bounces that are not played come to, carried through all modes and events
  /// (motion_error.h); of the solver ErrorOf() two runs.
  double error_estimate = 0;
  /// Of an exact motion: until when it was known to scene.tolerance, skin, travel and current over
  /// their peaks; absent: to the end.
  std::optional<double> known_until_s{};

  /// Whether all that can be asked for is a number.
  [[nodiscard]] bool IsFinite() const;
};

inline constexpr std::size_t kMostMarks = 129;

/// Outputs within a period of the drive: a peak between two of them is interpolated to 1e-10.
inline constexpr int kOutputsPerPeriod = 64;
/// The longest run in outputs: a minute of work or so.
inline constexpr double kMostOutputs = 1e8;

/// More events than so many and so many an output end a run: bodies that rattle far faster than
/// the drive. A second of work or so.
inline constexpr std::size_t kMostEvents = 20'000;
inline constexpr std::size_t kMostEventsPerOutput = 50;

/// An exact motion with a larger error_estimate is beyond prediction: what its error grows by was
/// found for small errors.
inline constexpr double kLargestPredictedError = 1e-3;

/// The relative deviation of an asked quantity between two runs of the same length.
[[nodiscard]] double Deviation(AskedQuantity quantity, const SceneRun& run,
                               const SceneRun& reference);

/// The largest relative deviation of all that a run's window is reported by: RMS values, power and
/// peaks.
[[nodiscard]] double LargestDeviation(const SceneRun& run, const SceneRun& reference);

/// What a run of the solver is wrong by that leaves out n = `finer` times less than another: the
/// largest deviation between them, the waveform's included, over n/64, or the other's error and
/// that deviation where that is less; and rounding: 1e-12 and 4.4e-16 a step; and 5e-4 of the
/// solver's tolerance, for the iteration within each step. Where n is 1 the two are the same run,
/// and the other's estimate stays.
[[nodiscard]] double ErrorOf(const SceneRun& run, const SceneRun& coarse, double finer);

/// What the drive is wrong by, over its amplitude: a chirp's cubics (Drive::hold_tolerance); else
/// 0. Exact runs have it in their error_estimate, runs of the solver as ChooseEffects() answers
/// them.
[[nodiscard]] double DriveError(const Scene& scene);

/// Plays the scene from t = 0 to `duration_s` with its stops, contact and smooth effects.
///
/// Outputs come as sim/effective_scene.h says.
///
/// Peaks and the least force are located between outputs and on both sides of each event.
///
/// **Without smooth effects** by PiecewiseMotion, exact.
///
/// **With them** by SmoothMotion, with one tolerance of SolverLadder after the other until
/// ErrorOf the last two runs is a quarter of scene.tolerance, or no longer falls (a chaotic
/// motion); what is left is told in error_estimate, and it is the caller who compares that with
/// scene.tolerance.
///
/// duration_s > 0, StepsOfRun at most MostSteps. Cost: PiecewiseMotion's with energies, 64 outputs
/// a period; SmoothMotion's, some 0.3 ms a period and 0.1 ms an event, both runs together.
[[nodiscard]] SceneRun RunScene(const EffectiveScene& scene, double duration_s);

/// The same from any state at t = 0.
[[nodiscard]] SceneRun RunScene(const EffectiveScene& scene, double duration_s,
                                PiecewiseStart start, double temperature_rise_k = 0);

/// By SmoothMotion alone, one run with tolerance and longest step of `settings`, whose
/// error_estimate is infinite.
[[nodiscard]] SceneRun RunSmoothly(const EffectiveScene& scene, double duration_s,
                                   PiecewiseStart start, double temperature_rise_k,
                                   SmoothSettings settings);

}  // namespace haptometer::sim
