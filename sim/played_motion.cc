#include "sim/played_motion.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "sim/excitation.h"
#include "sim/hermite.h"
#include "sim/linear_model.h"
#include "sim/output_rate.h"
#include "sim/piecewise_motion.h"
#include "sim/smooth_motion.h"
#include "sim/smooth_scene.h"
#include "sim/solver_ladder.h"

namespace haptometer::sim {

namespace {

constexpr std::size_t kKeptOutputs = 4096;

// plays as far as it is asked to and remembers the last outputs
template <typename Motion>
class Player {
 public:
  using Beginning = std::function<std::unique_ptr<Motion>(double rate_hz)>;

  Player(const EffectiveScene& scene, SensorTarget target, Beginning beginning)
      : beginning_(std::move(beginning)),
        position_(StateOf(AssembleModel(scene.scene), target)),
        rate_hz_(scene.RateHz()) {
    Begin();
  }

  double At(double t_s) {
    const std::scoped_lock lock(mutex_);
    const double outputs = std::max(0.0, t_s) * rate_hz_;
    const auto before = static_cast<std::size_t>(outputs);
    if (before < first_) Begin();
    while (first_ + jets_.size() < before + 2 && !motion_->stalled_at_s()) Next();
    if (first_ + jets_.size() < before + 2) return std::numeric_limits<double>::quiet_NaN();
    const MotionJet& begin = jets_[before - first_];
    const HermiteQuintic between(begin, jets_[before - first_ + 1], 1 / rate_hz_);
    return between.At(outputs - static_cast<double>(before));
  }

 private:
  void Begin() {
    motion_ = beginning_(rate_hz_);
    jets_.clear();
    first_ = 0;
    Keep();
  }

  void Next() {
    motion_->Next();
    if (motion_->stalled_at_s()) return;
    Keep();
    if (jets_.size() <= kKeptOutputs) return;
    jets_.pop_front();
    ++first_;
  }

  // the velocity follows the position among the states
  void Keep() {
    const Eigen::VectorXd x = motion_->Positions();
    jets_.push_back(
        {.x = x(position_), .v = x(position_ + 1), .a = motion_->Rates()(position_ + 1)});
  }

  Beginning beginning_;
  Eigen::Index position_;
  double rate_hz_;
  std::mutex mutex_;
  std::unique_ptr<Motion> motion_;
  std::deque<MotionJet> jets_;  // of outputs first_, first_ + 1, ...
  std::size_t first_ = 0;
};

// shared, because a std::function is copied freely
template <typename Motion>
trial::Displacement Played(const EffectiveScene& scene, SensorTarget target,
                           typename Player<Motion>::Beginning beginning) {
  auto player = std::make_shared<Player<Motion>>(scene, target, std::move(beginning));
  return [player = std::move(player)](double t_s) { return player->At(t_s); };
}

Excitation ExcitationOf(const Scene& scene) { return {scene.drive, scene.finger.tones}; }

}  // namespace

trial::Displacement PlayedMotion(const EffectiveScene& scene, PiecewiseStart start,
                                 SensorTarget target, double temperature_rise_k) {
  if (scene.IsLinear()) {
    return Played<PiecewiseMotion>(
        scene, target, [scene, start = std::move(start)](double rate_hz) {
          return std::make_unique<PiecewiseMotion>(AssemblePiecewise(scene.scene, scene.piecewise),
                                                   ExcitationOf(scene.scene), start,
                                                   OutputGrid{.rate_hz = rate_hz});
        });
  }
  return Played<SmoothMotion>(
      scene, target, [scene, start = std::move(start), temperature_rise_k](double rate_hz) {
        const SmoothSettings settings{.tolerance = SolverLadder(scene.scene.tolerance).tolerance(),
                                      .most_steps = std::numeric_limits<std::int64_t>::max()};
        return std::make_unique<SmoothMotion>(
            AssembleSmooth(scene.scene, scene.piecewise, scene.smooth), ExcitationOf(scene.scene),
            start, OutputGrid{.rate_hz = rate_hz}, settings, temperature_rise_k);
      });
}

}  // namespace haptometer::sim
