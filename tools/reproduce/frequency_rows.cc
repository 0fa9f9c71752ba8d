// Resonance, impedances (Figure 2.4) and sensitivity (Figure 2.5).
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>

#include "sim/linear/linear_model.h"
#include "sim/linear/motor_source.h"
#include "sim/linear/steady_state.h"
#include "tools/reproduce/row_groups.h"
#include "tools/reproduce/scan.h"

namespace haptometer::tools {
namespace {

// about the drive; the system's other resonances lie outside of what was drawn
constexpr double kLowestPart = 0.5;
constexpr double kHighestPart = 1.5;

double SkinRmsAt(sim::Scene scene, double frequency_hz) {
  scene.drive.frequency_hz = frequency_hz;
  return sim::SolveSteadyState(scene).skin_rms_m;
}

std::string PolesRemark(const sim::Scene& scene) {
  std::string text = "poles of the assembled system at";
  for (const std::complex<double>& pole : sim::Poles(sim::AssembleModel(scene))) {
    if (pole.imag() <= 0) continue;  // one of a pair
    text += fmt::format(" {:.2f}", std::abs(pole) / (2 * std::numbers::pi));
  }
  return text + " Hz";
}

// sqrt(Ka/Ma2)/2 pi of the printed numbers, Ma2 to its last digit
CandidateCause AdapterAlone() {
  const ThesisNumber& mass = ThesisNumberOf("grid-skin-side-mass");
  const double stiffness = SiValue(ThesisNumberOf("grid-stiffness"));
  const auto alone = [&](double steps) {
    const double mass_kg = SiValue(mass) + steps * mass.half_step * mass.unit.si;
    return std::sqrt(stiffness / mass_kg) / (2 * std::numbers::pi);
  };
  return {.text = "sqrt(Ka/Ma2)/2 pi, the adapter alone on a held motor without skin",
          .gives = alone(0),
          .from_rounded = dsp::Interval{alone(1), alone(-1)}};
}

ThesisRow ResonanceRow(const sim::Scene& scene) {
  const double drive_hz = scene.drive.frequency_hz;
  const double peak_hz = LargestAt([&](double f) { return SkinRmsAt(scene, f); },
                                   kLowestPart * drive_hz, kHighestPart * drive_hz);
  return {.key = "resonant-frequency",
          .ours = peak_hz,
          .candidates = {AdapterAlone()},
          .remark = PolesRemark(scene)};
}

std::vector<ThesisRow> ImpedanceRows(const sim::Scene& scene) {
  const double drive_hz = scene.drive.frequency_hz;
  const double low_hz = kLowestPart * drive_hz;
  const double high_hz = kHighestPart * drive_hz;
  const auto driver = [&](double f) { return std::abs(sim::DriverImpedance(scene, f)); };
  const auto ratio = [&](double f) {
    return driver(f) / std::abs(sim::SkinImpedance(scene.skin, f));
  };
  const double dip_hz = LargestAt([&](double f) { return -driver(f); }, low_hz, high_hz);
  const auto excess = [&](double f) { return ratio(f) - 1; };
  const auto below_hz = CrossingOf(excess, low_hz, dip_hz);
  const auto above_hz = CrossingOf(excess, dip_hz, high_hz);
  ThesisRow match{.key = "impedance-match", .ours = below_hz};
  if (above_hz) match.remark = fmt::format("and again at {:.2f} Hz", *above_hz);
  const std::complex<double> z = sim::DriverImpedance(scene, drive_hz);
  return {match,
          {.key = "impedance-dip", .ours = dip_hz},
          {.key = "impedance-ratio",
           .ours = ratio(drive_hz),
           .remark = fmt::format("{:.3f}{:+.3f}j N s/m: nearly the conjugate of the skin's, which "
                                 "is what takes most power",
                                 z.real(), z.imag())}};
}

std::vector<ThesisRow> SensitivityRows(const sim::Scene& scene) {
  static constexpr std::array kKeys{"sensitivity-Ma1", "sensitivity-Ma2", "sensitivity-Ka",
                                    "sensitivity-Ba",  "sensitivity-Ks",  "sensitivity-Bs"};
  std::vector<ThesisRow> rows;
  rows.reserve(kKeys.size());
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    double most = 0;
    for (int percent = -50; percent <= 50; ++percent) {
      const double factor = 1 + percent / 100.0;
      most =
          std::max(most, std::abs(sim::RelativeSkinRms(scene, sim::kSceneNumbers[i], factor) - 1));
    }
    const auto at = [&](double factor) {
      return 100 * (sim::RelativeSkinRms(scene, sim::kSceneNumbers[i], factor) - 1);
    };
    rows.push_back(
        {.key = kKeys[i],
         .ours = most,
         .remark = fmt::format("{:+.2f} % at -50 %, {:+.2f} % at +50 %", at(0.5), at(1.5))});
  }
  return rows;
}

}  // namespace

std::vector<ThesisRow> FrequencyRows(const ThesisModel& model) {
  const sim::Scene scene = WithAdapter(model, kIa2AreaM2);
  std::vector<ThesisRow> rows{ResonanceRow(scene)};
  for (const auto& more : {ImpedanceRows(scene), SensitivityRows(scene)}) {
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace haptometer::tools
