#include "sim/scene_run.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "sim/excitation.h"
#include "sim/hermite.h"
#include "sim/linear_model.h"
#include "sim/output_rate.h"
#include "sim/piecewise_motion.h"
#include "sim/scene_mode.h"

namespace haptometer::sim {

namespace {

constexpr double kWindowPeriods = 10;

// The outputs of a run: so many steps from before t = 0 to its very end.
struct RunGrid {
  OutputGrid outputs;
  std::size_t count = 0;         // the last output
  std::size_t window_begin = 0;  // an output
};

RunGrid GridOf(const Scene& scene, double duration_s) {
  RunGrid grid;
  grid.outputs.rate_hz = OutputRateHz(scene);
  const double steps = duration_s * grid.outputs.rate_hz;
  HAPTOMETER_CHECK(duration_s > 0 && steps <= kMostOutputs, "{} s at {} Hz", duration_s,
                   grid.outputs.rate_hz);
  // a whole number of steps but for rounding: no odd one at the beginning
  const double nearest = std::round(steps);
  const bool whole = nearest >= 1 && std::abs(steps - nearest) <= 1e-12 * nearest;
  const double count = whole ? nearest : std::ceil(steps);
  grid.count = static_cast<std::size_t>(count);
  if (!whole) grid.outputs.origin_s = std::min(0.0, duration_s - count / grid.outputs.rate_hz);
  // of another drive than a sine all is looked at
  if (scene.drive.kind != DriveKind::kSine) return grid;
  const auto window = static_cast<std::size_t>(
      std::llround(kWindowPeriods * grid.outputs.rate_hz / scene.drive.frequency_hz));
  grid.window_begin = grid.count > window ? grid.count - window : 0;
  return grid;
}

// Plays a motion and gathers what its window shows.
class Playing {
 public:
  Playing(const EffectiveScene& scene, double duration_s, PiecewiseStart start)
      : scene_(scene),
        grid_(GridOf(scene.scene, duration_s)),
        model_(AssembleModel(scene.scene)),
        motion_(SystemOf(scene, model_), Excitation(scene.scene.drive, scene.scene.finger.tones),
                std::move(start), grid_.outputs, true) {
    run_.outputs_rate_hz = grid_.outputs.rate_hz;
    run_.end_s = duration_s;
    run_.begin_s = grid_.window_begin == 0 ? 0 : TimeOf(grid_.window_begin);
    run_.skin_m.resize(static_cast<Eigen::Index>(grid_.count - grid_.window_begin + 1));
  }

  SceneRun Play() {
    MoverJet(before_);
    if (grid_.window_begin == 0) BeginWindow();
    while (motion_.index() < grid_.count && !motion_.stalled_at_s()) {
      motion_.Next();
      TakePeaks();
      if (motion_.index() == grid_.window_begin) BeginWindow();
      TakeSkin();
    }
    Finish();
    return std::move(run_);
  }

 private:
  static PiecewiseLinearSystem SystemOf(const EffectiveScene& scene, const LinearModel& model) {
    PiecewiseLinearSystem system = AssemblePiecewise(scene.scene, scene.piecewise);
    const Eigen::Index n = model.states();
    system.squared_rows = {Eigen::RowVectorXd::Unit(n, model.skin()),
                           Eigen::RowVectorXd::Unit(n, LinearModel::kCase)};
    return system;
  }

  double TimeOf(std::size_t output) const {
    return grid_.outputs.origin_s + static_cast<double>(output) / grid_.outputs.rate_hz;
  }

  // xv - xa, its rate and acceleration
  void MoverJet(MotionJet& jet) const {
    const Eigen::VectorXd x = motion_.Positions();
    const Eigen::VectorXd rate = motion_.Rates();
    jet.x = x(LinearModel::kMover) - x(LinearModel::kCase);
    jet.v = x(LinearModel::kMoverVelocity) - x(LinearModel::kCaseVelocity);
    jet.a = rate(LinearModel::kMoverVelocity) - rate(LinearModel::kCaseVelocity);
  }

  void TakePeaks() {
    MotionJet now;
    MoverJet(now);
    const double h_s = 1 / grid_.outputs.rate_hz;
    const bool smooth = motion_.events().size() == events_seen_ && motion_.index() > 1;
    double peak_m = smooth ? HermiteQuintic(before_, now, h_s).Peak() : std::abs(now.x);
    for (; events_seen_ < motion_.events().size(); ++events_seen_) {
      peak_m = std::max(peak_m, GapReached(motion_.events()[events_seen_]));
    }
    before_ = now;
    run_.mover_peak_of_run_m = std::max(run_.mover_peak_of_run_m, peak_m);
    if (motion_.index() > grid_.window_begin) {
      run_.mover_peak_m = std::max(run_.mover_peak_m, peak_m);
    }
  }

  // the gap that an event at a stop is about, else 0
  double GapReached(const Event& event) const {
    const std::string_view name = motion_.system().transitions[event.transition].name;
    const std::optional<TravelStops>& stops = scene_.piecewise.stops;
    if (name == "impact up" || name == "stop up") return stops->gap_up_m;
    if (name == "impact down" || name == "stop down") return stops->gap_down_m;
    return 0;
  }

  void BeginWindow() {
    const std::vector<double> squares = motion_.SquareIntegrals();
    skin_before_ = squares[0];
    case_before_ = squares[1];
    const EnergyLedger ledger = motion_.Ledger();
    coil_before_j_ = CoilOf(ledger);
    input_before_j_ = ledger.input_j;
    if (grid_.window_begin == 0) TakeSkin();
  }

  void TakeSkin() {
    if (motion_.index() < grid_.window_begin) return;
    run_.skin_m(static_cast<Eigen::Index>(motion_.index() - grid_.window_begin)) =
        motion_.Positions()(model_.skin());
  }

  static double CoilOf(const EnergyLedger& ledger) {
    return ledger.dissipated_j[static_cast<std::size_t>(SceneElement::kCoil)];
  }

  void Finish() {
    run_.stalled_at_s = motion_.stalled_at_s();
    run_.ledger = motion_.Ledger();
    const double length_s = run_.end_s - run_.begin_s;
    const std::vector<double> squares = motion_.SquareIntegrals();
    const auto rms = [&](double integral) { return std::sqrt(std::max(0.0, integral) / length_s); };
    run_.skin_rms_m = rms(squares[0] - skin_before_);
    run_.case_rms_m = rms(squares[1] - case_before_);
    run_.current_rms_a =
        rms((CoilOf(run_.ledger) - coil_before_j_) / scene_.scene.actuator.resistance_ohm);
    run_.power_w = (run_.ledger.input_j - input_before_j_) / length_s;
    CountEvents();
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
  PiecewiseMotion motion_;
  SceneRun run_;
  MotionJet before_;
  std::size_t events_seen_ = 0;
  double skin_before_ = 0, case_before_ = 0, coil_before_j_ = 0, input_before_j_ = 0;
};

}  // namespace

SceneRun RunScene(const EffectiveScene& scene, double duration_s) {
  return RunScene(scene, duration_s, PiecewiseStartOf(scene.scene));
}

SceneRun RunScene(const EffectiveScene& scene, double duration_s, PiecewiseStart start) {
  return Playing(scene, duration_s, std::move(start)).Play();
}

}  // namespace haptometer::sim
