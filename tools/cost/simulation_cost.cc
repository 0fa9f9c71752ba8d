#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "sim/linear/steady_state.h"
#include "sim/scene_run.h"
#include "sim/smooth/smooth_motion.h"
#include "tools/cost/cost.h"
#include "tools/reproduce/thesis_model.h"
#include "tools/simulate/scene_answer.h"

namespace haptometer::tools {
namespace {

constexpr double kRounding = 1e-15;     // no error is predicted below
constexpr double kErrorMargin = 10;     // of the bound over what a part of the run shows
constexpr double kShortS = 0.02;        // an answer that takes less is timed once more
constexpr double kLeastPeriods = 12;    // of a part that is timed: RMS windows are ten
constexpr double kSearchPeriods = 100;  // of PiecewiseMotion until a steady motion is found
constexpr double kSmoothSearchPeriods = 300;
constexpr int kTimedAnswers = 3;

struct TimedAnswer {
  SceneAnswer answer;
  double seconds = 0;
};

// solves the scene and takes the time; what is quick again, for the best of three
Result<TimedAnswer> Timed(const sim::Scene& scene, const std::string& where, int most) {
  TimedAnswer timed{.answer = {}, .seconds = HUGE_VAL};
  for (int k = 0; k < most; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    HAPTOMETER_LET(timed.answer, AnswerScene(scene, where));
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    timed.seconds = std::min(timed.seconds, taken.count());
    if (taken.count() > kShortS) break;
  }
  return timed;
}

// this program's method for an answer, and what limits its digits
CostedMethod MethodOf(const SceneAnswer& answer) {
  const sim::SceneRun* const run = RunOf(answer);
  CostedMethod method{.method = "exact phasors", .limited_by = "rounding"};
  if (run != nullptr && run->solver_tolerance > 0) {
    method.method = "exponential collocation";
    method.limited_by = "steps of the solver";
  } else if (run != nullptr && !run->events.empty()) {
    method.method = "exact between events";
    method.limited_by = "times of events";
  } else if (run != nullptr || answer.scene.duration_s) {
    method.method = "matrix exponential";
  }
  method.settings = fmt::format("--accuracy {:g}", answer.scene.tolerance);
  return method;
}

// a period of the drive, or of a drive without one a thousandth of the run
double PeriodS(const sim::Scene& scene) {
  if (scene.drive.kind == sim::DriveKind::kSine) return 1 / scene.drive.frequency_hz;
  return scene.duration_s.value_or(1) / 1000;
}

// the error that an answer states, which a prediction of it equals
double Stated(const SceneAnswer& answer) { return std::max(kRounding, ErrorOfAll(answer)); }

// Whether the solver of a part has a smaller tolerance left for the whole.
bool CanRefine(const sim::SceneRun& part) {
  constexpr double kRounds = 1 + 1e-9;  // of a tolerance
  return part.solver_tolerance > kRounds * sim::SolverLadder(0).settings().tolerance;
}

// A bound of what the whole states, which has `longer` times what a part states of its error. The
// solver keeps what is asked for or refuses, as long as it has a smaller tolerance left.
double Bound(const SceneAnswer& part, double longer) {
  const double asked = part.scene.tolerance;
  // the drive's cubics do not depend on the length, and what "auto" leaves out takes at most half
  // of what is asked for
  const double of_drive = sim::DriveError(part.scene);
  const double of_auto = part.effects ? part.effects->change : 0;
  const double whole = std::max(0.0, longer * (ErrorOfAll(part) - of_drive - of_auto));
  const double bound = std::max(kRounding, kErrorMargin * whole) +
                       std::min(kErrorMargin * longer * of_auto, asked / 2);
  const sim::SceneRun* const run = RunOf(part);
  const bool is_solved = run != nullptr && run->solver_tolerance > 0;
  const bool is_kept = is_solved && (whole <= asked || CanRefine(*run));
  return of_drive + (is_kept ? std::min(bound, asked) : bound);
}

// times a sixteenth and an eighth of the run, and continues the line
Result<CostedMethod> PriceOfRun(const sim::Scene& scene, const std::string& where) {
  sim::Scene part = scene;
  const double whole_s = *scene.duration_s;
  const double least_s = kLeastPeriods * PeriodS(scene);
  part.duration_s = std::min(whole_s, std::max(whole_s / 16, least_s));
  HAPTOMETER_LET(const auto first, Timed(part, where, kTimedAnswers));
  const double first_s = *part.duration_s;
  part.duration_s = std::min(whole_s, 2 * first_s);
  HAPTOMETER_LET(const auto second, Timed(part, where, kTimedAnswers));
  const double second_s = *part.duration_s;
  CostedMethod method = MethodOf(second.answer);
  // seconds of computing for each second beyond the second part
  const double slope =
      second_s > first_s ? std::max(0.0, second.seconds - first.seconds) / (second_s - first_s) : 0;
  method.predicted_s = second.seconds + slope * (whole_s - second_s);
  method.predicted_error =
      second_s < whole_s ? Bound(second.answer, whole_s / second_s) : Stated(second.answer);
  return method;
}

// a steady motion under effects: the periods of its search, at what a period of a run takes
Result<CostedMethod> PriceOfSearch(const sim::Scene& scene, const std::string& where) {
  constexpr double kTimedPeriods = 16;
  sim::Scene part = scene;
  part.duration_s = kTimedPeriods * PeriodS(scene);
  part.start = sim::Start::kRest;
  HAPTOMETER_LET(const auto run, Timed(part, where, kTimedAnswers));
  CostedMethod method = MethodOf(run.answer);
  const bool smooth = RunOf(run.answer) != nullptr && RunOf(run.answer)->solver_tolerance > 0;
  const double periods = smooth ? kSmoothSearchPeriods : kSearchPeriods;
  method.predicted_s = run.seconds * periods / kTimedPeriods;
  // what shooting adds to the error of a run
  constexpr double kOfSearch = 10;
  method.predicted_error = Bound(run.answer, kOfSearch);
  return method;
}

// whether a steady motion has to be searched for
bool IsSearched(const sim::Scene& scene) {
  return !scene.duration_s && scene.effects.Asked() && scene.drive.kind == sim::DriveKind::kSine;
}

// the class of the ladders that is most like a scene: what bends it, then what limits it
SceneClass ClassOf(const sim::Scene& scene) {
  const auto on = [&](sim::Effect effect) { return scene.effects[effect] != sim::Wish::kOff; };
  if (on(sim::Effect::kStiffening) || on(sim::Effect::kCoilHeating)) return SceneClass::kSmooth;
  if (on(sim::Effect::kContactLoss)) return SceneClass::kContact;
  return on(sim::Effect::kTravelStops) ? SceneClass::kStops : SceneClass::kLinear;
}

// the length of run that methods which integrate need: without a duration until the motion is
// steady, and a window of ten periods
double IntegratedS(const sim::Scene& scene) {
  if (scene.duration_s) return *scene.duration_s;
  constexpr double kWindowPeriods = 10;
  return sim::RingDownS(scene).value_or(1) + kWindowPeriods * PeriodS(scene);
}

// other programs' methods by their cheapest rungs that are good enough
void AddPeers(const sim::Scene& scene, Simulated what, double ratio, CostAnswer& answer) {
  const SceneClass scene_class = ClassOf(scene);
  // steps follow the periods: those of the ladders' run are 22.5
  const double ladder_periods =
      kLadderDurationS * LadderScene(scene_class).scene.drive.frequency_hz;
  const double scale = ratio * IntegratedS(scene) / PeriodS(scene) / ladder_periods;
  std::vector<CostedMethod> peers;
  for (const Rung& rung : ShippedRungs()) {
    const double error = ErrorOf(rung, what);
    if (rung.scene_class != scene_class || IsOwn(rung.method) || !(error <= answer.accuracy)) {
      continue;
    }
    CostedMethod peer{.method = rung.method,
                      .settings = rung.setting,
                      .predicted_s = rung.seconds * scale,
                      .predicted_error = error,
                      .error_of = fmt::format("the ladders' scene, {}", NameOf(scene_class)),
                      .limited_by = "steps",
                      .answers = true,
                      .is_peer = true};
    const auto same = std::ranges::find(peers, peer.method, &CostedMethod::method);
    if (same == peers.end()) {
      peers.push_back(std::move(peer));
    } else if (*peer.predicted_s < *same->predicted_s) {
      *same = std::move(peer);
    }
  }
  answer.methods.insert(answer.methods.end(), peers.begin(), peers.end());
}

// skin RMS of the thesis's adapter scene with one number of it changed
double SkinRmsWith(void (*change)(sim::Scene&)) {
  const ThesisModel model;
  sim::Scene scene = WithAdapter(model, kSimulatedConeAreaM2);
  change(scene);
  return sim::SolveSteadyState(scene).skin_rms_m;
}

}  // namespace

void SortMethods(std::vector<CostedMethod>& methods) {
  // what is not known comes last; what does not answer by how near it comes
  std::ranges::sort(methods, {}, [](const CostedMethod& method) {
    constexpr double kUnknown = std::numeric_limits<double>::infinity();
    return std::tuple(!method.answers, method.answers ? method.recording_s.value_or(kUnknown) : 0,
                      method.answers ? 0 : method.predicted_error.value_or(kUnknown),
                      method.predicted_s.value_or(0), method.method);
  });
}

Result<CostedMethod> PriceOf(const sim::Scene& scene, const std::string& where) {
  if (IsSearched(scene)) return PriceOfSearch(scene, where);
  if (scene.duration_s) return PriceOfRun(scene, where);
  HAPTOMETER_LET(const auto timed, Timed(scene, where, kTimedAnswers));
  CostedMethod method = MethodOf(timed.answer);
  method.predicted_s = timed.seconds;
  method.predicted_error = Stated(timed.answer);
  return method;
}

Result<CostAnswer> CostOfSimulation(const sim::Scene& scene, Simulated what,
                                    const std::string& where, bool measure) {
  CostAnswer answer{.question = what == Simulated::kSkinRms ? "skin-rms" : "waveform",
                    .subject = where,
                    .accuracy = scene.tolerance};
  HAPTOMETER_LET(CostedMethod own, PriceOf(scene, where));
  if (measure) {
    HAPTOMETER_LET(const auto timed, Timed(scene, where, kTimedAnswers));
    own.measured_s = timed.seconds;
    own.measured_error = ErrorOfAll(timed.answer);
  }
  own.error_of = "this scene";
  own.answers = own.measured_error.value_or(*own.predicted_error) <= answer.accuracy;
  answer.methods.push_back(std::move(own));
  const double ratio = ProbeMachine(ClassOf(scene));
  AddPeers(scene, what, ratio, answer);
  SortMethods(answer.methods);
  answer.notes.Find(
      Severity::kNote, "prices-of-ladders",
      "the ladders' scene is the thesis's adapter scene ({class}), 0.1 s from rest: other "
      "programs' errors are of that scene alone, and their times are scaled by the number of "
      "periods, times {ratio} for this machine",
      {{"class", std::string(NameOf(ClassOf(scene)))}, {"ratio", ratio}});
  return answer;
}

std::vector<KnowledgeLimit> KnowledgeLimits() {
  const double rms_m = SkinRmsWith([](sim::Scene&) {});
  const auto change = [rms_m](void (*by)(sim::Scene&)) {
    return std::abs(SkinRmsWith(by) / rms_m - 1);
  };
  return {
      {"moving mass", "1 %",
       change([](sim::Scene& scene) { scene.actuator.moving_mass_kg *= 1.01; })},
      {"spring of the actuator", "1 %",
       change([](sim::Scene& scene) { scene.actuator.stiffness_n_per_m *= 1.01; })},
      {"damping of the actuator", "10 %",
       change([](sim::Scene& scene) { scene.actuator.damping_n_s_per_m *= 1.1; })},
      {"skin, stiffness and damping", "a factor of 2", change([](sim::Scene& scene) {
         scene.skin.stiffness_n_per_m *= 2;
         scene.skin.damping_n_s_per_m *= 2;
       })},
  };
}

}  // namespace haptometer::tools
