#include "sim/steady_tones.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <map>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/error.h"
#include "sim/driven_step.h"
#include "sim/hermite.h"
#include "sim/scene_run.h"
#include "sim/steady_state.h"

namespace haptometer::sim {

namespace {

using Complex = std::complex<double>;

constexpr double kMostPlayed = 1 << 20;
constexpr double kParts = 1e6;  // of a hertz that frequencies are written in

// one frequency's share of a sum of sines
struct Part {
  double frequency_hz = 0;
  Complex amplitude;  // Im(amplitude exp(j w t))
};

double SumOf(const std::vector<Part>& parts, double mean) {
  double sum = std::abs(mean);
  for (const Part& part : parts) sum += std::abs(part.amplitude);
  return sum;
}

MotionJet JetAt(const std::vector<Part>& parts, double mean, long double t_s) {
  MotionJet jet{.x = mean};
  for (const Part& part : parts) {
    const double w = 2 * std::numbers::pi * part.frequency_hz;
    const Eigen::Vector2d turn = DriveAt(part.frequency_hz, t_s);
    const Complex now = part.amplitude * Complex(turn[1], turn[0]);
    jet.x += now.imag();
    jet.v += w * now.real();
    jet.a -= w * w * now.imag();
  }
  return jet;
}

// the largest value over one period, around a constant part
double PeakOf(const std::vector<Part>& parts, double mean, double period_s, double highest_hz) {
  if (period_s == 0) return SumOf(parts, mean);
  const auto count =
      static_cast<std::int64_t>(std::ceil(kOutputsPerPeriod * highest_hz * period_s));
  const long double step_s = static_cast<long double>(period_s) / static_cast<long double>(count);
  double peak = 0;
  MotionJet before = JetAt(parts, mean, 0);
  for (std::int64_t k = 1; k <= count; ++k) {
    const MotionJet now = JetAt(parts, mean, step_s * static_cast<long double>(k));
    peak = std::max(peak, HermiteQuintic(before, now, static_cast<double>(step_s)).Peak());
    before = now;
  }
  return peak;
}

// of all frequencies, which are the keys; 0 where it is too long to play
double CommonPeriod(const std::map<double, Complex>& voltages) {
  std::int64_t common = 0;
  for (const auto& [frequency_hz, voltage] : voltages) {
    const double parts = std::round(frequency_hz * kParts);
    if (parts < 1 || parts > 1e15 || parts / kParts != frequency_hz) return 0;
    common = std::gcd(common, static_cast<std::int64_t>(parts));
  }
  const double period_s = kParts / static_cast<double>(common);
  const double outputs = kOutputsPerPeriod * voltages.rbegin()->first * period_s;
  return outputs <= kMostPlayed ? period_s : 0;
}

// Adds up the tones.
class SumOfTones {
 public:
  SumOfTones(const Scene& scene, double period_s)
      : scene_(scene), model_(AssembleModel(scene)), period_s_(period_s) {
    steady_.start = StaticState(model_, scene.drive.offset_v);
    steady_.period_s = period_s;
    AddMean();
  }

  void Add(double frequency_hz, Complex voltage_v) {
    const SineDrive unit{.amplitude_v = 1, .frequency_hz = frequency_hz};
    const SteadyState one = SolveSteadyState(model_, unit, scene_.skin);
    const double w = 2 * std::numbers::pi * frequency_hz;
    const Complex skin = one.phasors(model_.skin()) * voltage_v;
    const Skin& tissue = scene_.skin;
    steady_.start += (one.phasors * voltage_v).imag();
    skin_square_ += std::norm(skin) / 2;
    case_square_ += std::norm(one.phasors(LinearModel::kCase) * voltage_v) / 2;
    current_square_ += std::norm(one.current_a * voltage_v) / 2;
    steady_.power_w += std::norm(voltage_v) * one.power_w;
    steady_.skin_power_w += tissue.damping_n_s_per_m * w * w * std::norm(skin) / 2;
    travel_.push_back(
        {frequency_hz,
         (one.phasors(LinearModel::kMover) - one.phasors(LinearModel::kCase)) * voltage_v});
    force_.push_back(
        {frequency_hz, Complex(tissue.stiffness_n_per_m, w * tissue.damping_n_s_per_m) * skin});
    steady_.error_estimate = std::max(steady_.error_estimate, one.error_estimate);
    highest_hz_ = std::max(highest_hz_, frequency_hz);
  }

  SteadyTones Take() {
    steady_.skin_rms_m = std::sqrt(skin_square_);
    steady_.case_rms_m = std::sqrt(case_square_);
    steady_.current_rms_a = std::sqrt(current_square_);
    if (!(steady_.error_estimate < 1)) return steady_;
    steady_.mover_peak_m = PeakOf(travel_, mean_travel_m_, period_s_, highest_hz_);
    steady_.skin_force_peak_n = PeakOf(force_, steady_.mean_skin_force_n, period_s_, highest_hz_);
    return steady_;
  }

 private:
  // what the offset holds
  void AddMean() {
    const double offset_v = scene_.drive.offset_v;
    if (offset_v == 0) return;
    if (!IsHeldInPlace(scene_)) steady_.error_estimate = HUGE_VAL;
    const Eigen::VectorXd& mean = steady_.start;
    const double current_a = model_.current_row.dot(mean) + model_.current_per_volt * offset_v;
    skin_square_ = mean(model_.skin()) * mean(model_.skin());
    case_square_ = mean(LinearModel::kCase) * mean(LinearModel::kCase);
    current_square_ = current_a * current_a;
    steady_.power_w = offset_v * current_a;
    mean_travel_m_ = mean(LinearModel::kMover) - mean(LinearModel::kCase);
    steady_.mean_skin_force_n = scene_.skin.stiffness_n_per_m * mean(model_.skin());
  }

  const Scene& scene_;
  LinearModel model_;
  double period_s_;
  double mean_travel_m_ = 0;
  double highest_hz_ = 0;
  SteadyTones steady_;
  double skin_square_ = 0, case_square_ = 0, current_square_ = 0;
  std::vector<Part> travel_, force_;
};

}  // namespace

SteadyTones SolveSteadyTones(const Scene& scene) {
  HAPTOMETER_CHECK(scene.drive.kind == DriveKind::kTones && !scene.drive.tones.empty(),
                   "a drive of kind {}", Name(scene.drive.kind));
  std::map<double, Complex> voltages;
  for (const Tone& tone : scene.drive.tones) {
    voltages[tone.frequency_hz] += std::polar(tone.amplitude, tone.phase_rad);
  }
  SumOfTones sum(scene, CommonPeriod(voltages));
  for (const auto& [frequency_hz, voltage_v] : voltages) {
    if (voltage_v != 0.0) sum.Add(frequency_hz, voltage_v);
  }
  return sum.Take();
}

}  // namespace haptometer::sim
