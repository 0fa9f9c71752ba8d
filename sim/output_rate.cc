#include "sim/output_rate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/excitation.h"
#include "sim/linear_model.h"
#include "sim/poles.h"
#include "sim/scene_run.h"

namespace haptometer::sim {

namespace {

constexpr double kLeastRateHz = 1000;
constexpr double kOutputsPerRinging = 16;
constexpr double kHighestOwnHz = 1e5;
constexpr double kMostKeptSteps = 1e7;
constexpr double kRungDown = 1e-3;
// a pole that decays less than this part of the fastest one is rounding
constexpr double kNoDecay = 1e-13;

double HighestOwnHz(const Scene& scene) {
  double highest_hz = 0;
  for (const auto& pole : Poles(AssembleModel(scene))) {
    highest_hz = std::max(highest_hz, std::abs(pole.imag()) / (2 * std::numbers::pi));
  }
  for (const Tone& tone : scene.finger.tones) highest_hz = std::max(highest_hz, tone.frequency_hz);
  return std::min(highest_hz, kHighestOwnHz);
}

// of a drive that is held in equal pieces; 0 of others
double PiecesHz(const Drive& drive) {
  if (drive.kind == DriveKind::kSamples) return drive.samples->rate_hz;
  return drive.kind == DriveKind::kChirp ? CubicsOf(drive) / drive.duration_s : 0;
}

}  // namespace

double OutputRateHz(const Scene& scene) {
  const Drive& drive = scene.drive;
  if (drive.kind == DriveKind::kSine) {
    const double period_hz = kOutputsPerPeriod * drive.frequency_hz;
    if (!scene.duration_s) return period_hz;
    const double ringing_hz = kOutputsPerRinging * HighestOwnHz(scene);
    return period_hz * std::max(1.0, std::ceil(ringing_hz / period_hz));
  }
  const double highest_hz = std::max(HighestFrequencyHz(drive), HighestOwnHz(scene));
  const double rate_hz = std::max(kLeastRateHz, kOutputsPerPeriod * highest_hz);
  const double pieces_hz = PiecesHz(drive);
  return pieces_hz > 0 ? pieces_hz * std::ceil(rate_hz / pieces_hz * (1 - 1e-12)) : rate_hz;
}

double StepsOfRun(const Scene& scene, double duration_s) {
  return duration_s * OutputRateHz(scene);
}

double MostSteps(const Scene& scene) {
  return scene.drive.kind == DriveKind::kSine ? kMostOutputs : kMostKeptSteps;
}

std::optional<double> RingDownS(const Scene& scene) {
  const std::vector<std::complex<double>> poles = Poles(AssembleModel(scene));
  double slowest_per_s = HUGE_VAL;
  for (const auto& pole : poles) slowest_per_s = std::min(slowest_per_s, -pole.real());
  if (!(slowest_per_s > kNoDecay * std::abs(poles.back()))) return std::nullopt;
  return -std::log(kRungDown) / slowest_per_s;
}

}  // namespace haptometer::sim
