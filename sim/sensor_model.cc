#include "sim/sensor_model.h"

#include <fmt/core.h>

#include <cmath>
#include <complex>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>

#include "base/circular_functions.h"
#include "base/error.h"
#include "sim/effective_scene.h"
#include "sim/linear/excitation.h"
#include "sim/linear/linear_model.h"
#include "sim/linear/steady_state.h"
#include "sim/linear/time_response.h"
#include "sim/piecewise/piecewise_motion.h"
#include "sim/smooth/semilinear_solver.h"
#include "sim/smooth/smooth_motion.h"
#include "sim/smooth/smooth_system.h"
#include "sim/waveforms.h"

namespace haptometer::sim {

/// The displacement of `target` under a scene's effects at any requested time: exact, or
/// by SmoothMotion with the first tolerance of SolverLadder where smooth effects are on.
///
/// The motion is played in the outputs of sim/effective_scene.h and interpolated by quintics: 2e-11
/// of its amplitude where it is smooth, h^2/8 times the jump of acceleration within an output step
/// that holds an event. Before t = 0 it has its first value. Times should be requested in ascending
/// order, within 4096 outputs; an earlier one plays the motion again from t = 0. NaN after a stall.
/// Threads may share it: they wait for each other.
///
/// `start` is the state at t = 0, `temperature_rise_k` the coil's.
[[nodiscard]] trial::Displacement PlayedMotion(const EffectiveScene& scene, PiecewiseStart start,
                                               SensorTarget target, double temperature_rise_k = 0);

trial::Displacement MotionOf(const Scene& stated, SensorTarget target) {
  EffectSet on;
  // "auto" counts as on: the sensor measures the motion with all effects
  for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
    on[k] = stated.effects.wishes[k] != Wish::kOff;
  }
  const EffectiveScene effective = WithEffects(stated, on);
  // a closed form exists for a linear scene without limits under a sine alone
  const bool is_sine = effective.scene.drive.kind == DriveKind::kSine;
  const bool limited = effective.piecewise.stops || effective.piecewise.contact_loss;
  const bool is_plain = effective.scene.drive.offset_v == 0 && !effective.scene.initial.Any();
  if (!is_sine || !is_plain || limited || !effective.IsLinear() ||
      !effective.scene.finger.tones.empty()) {
    Beginning beginning = BeginningOf(effective);
    return PlayedMotion(effective, std::move(beginning.start), target,
                        beginning.temperature_rise_k);
  }
  const Scene& scene = effective.scene;
  const LinearModel model = AssembleModel(scene);
  const Eigen::Index state = StateOf(model, target);
  // steady: Im(X exp(j w t)) as one sine
  if (StartOf(scene) == Start::kSteady) {
    const std::complex<double> phasor =
        SolveSteadyState(model, scene.drive, scene.skin).phasors(state);
    return [amplitude_m = Abs(phasor), phase_rad = Arg(phasor),
            frequency_hz = scene.drive.frequency_hz](double t_s) {
      // whole cycles are subtracted in 64 bits, so that the phase keeps its digits at large times
      const long double cycles =
          static_cast<long double>(frequency_hz) * static_cast<long double>(t_s);
      const auto part = static_cast<double>(cycles - std::nearbyint(cycles));
      return amplitude_m * Sin(2 * std::numbers::pi * part + phase_rad);
    };
  }
  // shared, because a std::function is copied freely
  auto response = std::make_shared<const TimeResponse>(model, scene.drive, Start::kRest);
  return [response = std::move(response), state](double t_s) {
    return t_s <= 0 ? 0.0 : response->StateAt(t_s)(state);
  };
}

trial::Displacement SensedMotion(const Scene& scene) {
  HAPTOMETER_CHECK(scene.sensor.has_value(), "the scene has no sensor");
  trial::Displacement motion = MotionOf(scene, scene.sensor->target);
  const double latency_s = scene.sensor->latency_s;
  if (latency_s == 0) return motion;
  return [motion = std::move(motion), latency_s](double t_s) { return motion(t_s - latency_s); };
}

namespace {

trial::Metadata Describe(const Scene& scene) {
  const Sensor& sensor = *scene.sensor;
  trial::Metadata metadata;
  const Effects& effects = scene.effects;
  const bool smooth =
      effects[Effect::kStiffening] != Wish::kOff || effects[Effect::kCoilHeating] != Wish::kOff;
  metadata.source = fmt::format("simulated: {}, {}, start from {}",
                                effects.Asked() ? "scene with effects" : "linear scene",
                                smooth ? "exponential collocation" : "exact solution",
                                StartOf(scene) == Start::kRest ? "rest" : "steady state");
  metadata.sensor = "sensor model";
  metadata.head = sensor.head.name;
  metadata.sampling_s = sensor.head.sampling_s;
  metadata.averages = sensor.head.averages;
  metadata.hold = "sample";
  metadata.nominal_rate_hz = sensor.rate_hz;
  metadata.laser_spot = Name(sensor.target);
  if (scene.drive.kind == DriveKind::kSine || scene.drive.kind == DriveKind::kBurst) {
    metadata.drive_frequency_hz = scene.drive.frequency_hz;
  }
  metadata.drive_amplitude_v = LargestVoltageV(scene.drive);
  return metadata;
}

}  // namespace

std::int64_t SamplesPerReading(const Sensor& sensor) {
  return std::llround(1 / (sensor.rate_hz * sensor.head.sampling_s));
}

trial::Record SimulateRecord(const Scene& scene, double duration_s) {
  HAPTOMETER_CHECK(scene.sensor.has_value(), "the scene has no sensor");
  const Sensor& sensor = *scene.sensor;
  // the allowance keeps the last reading of a duration of whole readings in spite of rounding
  const auto rows = static_cast<std::size_t>(std::floor(duration_s * sensor.rate_hz * (1 + 1e-12)));
  HAPTOMETER_CHECK(rows >= 1, "{} s at {} Hz", duration_s, sensor.rate_hz);
  const std::int64_t stride = SamplesPerReading(sensor);

  trial::Channel channel;
  channel.name = "displacement";
  channel.role = trial::ChannelRole::kDisplacement;
  channel.unit = "m";
  channel.range_min = sensor.head.range_min_m;
  channel.range_max = sensor.head.range_max_m;
  channel.resolution = sensor.head.resolution_m;
  const trial::Displacement motion = SensedMotion(scene);
  for (std::size_t row = 0; row < rows; ++row) {
    const trial::HeadReading reading =
        trial::ReadingAt(sensor.head, motion, static_cast<std::int64_t>(row) * stride, sensor.seed);
    // a status without a value, as out of range, is NaN in the record
    const bool measured = trial::IsMeasurement(reading.status);
    channel.values.push_back(measured ? reading.value_m : std::numeric_limits<double>::quiet_NaN());
    channel.statuses.push_back(reading.status);
  }

  trial::Record record;
  record.rows = rows;
  record.channels.push_back(std::move(channel));
  record.stretches.push_back(
      {.first_row = 0, .rows = rows, .start_s = 0, .rate_hz = sensor.rate_hz});
  record.metadata = Describe(scene);
  return record;
}

namespace {

constexpr std::size_t kKeptOutputs = 4096;

// plays the motion up to the requested time and keeps the last kKeptOutputs outputs
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
    // earlier than the outputs kept: again from t = 0
    if (before < first_) Begin();
    // the time lies between outputs `before` and `before + 1`
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
        SmoothSettings settings = SolverLadder(scene.scene.tolerance).settings();
        settings.most_steps = std::numeric_limits<std::int64_t>::max();
        return std::make_unique<SmoothMotion>(
            AssembleSmooth(scene.scene, scene.piecewise, scene.smooth), ExcitationOf(scene.scene),
            start, OutputGrid{.rate_hz = rate_hz}, settings, temperature_rise_k);
      });
}

}  // namespace haptometer::sim
