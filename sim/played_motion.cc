#include "sim/played_motion.h"

#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "sim/excitation.h"
#include "sim/hermite.h"
#include "sim/linear_model.h"
#include "sim/output_rate.h"
#include "sim/piecewise_motion.h"

namespace haptometer::sim {

namespace {

constexpr std::size_t kKeptOutputs = 4096;

// plays as far as it is asked to and remembers the last outputs
class Player {
 public:
  Player(EffectiveScene scene, PiecewiseStart start, SensorTarget target)
      : scene_(std::move(scene)),
        start_(std::move(start)),
        position_(StateOf(AssembleModel(scene_.scene), target)),
        rate_hz_(OutputRateHz(scene_.scene)) {
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
    motion_ =
        std::make_unique<PiecewiseMotion>(AssemblePiecewise(scene_.scene, scene_.piecewise),
                                          Excitation(scene_.scene.drive, scene_.scene.finger.tones),
                                          start_, OutputGrid{.rate_hz = rate_hz_});
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

  EffectiveScene scene_;
  PiecewiseStart start_;
  Eigen::Index position_;
  double rate_hz_;
  std::mutex mutex_;
  std::unique_ptr<PiecewiseMotion> motion_;
  std::deque<MotionJet> jets_;  // of outputs first_, first_ + 1, ...
  std::size_t first_ = 0;
};

}  // namespace

trial::Displacement PlayedMotion(const EffectiveScene& scene, PiecewiseStart start,
                                 SensorTarget target) {
  // shared, because a std::function is copied freely
  return [player = std::make_shared<Player>(scene, std::move(start), target)](double t_s) {
    return player->At(t_s);
  };
}

}  // namespace haptometer::sim
