#include "tools/reproduce/generated_sweep.h"

#include <fmt/core.h>

#include <array>
#include <cmath>

#include "dsp/analysis/band_analysis.h"
#include "sim/sensor_model.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {
namespace {

constexpr double kDurationS = 1;
constexpr std::array kLevelsV{0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0};
constexpr std::array kSkinFactors{0.8, 1.2};

Result<double> RmsWithFloor(const sim::Scene& scene) {
  dsp::BandQuestion question;
  question.keep_filtered = false;
  const auto analysis = dsp::AnalyzeBand(sim::SimulateRecord(scene, kDurationS), question);
  if (!analysis) return std::unexpected(analysis.error());
  if (!analysis->answered || !analysis->numbers) {
    return CannotAnswer(fmt::format("{:g} V", scene.drive.amplitude_v),
                        analysis->reasons.empty() ? "has no RMS" : analysis->reasons.front());
  }
  const dsp::RmsEstimate& rms = analysis->numbers->rms;
  return rms.below_floor ? rms.as_measured_m : std::hypot(rms.rms_m, rms.floor_m.value_or(0));
}

}  // namespace

Result<std::vector<DriveReading>> GenerateSweep(const ThesisModel& model) {
  std::vector<DriveReading> readings;
  readings.reserve(kSkinFactors.size() * kLevelsV.size());
  std::uint64_t seed = 0;
  for (const double factor : kSkinFactors) {
    sim::Scene scene = Prototype(model, kIa1AreaM2);
    scene.skin.stiffness_n_per_m *= factor;
    scene.skin.damping_n_s_per_m *= factor;
    scene.sensor = sim::Sensor{.head = trial::Stream10kHz(), .rate_hz = 1e4};
    for (const double level_v : kLevelsV) {
      scene.drive.amplitude_v = level_v;
      scene.sensor->seed = ++seed;
      const auto rms_m = RmsWithFloor(scene);
      if (!rms_m) return std::unexpected(rms_m.error());
      readings.push_back({.subject = factor < 1 ? "soft" : "stiff",
                          .condition = "ia1",
                          .drive_v = level_v,
                          .rms_m = *rms_m});
    }
  }
  return readings;
}

}  // namespace haptometer::tools
