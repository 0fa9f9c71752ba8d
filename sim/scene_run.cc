#include "sim/scene_run.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>

#include "base/elementary_functions.h"
#include "base/error.h"
#include "base/jobs.h"
#include "sim/linear/excitation.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/scene_mode.h"
#include "sim/piecewise/guard.h"
#include "sim/smooth/smooth_motion.h"
#include "sim/smooth/smooth_system.h"

namespace haptometer::sim {
namespace {

// outputs between two evaluations of the error: before the first event, and after it
constexpr std::uint64_t kQuietOutputs = 64;
constexpr std::uint64_t kBusyOutputs = 4;
// of integrals of squares and of power, relative (measured: a few 1e-15)
constexpr double kIntegralRounding = 1e-14;
// of every number of an exact run, relative (measured: of a peak 2e-13)
constexpr double kExactRounding = 4e-13;
// of the solver, relative; and of each of its steps, which can all point the same way
constexpr double kSolverRounding = 1e-12;
constexpr double kStepRounding = 2 * std::numeric_limits<double>::epsilon();

// of the solver's tolerance, what the iteration within each step leaves, in both runs alike
// (measured: 4e-5 in 1500 answers of random scenes)
constexpr double kIterationPart = 5e-4;
// what n times less tolerance leaves of the error is less than this over n
constexpr double kLeftOver = 64;
// what polynomials of degree 10 leave out falls by this power of a step's length
constexpr double kStepOrder = 11;
// an error that less tolerance does not make smaller than this part of itself stays
constexpr double kWorthIt = 0.5;
// of the exact motion in its fastest mode: 10 ms in one output step
constexpr double kMostIntervalsPerOutput = 1e4;
// of the solver: some 8 us each, so that a run takes a minute or two at most
constexpr std::int64_t kMostSteps = 100'000;
constexpr std::int64_t kMostStepsPerOutput = 100;
constexpr std::int64_t kMostStepsOfAll = 10'000'000;
constexpr std::size_t kReportOutputs = 256;

// The outputs of a run: so many steps from before t = 0 to its very end.
struct RunGrid {
  OutputGrid outputs;
  std::size_t count = 0;             // the last output
  std::size_t window_begin = 0;      // an output
  std::size_t outputs_a_period = 0;  // of a sine
};

RunGrid GridOf(const EffectiveScene& effective, double duration_s) {
  const Scene& scene = effective.scene;
  RunGrid grid;
  grid.outputs.rate_hz = effective.RateHz();
  const double steps = duration_s * grid.outputs.rate_hz;
  HAPTOMETER_CHECK(duration_s > 0 && steps <= kMostOutputs, "{} s at {} Hz", duration_s,
                   grid.outputs.rate_hz);
  // a whole number of steps, apart from rounding: no partial step at the beginning
  const double nearest = std::round(steps);
  const bool whole = nearest >= 1 && std::abs(steps - nearest) <= 1e-12 * nearest;
  const double count = whole ? nearest : std::ceil(steps);
  grid.count = static_cast<std::size_t>(count);
  // else output 0 lies before t = 0, so that the last output is the end of the run
  if (!whole) grid.outputs.origin_s = std::min(0.0, duration_s - count / grid.outputs.rate_hz);
  // the window of any other drive is the whole run
  if (scene.drive.kind != DriveKind::kSine) return grid;
  // the window is the last window_periods of the sine, in whole outputs
  grid.outputs_a_period =
      static_cast<std::size_t>(std::llround(grid.outputs.rate_hz / scene.drive.frequency_hz));
  const auto window = static_cast<std::size_t>(
      std::llround(effective.window_periods * grid.outputs.rate_hz / scene.drive.frequency_hz));
  grid.window_begin = grid.count > window ? grid.count - window : 0;
  return grid;
}

// requests the integrals of xs^2 and xa^2, and the ranges of travel and contact force
void AskForNumbers(const EffectiveScene& scene, PiecewiseLinearSystem& system) {
  const LinearModel model = AssembleModel(scene.scene);
  const Eigen::Index n = model.states();
  WatchTravelAndForce(scene.scene, scene.piecewise, system);
  system.squared_rows = {Eigen::RowVectorXd::Unit(n, model.skin()),
                         Eigen::RowVectorXd::Unit(n, LinearModel::kCase)};
}

// energy into the coil's resistance, J
double CoilOf(const EnergyLedger& ledger) {
  return ledger.dissipated_j[static_cast<std::size_t>(SceneElement::kCoil)];
}

// the integral of i^2 dt in A^2 s; with a constant resistance from the coil's dissipated energy
double CurrentSquares(const PiecewiseMotion& motion, double resistance_ohm) {
  return CoilOf(motion.Ledger()) / resistance_ohm;
}
double CurrentSquares(const SmoothMotion& motion, double /*resistance_ohm*/) {
  return motion.CurrentSquareIntegral();
}

// the coil's rise in K at the end and at most; an exact motion has no heating
double RiseOf(const PiecewiseMotion& /*motion*/) { return 0; }
double RiseOf(const SmoothMotion& motion) { return motion.temperature_rise_k(); }
double PeakRiseOf(const PiecewiseMotion& /*motion*/) { return 0; }
double PeakRiseOf(const SmoothMotion& motion) { return motion.temperature_peak_k(); }

// Bounds of a number's error at the outputs where it was evaluated.
struct ErrorOfNumber {
  double squares = 0;
  double largest = 0;
  std::size_t count = 0;
  double last = 0;
  double peak = 0;  // of the number itself, since the beginning

  void Take(double error, double value) {
    last = error;
    peak = std::max(peak, std::abs(value));
    squares += error * error;
    largest = std::max(largest, error);
    ++count;
  }
  double Rms() const { return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0; }
  double Relative() const { return last == 0 ? 0 : last / peak; }
};

struct Errors {
  ErrorOfNumber skin, motor, travel, current;

  // the running peak and the last error stay: the relative error refers to the whole run
  void BeginWindow() {
    for (ErrorOfNumber* number : {&skin, &motor, &travel, &current}) {
      *number = {.last = number->last, .peak = number->peak};
    }
  }
};

// Plays a motion and gathers what its window shows.
template <typename Motion>
class Playing {
 public:
  Playing(const EffectiveScene& scene, double duration_s, std::unique_ptr<Motion> motion)
      : scene_(scene),
        grid_(GridOf(scene, duration_s)),
        model_(AssembleModel(scene.scene)),
        motion_owner_(std::move(motion)),
        motion_(*motion_owner_) {
    run_.outputs_rate_hz = grid_.outputs.rate_hz;
    run_.end_s = duration_s;
    run_.begin_s = grid_.window_begin == 0 ? 0 : TimeOf(grid_.window_begin);
    // the window's outputs, both ends included
    run_.skin_m.resize(static_cast<Eigen::Index>(grid_.count - grid_.window_begin + 1));
  }

  SceneRun Play() {
    if (grid_.window_begin == 0) BeginWindow();
    const std::size_t most_events = kMostEvents + kMostEventsPerOutput * grid_.count;
    while (motion_.index() < grid_.count && !motion_.stalled_at_s()) {
      motion_.Next();
      // bodies that rattle far faster than the drive would take too long
      if (motion_.events().size() > most_events) return GiveUp();
      if (motion_.index() % kReportOutputs == 0) {
        ReportWork("playing the run",
                   static_cast<double>(motion_.index()) / static_cast<double>(grid_.count));
      }
      if (motion_.index() == grid_.window_begin) BeginWindow();
      TakeMark();
      TakeSkin();
      TakeErrors();
    }
    Finish();
    return std::move(run_);
  }

 private:
  double TimeOf(std::size_t output) const {
    return grid_.outputs.origin_s + static_cast<double>(output) / grid_.outputs.rate_hz;
  }

  // the ranges since the last call: before the window at its begin, within it at the end
  void TakePeaks() {
    const std::vector<ValueRange>& ranges = motion_.Ranges();
    const double peak_m = ranges[kWatchedTravel].LargestMagnitude();
    run_.mover_peak_m = peak_m;
    run_.mover_peak_of_run_m = std::max(run_.mover_peak_of_run_m, peak_m);
    run_.skin_force_least_n = std::min(run_.skin_force_least_n, ranges[kWatchedForce].least);
    run_.temperature_peak_k = std::max(run_.temperature_peak_k, PeakRiseOf(motion_));
  }

  void BeginWindow() {
    // peaks of the transient first, then ranges and sums begin again
    TakePeaks();
    motion_.ForgetRanges();
    errors_.BeginWindow();
    // integrals up to the window's begin; the window's are differences to these
    const std::vector<double> squares = motion_.SquareIntegrals();
    skin_before_ = squares[0];
    case_before_ = squares[1];
    current_before_ = CurrentSquares(motion_, scene_.scene.actuator.resistance_ohm);
    input_before_j_ = motion_.Ledger().input_j;
    if (grid_.window_begin == 0) TakeSkin();
  }

  // the state at each of the last ends of whole periods, counted back from the end of the run
  void TakeMark() {
    const std::size_t left = grid_.count - motion_.index();
    if (grid_.outputs_a_period == 0 || left % grid_.outputs_a_period != 0) return;
    if (left / grid_.outputs_a_period >= kMostMarks) return;
    run_.marks.push_back({motion_.Positions(), motion_.SquareIntegrals()[0]});
  }

  void TakeSkin() {
    if (motion_.index() < grid_.window_begin) return;
    run_.skin_m(static_cast<Eigen::Index>(motion_.index() - grid_.window_begin)) =
        motion_.Positions()(model_.skin());
  }

  // bounds of an exact motion's errors, at some outputs only because each costs matrix products
  void TakeErrors() {
    if constexpr (std::is_same_v<Motion, PiecewiseMotion>) {
      const std::uint64_t every = motion_.events().empty() ? kQuietOutputs : kBusyOutputs;
      const bool is_last = motion_.index() == grid_.count;
      if (motion_.stalled_at_s() || (motion_.index() % every != 0 && !is_last)) return;
      const Eigen::VectorXd x = motion_.Positions();
      const auto unit = [&](Eigen::Index place) {
        return Eigen::RowVectorXd::Unit(x.size(), place);
      };
      const Eigen::RowVectorXd mover = unit(LinearModel::kMover), motor = unit(LinearModel::kCase);
      // xs, xa, xv - xa and i
      errors_.skin.Take(motion_.ErrorOf(unit(model_.skin())), x(model_.skin()));
      errors_.motor.Take(motion_.ErrorOf(motor), x(LinearModel::kCase));
      errors_.travel.Take(motion_.ErrorOf(mover - motor), (mover - motor).dot(x));
      errors_.current.Take(motion_.ErrorOfCurrent(), motion_.CurrentA());
      // the first output at which skin, travel or current are no longer known to the tolerance
      const double relative = std::max(
          {errors_.skin.Relative(), errors_.travel.Relative(), errors_.current.Relative()});
      if (!run_.known_until_s && relative > scene_.scene.tolerance) {
        run_.known_until_s = TimeOf(motion_.index());
      }
    }
  }

  // bound of the relative error of all numbers of an exact motion
  double ErrorEstimate(const std::vector<double>& squares) const {
    const auto part = [](double error, double value) {
      return error == 0 ? 0 : error / std::abs(value);
    };
    // a window's integral is a difference of two, which amplifies their rounding
    const auto integral = [&](double before, double after) {
      return after > before ? kIntegralRounding * after / (after - before) : 0;
    };
    // the largest voltage times the current's RMS error bounds the error of the power, W
    const double power_w = LargestVoltageV(scene_.scene.drive) *
                           (errors_.current.Rms() + kIntegralRounding * run_.current_rms_a);
    const double largest =
        std::max({part(errors_.skin.Rms(), run_.skin_rms_m) + integral(skin_before_, squares[0]),
                  part(errors_.motor.Rms(), run_.case_rms_m) + integral(case_before_, squares[1]),
                  part(errors_.current.Rms(), run_.current_rms_a), part(power_w, run_.power_w),
                  part(errors_.travel.largest, run_.mover_peak_m),
                  part(errors_.skin.largest, run_.skin_m.cwiseAbs().maxCoeff())});
    return largest + DriveError(scene_.scene) + kExactRounding;
  }

  // a run with too many events ends at the last one
  SceneRun GiveUp() {
    run_.stalled_at_s = motion_.events().back().time_s;
    run_.stall_reason = FindingKind::kTooManyEvents;
    CountEvents();
    return std::move(run_);
  }

  void Finish() {
    TakePeaks();
    run_.stalled_at_s = motion_.stalled_at_s();
    run_.stall_reason = motion_.stall_reason();
    run_.temperature_rise_k = RiseOf(motion_);
    run_.ledger = motion_.Ledger();
    const double length_s = run_.end_s - run_.begin_s;
    const std::vector<double> squares = motion_.SquareIntegrals();
    // rounding may put an integral of 0 below 0
    const auto rms = [&](double integral) { return std::sqrt(std::max(0.0, integral) / length_s); };
    run_.skin_rms_m = rms(squares[0] - skin_before_);
    run_.case_rms_m = rms(squares[1] - case_before_);
    run_.current_rms_a =
        rms(CurrentSquares(motion_, scene_.scene.actuator.resistance_ohm) - current_before_);
    // mean power: energy from the source over the window's length, W
    run_.power_w = (run_.ledger.input_j - input_before_j_) / length_s;
    CountEvents();
    if constexpr (std::is_same_v<Motion, PiecewiseMotion>) {
      run_.error_estimate = ErrorEstimate(squares);
    }
  }

  void CountEvents() {
    for (const Event& event : motion_.events()) {
      const std::string_view name = motion_.system().transitions[event.transition].name;
      const auto known = std::ranges::find(run_.events, name, &EventCount::name);
      if (known != run_.events.end()) {
        ++known->count;
      } else {
        run_.events.push_back({.name = name, .count = 1, .first_s = event.time_s});
      }
    }
  }

  const EffectiveScene& scene_;
  RunGrid grid_;
  LinearModel model_;
  std::unique_ptr<Motion> motion_owner_;
  Motion& motion_;
  SceneRun run_;
  Errors errors_;
  double skin_before_ = 0, case_before_ = 0, current_before_ = 0, input_before_j_ = 0;
};

// Whether events can be located in reasonable time: a judged interval is no longer than
// GuardBound::LongestHorizon, and motions that decay or oscillate far faster than the drive need
// many.
bool CanLookForEvents(const PiecewiseLinearSystem& system, const RunGrid& grid) {
  if (system.transitions.empty()) return true;
  const double step_s = 1 / grid.outputs.rate_hz;
  double most = 0, first = 0;
  for (const Mode& mode : system.modes) {
    // judged intervals in one output step
    const double intervals = step_s / GuardBound::LongestHorizon(mode.a);
    most = std::max(most, intervals);
    if (&mode == &system.modes.front()) first = intervals;
  }
  // every mode within one output step, and the mode of the start over the whole run
  return most <= kMostIntervalsPerOutput &&
         first * static_cast<double>(grid.count) <= PiecewiseMotion::MostSteps(grid.count);
}

SceneRun RunExactly(const EffectiveScene& scene, double duration_s, PiecewiseStart start) {
  const Scene& bodies = scene.scene;
  PiecewiseLinearSystem system = AssemblePiecewise(bodies, scene.piecewise);
  AskForNumbers(scene, system);
  const RunGrid grid = GridOf(scene, duration_s);
  // refused before the run instead of a stall after the limit of steps
  if (!CanLookForEvents(system, grid)) {
    SceneRun run;
    run.stalled_at_s = 0;
    run.stall_reason = FindingKind::kBodiesTooFast;
    return run;
  }
  auto motion = std::make_unique<PiecewiseMotion>(std::move(system),
                                                  Excitation(bodies.drive, bodies.finger.tones),
                                                  std::move(start), grid.outputs, true);
  return Playing(scene, duration_s, std::move(motion)).Play();
}

// How many times less a run leaves out than a coarser one: by its tolerance, or by its steps where
// pieces and events begin them anew so often that they do not follow the tolerance.
double FinerThan(const SceneRun& coarse, const SceneRun& run) {
  const double steps = static_cast<double>(run.work.steps) / static_cast<double>(coarse.work.steps);
  return std::min(coarse.solver_tolerance / run.solver_tolerance, Pow(steps, kStepOrder));
}

// runs with smaller and smaller tolerance until their difference is within scene.tolerance
SceneRun RunAsAsked(const EffectiveScene& scene, double duration_s, const PiecewiseStart& start,
                    double temperature_rise_k) {
  const auto play = [&](const SmoothSettings& settings) {
    return RunSmoothly(scene, duration_s, start, temperature_rise_k, settings);
  };
  SolverLadder ladder(scene.scene.tolerance);
  SceneRun coarse = play(ladder.before());
  // a smaller tolerance takes more steps
  if (coarse.stall_reason == FindingKind::kTooManySteps) return coarse;
  SolverWork work = coarse.work;
  for (;; ladder.Refine()) {
    SceneRun run = play(ladder.settings());
    work += run.work;
    run.error_estimate = ErrorOf(run, coarse, FinerThan(coarse, run));
    // of a chaotic motion no tolerance reduces the error
    const bool ends = run.stalled_at_s || ladder.EndsWith(run.error_estimate) ||
                      run.error_estimate > kWorthIt * coarse.error_estimate;
    if (ends) {
      run.work = work;
      return run;
    }
    coarse = std::move(run);
  }
}

// relative deviation; 0 for equal numbers, also for two zeros
double Relative(double value, double reference) {
  if (value == reference) return 0;
  return std::abs(value - reference) / std::abs(reference);
}

}  // namespace

bool SceneRun::IsFinite() const {
  return std::isfinite(skin_rms_m) && std::isfinite(case_rms_m) && std::isfinite(current_rms_a) &&
         std::isfinite(power_w) && std::isfinite(mover_peak_of_run_m) && skin_m.allFinite() &&
         std::isfinite(temperature_rise_k);
}

double Deviation(AskedQuantity quantity, const SceneRun& run, const SceneRun& reference) {
  switch (quantity) {
    case AskedQuantity::kSkinRms:
      return Relative(run.skin_rms_m, reference.skin_rms_m);
    case AskedQuantity::kMoverPeak:
      return Relative(run.mover_peak_m, reference.mover_peak_m);
    case AskedQuantity::kCurrentRms:
      return Relative(run.current_rms_a, reference.current_rms_a);
    case AskedQuantity::kSkinWaveform:
      break;
  }
  // motions of different periods have windows of different lengths, which do not compare
  if (run.skin_m.size() != reference.skin_m.size()) return std::numeric_limits<double>::infinity();
  const double peak_m = reference.skin_m.cwiseAbs().maxCoeff();
  const double apart_m = (run.skin_m - reference.skin_m).cwiseAbs().maxCoeff();
  return apart_m == 0 ? 0 : apart_m / peak_m;
}

double LargestDeviation(const SceneRun& run, const SceneRun& reference) {
  return std::max({Relative(run.skin_rms_m, reference.skin_rms_m),
                   Relative(run.case_rms_m, reference.case_rms_m),
                   Relative(run.current_rms_a, reference.current_rms_a),
                   Relative(run.power_w, reference.power_w),
                   Relative(run.mover_peak_m, reference.mover_peak_m),
                   Relative(run.mover_peak_of_run_m, reference.mover_peak_of_run_m)});
}

double ErrorOf(const SceneRun& run, const SceneRun& coarse, double finer) {
  if (run.stalled_at_s || coarse.stalled_at_s || !run.IsFinite() || !coarse.IsFinite()) {
    return std::numeric_limits<double>::infinity();
  }
  // the same tolerance gives the same run: the difference shows nothing of its error
  if (finer <= 1) return coarse.error_estimate;
  // the largest deviation over quantities, waveform, power, peaks and temperatures
  double largest = 0;
  for (std::size_t k = 0; k < kAskedQuantityNames.size(); ++k) {
    largest = std::max(largest, Deviation(static_cast<AskedQuantity>(k), coarse, run));
  }
  largest = std::max({largest, LargestDeviation(coarse, run),
                      Relative(coarse.temperature_rise_k, run.temperature_rise_k),
                      Relative(coarse.temperature_peak_k, run.temperature_peak_k)});
  const double rounding = kSolverRounding + kStepRounding * static_cast<double>(run.work.steps) +
                          kIterationPart * run.solver_tolerance;
  // an n times smaller tolerance leaves at most kLeftOver / n of the deviation, and moves the run
  // by no more than the deviation
  return std::min(largest * kLeftOver / finer, coarse.error_estimate + largest) + rounding;
}

double DriveError(const Scene& scene) {
  const double error_v = Excitation(scene.drive, scene.finger.tones).voltage_error_v();
  return error_v == 0 ? 0 : error_v / std::abs(scene.drive.amplitude_v);
}

SceneRun RunScene(const EffectiveScene& scene, double duration_s) {
  return RunScene(scene, duration_s, StartIn(scene));
}

SceneRun RunScene(const EffectiveScene& scene, double duration_s, PiecewiseStart start,
                  double temperature_rise_k) {
  if (scene.IsLinear()) return RunExactly(scene, duration_s, std::move(start));
  return RunAsAsked(scene, duration_s, start, temperature_rise_k);
}

SceneRun RunSmoothly(const EffectiveScene& scene, double duration_s, PiecewiseStart start,
                     double temperature_rise_k, SmoothSettings settings) {
  const Scene& bodies = scene.scene;
  SmoothSystem system = AssembleSmooth(bodies, scene.piecewise, scene.smooth);
  AskForNumbers(scene, system.linear);
  const RunGrid grid = GridOf(scene, duration_s);
  const auto outputs = static_cast<std::int64_t>(grid.count);
  settings.with_energy = true;
  settings.most_steps = std::min(kMostSteps + kMostStepsPerOutput * outputs, kMostStepsOfAll);
  auto motion = std::make_unique<SmoothMotion>(
      std::move(system), Excitation(bodies.drive, bodies.finger.tones), std::move(start),
      grid.outputs, settings, temperature_rise_k);
  const SmoothMotion& played = *motion;
  Playing playing(scene, duration_s, std::move(motion));
  SceneRun run = playing.Play();
  run.solver_tolerance = played.tolerance();
  run.work = played.work();
  // a single run gives no estimate; ErrorOf() needs two
  run.error_estimate = std::numeric_limits<double>::infinity();
  return run;
}

}  // namespace haptometer::sim
