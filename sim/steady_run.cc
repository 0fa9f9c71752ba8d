#include "sim/steady_run.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/circular_functions.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/period_map.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/smooth/semilinear_solver.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {
namespace {

// periods of the drive that a steady motion is played for, at least
constexpr int kPlayedPeriods = 8;
// a state's largest value over what is reported of it
constexpr double kRmsOverLargest = 10;

// at least eight periods of the drive, and whole ones of the motion
int PeriodsPlayed(int drive_periods) {
  return (kPlayedPeriods + drive_periods - 1) / drive_periods * drive_periods;
}

double PlayedS(const EffectiveScene& scene, int drive_periods = 1) {
  return PeriodsPlayed(drive_periods) / scene.scene.drive.frequency_hz;
}

// the start from rest, because the linear steady motion may lie beyond a stop
PiecewiseStart AtRest(const EffectiveScene& scene) {
  EffectiveScene resting = scene;
  resting.scene.start = Start::kRest;
  return StartIn(resting);
}

SteadyRun NoRun(FindingKind why, std::vector<FindingNumber> numbers = {}) {
  SteadyRun none;
  none.refusal = Finding{Severity::kRefusal, why, std::move(numbers)};
  return none;
}

// the linear steady motion without limits, from its own state at t = 0
SteadyRun PlayLinear(const EffectiveScene& scene) {
  SteadyRun steady;
  EffectiveScene linear = scene;
  linear.piecewise = {};
  linear.scene.start = Start::kSteady;
  steady.start = PiecewiseStartOf(linear.scene);
  steady.run = RunScene(linear, PlayedS(scene), steady.start);
  return steady;
}

// Whether the transient from rest stays clear of stops and keeps contact until it has decayed, so
// that it leads to the linear steady motion.
bool TransientIsFree(const EffectiveScene& scene, const Eigen::VectorXd& steady) {
  constexpr int kMostPeriods = 4096;
  constexpr double kDiedOut = 1e-6;
  PiecewiseLinearSystem system = AssemblePiecewise(scene.scene, scene.piecewise);
  if (system.transitions.empty()) return true;
  const double frequency_hz = scene.scene.drive.frequency_hz;
  // one output per period: states are compared at phase 0 of the drive
  PiecewiseMotion motion(std::move(system), scene.scene.drive, AtRest(scene), frequency_hz);
  const Eigen::VectorXd scale = (steady.array() == 0).select(1.0, steady.cwiseAbs());
  const auto apart = [&] {
    return (motion.Positions() - steady).cwiseQuotient(scale).cwiseAbs().maxCoeff();
  };
  const double begin = apart();
  for (int period = 0; period < kMostPeriods; ++period) {
    motion.Next();
    if (!motion.events().empty() || motion.stalled_at_s()) return false;
    if (apart() <= kDiedOut * begin) return true;
  }
  return true;
}

// drive and tremor superposed; refused at an undamped resonance or where a limit may be reached
SteadyRun PlaySuperposed(const EffectiveScene& scene) {
  SteadyRun steady;
  const SteadyTones motion = Superpose(scene.scene);
  if (!(motion.error_estimate < 1)) return NoRun(FindingKind::kTremorAtResonance);
  if (!SteadyMotionIsFree(scene, motion)) return NoRun(FindingKind::kTremorWithLimits);
  EffectiveScene linear = scene;
  linear.piecewise = {};
  steady.start.x = motion.start;
  SceneRun run = RunScene(linear, PlayedS(scene), steady.start);
  // values over all time replace those of the run's few periods, as the tremor has another period
  run.skin_rms_m = motion.skin_rms_m;
  run.case_rms_m = motion.case_rms_m;
  run.current_rms_a = motion.current_rms_a;
  run.power_w = motion.power_w;
  run.mover_peak_m = run.mover_peak_of_run_m = motion.mover_peak_m;
  run.skin_force_least_n = motion.skin_force_least_n;
  steady.run = std::move(run);
  return steady;
}

// The largest relative standard uncertainty of a run's averages, by those of the mean squares and
// of the powers.
double RelativeUncertainty(const EffectiveScene& scene, const PeriodMeans& uncertain,
                           const SceneRun& run) {
  double largest = uncertain.power_w / std::abs(run.power_w);
  // rms = sqrt(mean square), so u(rms) / rms = u(mean square) / (2 mean square)
  const auto take = [&largest](double uncertainty, double rms) {
    if (rms > 0) largest = std::max(largest, uncertainty / (2 * rms * rms));
  };
  take(uncertain.mean_squares(AssembleModel(scene.scene).skin()), run.skin_rms_m);
  take(uncertain.mean_squares(LinearModel::kCase), run.case_rms_m);
  // the coil's power gives the current only where the resistance is constant
  const double R = scene.scene.actuator.resistance_ohm;
  if (!scene.smooth.heating) take(uncertain.coil_w / R, run.current_rms_a);
  return largest;
}

// The run of a chaotic motion over the periods of its averages, from where those began; under
// smooth effects by one run of the solver, as no tolerance holds the motion itself.
void PlayChaotic(const EffectiveScene& scene, ChaoticMotion chaotic, const SmoothSettings& settings,
                 SteadyRun& steady) {
  EffectiveScene whole = scene;
  whole.window_periods = chaotic.periods;
  const double length_s = chaotic.periods / scene.scene.drive.frequency_hz;
  SceneRun run = scene.IsLinear() ? RunScene(whole, length_s, steady.start)
                                  : RunSmoothly(whole, length_s, steady.start,
                                                steady.temperature_rise_k, settings);
  run.error_estimate = RelativeUncertainty(scene, chaotic.standard_uncertainties, run);
  steady.run = std::move(run);
  steady.chaotic = std::move(chaotic);
}

// Of a periodic motion that was played for a few periods: rounding accumulates over as many periods
// as deviations need to decay (1 / (1 - largest multiplier)), and the initial point has an error.
double ErrorForEver(double error_of_run, const PeriodicMotion& motion) {
  const double stays = motion.multipliers.size() > 0 ? Abs(motion.multipliers(0)) : 0;
  return error_of_run / (1 - stays) + kRmsOverLargest * motion.error;
}

SteadyRun PlayLimited(const EffectiveScene& scene) {
  SteadyRun steady;
  const PeriodMap map(AssemblePiecewise(scene.scene, scene.piecewise), scene.scene.drive);
  // from rest, because the transient selects the attractor
  const PiecewiseStart start = AtRest(scene);
  PeriodicSearch search = FindPeriodicMotion(map, map.PointOf(start.mode, start.x));
  steady.refusal = search.refusal;
  if (search.chaotic) {
    steady.start = map.StartOf(search.chaotic->point);
    PlayChaotic(scene, *std::move(search.chaotic), {}, steady);
    return steady;
  }
  if (!search.found) return steady;
  const int periods = search.found->drive_periods;
  steady.start = map.StartOf(search.found->point);
  EffectiveScene whole = scene;
  // whole periods of the motion, so that means do not depend on the phase
  whole.window_periods = PeriodsPlayed(periods);
  steady.run = RunScene(whole, PlayedS(scene, periods), steady.start);
  steady.run->error_estimate = ErrorForEver(steady.run->error_estimate, *search.found);
  steady.periodic = std::move(search.found);
  return steady;
}

// The steady motion of a smooth scene, at one tolerance after the other.
class SmoothSearch {
 public:
  explicit SmoothSearch(const EffectiveScene& scene)
      : scene_(scene), system_(AssembleSmooth(scene.scene, scene.piecewise, scene.smooth)) {}

  SteadyRun Find() {
    // the search runs at the coarse tolerance; finer ones refine its motion by Newton's method
    SolverLadder ladder(scene_.scene.tolerance);
    const PiecewiseStart rest = AtRest(scene_);
    const PeriodMap map = MapOf(ladder.before(), kSearchTolerance);
    SteadyRun coarse = Settle(map, map.PointOf(rest.mode, rest.x), ladder.before());
    SolverWork work = coarse.run ? coarse.run->work : SolverWork{};
    for (; coarse.periodic; ladder.Refine()) {
      SteadyRun fine =
          Refined(MapOf(ladder.settings(), kRefinedTolerance), *coarse.periodic, ladder.settings());
      if (!fine.run) return fine;
      work += fine.run->work;
      // the remainder of Newton's step may be equal in both motions and cancel in their difference
      const double left = fine.periodic ? kRmsOverLargest * fine.periodic->error : 0;
      const double finer = coarse.run->solver_tolerance / fine.run->solver_tolerance;
      fine.run->error_estimate = ErrorOf(*fine.run, *coarse.run, finer) + left;
      fine.run->work = work;
      if (ladder.EndsWith(fine.run->error_estimate)) return fine;
      coarse = std::move(fine);
    }
    return coarse;
  }

 private:
  static constexpr double kSearchTolerance = 1e-8;
  static constexpr double kRefinedTolerance = 5e-12;  // 2048 times less, so that the maps differ

  static SmoothSettings Within(SmoothSettings settings, double most) {
    settings.tolerance = std::min(settings.tolerance, most);
    return settings;
  }

  // The tolerance of a search is bounded, also for a coarser answer: it compares states of
  // different periods, and Newton's method divides differences of them.
  PeriodMap MapOf(const SmoothSettings& settings, double most) const {
    return {system_, scene_.scene.drive, Within(settings, most)};
  }

  SteadyRun Settle(const PeriodMap& map, const PeriodPoint& from, const SmoothSettings& settings) {
    SteadyRun steady;
    PeriodicSearch search = FindPeriodicMotion(map, from);
    spent_.steps = search.steps;
    spent_.periods_played = search.periods_played;
    steady.refusal = search.refusal;
    if (search.chaotic) {
      if (scene_.smooth.heating) return NoRun(FindingKind::kChaoticWhileWarming);
      steady.start = map.StartOf(search.chaotic->point);
      PlayChaotic(scene_, *std::move(search.chaotic), Within(settings, kSearchTolerance), steady);
    } else if (search.found) {
      Play(map, std::move(*search.found), settings, steady);
    }
    return steady;
  }

  SteadyRun Refined(const PeriodMap& map, const PeriodicMotion& coarse,
                    const SmoothSettings& settings) {
    auto found = RefinePeriodicMotion(map, coarse, {}, spent_);
    if (!found) {
      return NoRun(FindingKind::kNotFoundAgain, {{"drive_periods", coarse.drive_periods},
                                                 {"tolerance", settings.tolerance},
                                                 {"steps", spent_.steps}});
    }
    SteadyRun steady;
    Play(map, std::move(*found), settings, steady);
    return steady;
  }

  void Play(const PeriodMap& map, PeriodicMotion motion, const SmoothSettings& settings,
            SteadyRun& steady) const {
    const PeriodPoint& point = motion.point;
    const int periods = motion.drive_periods;
    steady.start = map.StartOf(point);
    if (scene_.smooth.heating) steady.temperature_rise_k = point.x(point.x.size() - 1);
    EffectiveScene whole = scene_;
    whole.window_periods = PeriodsPlayed(periods);
    steady.run = RunSmoothly(whole, PlayedS(scene_, periods), steady.start,
                             steady.temperature_rise_k, settings);
    steady.periodic = std::move(motion);
  }

  const EffectiveScene& scene_;
  SmoothSystem system_;
  PeriodicSearch spent_;  // the work of all searches
};

SteadyRun PlaySmooth(const EffectiveScene& scene) {
  if (!scene.scene.finger.tones.empty()) return NoRun(FindingKind::kTremorWithBentSprings);
  // a coil that loses no heat has no steady temperature
  if (scene.smooth.heating && std::isinf(scene.smooth.heating->thermal_resistance_k_per_w)) {
    return NoRun(FindingKind::kNoHeatLeaves);
  }
  return SmoothSearch(scene).Find();
}

}  // namespace

std::optional<int> PeriodAtEnd(const SceneRun& run) {
  constexpr double kRecurs = 1e-4;  // of the largest of each position in what was marked
  if (run.marks.size() < 3) return std::nullopt;
  // the largest of each position over the marks; 1 for one that never moves
  Eigen::VectorXd largest = run.marks[0].positions.cwiseAbs();
  for (const PeriodMark& mark : run.marks) largest = largest.cwiseMax(mark.positions.cwiseAbs());
  largest = (largest.array() > 0).select(largest, 1.0);
  const std::size_t last = run.marks.size() - 1;
  for (std::size_t k = 1; k <= kMostDrivePeriods && 2 * k <= last; ++k) {
    double apart = 0;
    // every one of the last k periods must end where the one k before ended
    for (std::size_t i = 0; i < k; ++i) {
      const Eigen::VectorXd difference =
          run.marks[last - i].positions - run.marks[last - i - k].positions;
      apart = std::max(apart, difference.cwiseQuotient(largest).cwiseAbs().maxCoeff());
    }
    if (apart <= kRecurs) return static_cast<int>(k);
  }
  return std::nullopt;
}

std::optional<double> WindowUncertainty(const SceneRun& run, int window_periods) {
  const auto periods = static_cast<std::size_t>(window_periods);
  if (run.marks.size() < 2 * periods + 1) return std::nullopt;
  // RMS over each window before the last, as far back as is marked
  std::vector<double> rms;
  for (std::size_t end = run.marks.size() - 1; end >= periods; end -= periods) {
    rms.push_back(std::sqrt(std::max(
        0.0, run.marks[end].skin_square_m2_s - run.marks[end - periods].skin_square_m2_s)));
  }
  double mean = 0, square = 0;
  for (const double value : rms) mean += value / static_cast<double>(rms.size());
  for (const double value : rms) square += (value - mean) * (value - mean);
  // relative standard deviation of the RMS from window to window
  return mean > 0 ? std::sqrt(square / static_cast<double>(rms.size() - 1)) / mean : 0;
}

SteadyRun PlaySteady(const EffectiveScene& scene) {
  if (!scene.IsLinear()) return PlaySmooth(scene);
  if (!scene.scene.finger.tones.empty()) return PlaySuperposed(scene);
  // limits that the linear steady motion itself reaches
  if (!SteadyMotionIsFree(scene, SolveSteadyState(scene.scene))) return PlayLimited(scene);
  // the transient may reach a limit and remain in another motion
  SteadyRun linear = PlayLinear(scene);
  if (TransientIsFree(scene, linear.start.x)) return linear;
  SteadyRun limited = PlayLimited(scene);
  // a limited search that ends without events has found the linear motion
  return limited.run && limited.run->events.empty() ? linear : limited;
}

}  // namespace haptometer::sim
