#include "sim/waveforms.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "sim/linear/excitation.h"
#include "sim/linear/linear_model.h"
#include "sim/piecewise/piecewise_scene.h"
#include "sim/scene_run.h"
#include "sim/smooth/semilinear_solver.h"
#include "sim/smooth/smooth_motion.h"
#include "sim/smooth/smooth_system.h"
#include "sim/steady_run.h"

namespace haptometer::sim {
namespace {

// Plays a motion and records its waveforms.
template <typename Motion>
class Recording {
 public:
  Recording(const EffectiveScene& scene, double duration_s, double rate_hz, Motion& motion)
      : scene_(scene),
        skin_(scene.scene.skin),
        skin_place_(AssembleModel(scene.scene).skin()),
        finger_moves_(!scene.scene.finger.tones.empty()),
        resting_n_(RestingForceN(scene)),
        // the allowance keeps the last row of a duration of whole steps
        rows_(static_cast<Eigen::Index>(std::floor(duration_s * rate_hz * (1 + 1e-12))) + 1),
        motion_(motion) {
    waves_.rate_hz = rate_hz;
    Resize(rows_);
  }

  Waveforms Play() {
    Take(0);
    Eigen::Index row = 1;
    while (row < rows_) {
      // rows without events at once, else one output
      if (const Eigen::Index taken = TakeUnwatched(row); taken > 0) {
        row += taken;
        continue;
      }
      motion_.Next();
      if (motion_.stalled_at_s()) break;
      Take(row++);
    }
    waves_.stalled_at_s = motion_.stalled_at_s();
    // the least force between rows too, N
    if (!motion_.Ranges().empty()) {
      waves_.force_least_n = resting_n_ + motion_.Ranges()[kWatchedForce].least;
    }
    if (row < rows_) Resize(row);
    return std::move(waves_);
  }

 private:
  // half of the modes are in contact, the other half in flight (piecewise_scene.h)
  bool InFlight() const {
    return scene_.piecewise.contact_loss && 2 * motion_.mode() >= motion_.system().modes.size();
  }

  void Resize(Eigen::Index rows) {
    for (Eigen::VectorXd* wave :
         {&waves_.voltage_v, &waves_.current_a, &waves_.mover_m, &waves_.mover_m_per_s,
          &waves_.case_m, &waves_.case_m_per_s, &waves_.skin_m, &waves_.skin_m_per_s,
          &waves_.force_n, &waves_.events}) {
      wave->conservativeResize(rows);
    }
    if (finger_moves_) waves_.finger_m.conservativeResize(rows);
  }

  void Take(Eigen::Index row) {
    Put(row, motion_.Positions(), motion_.Inputs(), motion_.CurrentA());
    if (InFlight()) waves_.force_n(row) = 0;
    // events since the row before
    waves_.events(row) = static_cast<double>(motion_.events().size() - events_seen_);
    events_seen_ = motion_.events().size();
  }

  // as many rows as a motion without events computes at once; returns their number
  Eigen::Index TakeUnwatched(Eigen::Index row) {
    if constexpr (std::is_same_v<Motion, PiecewiseMotion>) {
      const Mode& mode = motion_.system().modes[motion_.mode()];
      const bool current_is_state = mode.current_per_volt == 0;  // the last
      const Eigen::Index count =
          motion_.NextUnwatched(rows_ - row, [&](Eigen::Index i, const auto& x, double voltage_v) {
            const double current_a =
                current_is_state ? x[x.size() - 1]
                                 : mode.current_row.dot(x) + mode.current_per_volt * voltage_v;
            Put(row + i, x, Eigen::Vector3d(voltage_v, 0, 0), current_a);
          });
      waves_.events.segment(row, count).setZero();
      return count;
    }
    return 0;
  }

  template <typename Positions, typename Inputs>
  void Put(Eigen::Index row, const Positions& x, const Inputs& inputs, double current_a) {
    waves_.voltage_v(row) = inputs[kVoltage];
    waves_.current_a(row) = current_a;
    waves_.mover_m(row) = x[LinearModel::kMover];
    waves_.mover_m_per_s(row) = x[LinearModel::kMoverVelocity];
    waves_.case_m(row) = x[LinearModel::kCase];
    waves_.case_m_per_s(row) = x[LinearModel::kCaseVelocity];
    waves_.skin_m(row) = x[skin_place_];
    waves_.skin_m_per_s(row) = x[skin_place_ + 1];
    if (finger_moves_) waves_.finger_m(row) = inputs[kFinger];
    // F = resting force + Ks (xs - xg) + Bs (vs - vg)
    waves_.force_n(row) = resting_n_ +
                          skin_.stiffness_n_per_m * (x[skin_place_] - inputs[kFinger]) +
                          skin_.damping_n_s_per_m * (x[skin_place_ + 1] - inputs[kFingerRate]);
  }

  const EffectiveScene& scene_;
  Skin skin_;
  Eigen::Index skin_place_;  // its velocity behind it
  bool finger_moves_;
  double resting_n_;
  Eigen::Index rows_;
  Motion& motion_;
  Waveforms waves_;
  std::size_t events_seen_ = 0;
};

}  // namespace

double RestingForceN(const EffectiveScene& scene) {
  // the effective preload includes what presses at rest
  if (scene.piecewise.contact_loss) return scene.piecewise.contact_loss->preload_n;
  const Effects& effects = scene.scene.effects;
  const double press_n = PressOnSkin(scene.scene, effects[Effect::kGravity] != Wish::kOff);
  return press_n + (effects.contact_loss ? effects.contact_loss->preload_n : 0);
}

Beginning BeginningOf(const EffectiveScene& scene) {
  const Scene& body = scene.scene;
  const auto& [stops, loss] = scene.piecewise;
  const bool is_plain = !stops && !loss && scene.IsLinear() && body.finger.tones.empty();
  // a linear scene without limits has its state at t = 0 in closed form
  if (is_plain) return {.start = PiecewiseStartOf(body)};
  if (StartOf(body) == Start::kSteady && body.drive.kind == DriveKind::kSine) {
    SteadyRun settled = PlaySteady(scene);
    if (settled.run) {
      return {.start = std::move(settled.start), .temperature_rise_k = settled.temperature_rise_k};
    }
  }
  // no steady motion or no sine: from rest
  EffectiveScene resting = scene;
  resting.scene.start = Start::kRest;
  return {.start = StartIn(resting)};
}

Waveforms PlayWaveforms(const EffectiveScene& scene, Beginning beginning, double duration_s,
                        double rate_hz, bool with_least_force) {
  HAPTOMETER_CHECK(duration_s > 0 && rate_hz > 0 && duration_s * rate_hz <= kMostOutputs,
                   "{} s at {} Hz", duration_s, rate_hz);
  const Scene& bodies = scene.scene;
  Excitation excitation(bodies.drive, bodies.finger.tones);
  const OutputGrid grid{.rate_hz = rate_hz};
  if (scene.IsLinear()) {
    PiecewiseLinearSystem system = AssemblePiecewise(bodies, scene.piecewise);
    if (with_least_force) WatchTravelAndForce(bodies, scene.piecewise, system);
    PiecewiseMotion motion(std::move(system), std::move(excitation), std::move(beginning.start),
                           grid);
    return Recording(scene, duration_s, rate_hz, motion).Play();
  }
  SmoothSettings settings = SolverLadder(bodies.tolerance).settings();
  settings.most_steps = std::numeric_limits<std::int64_t>::max();
  SmoothSystem system = AssembleSmooth(bodies, scene.piecewise, scene.smooth);
  if (with_least_force) WatchTravelAndForce(bodies, scene.piecewise, system.linear);
  SmoothMotion motion(std::move(system), std::move(excitation), std::move(beginning.start), grid,
                      settings, beginning.temperature_rise_k);
  return Recording(scene, duration_s, rate_hz, motion).Play();
}

}  // namespace haptometer::sim
