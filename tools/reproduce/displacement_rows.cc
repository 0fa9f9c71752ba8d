// Table 2.3: steady displacement under three contact conditions.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "sim/linear_model.h"
#include "sim/steady_state.h"
#include "sim/time_response.h"
#include "tools/reproduce/row_groups.h"

namespace haptometer::tools {
namespace {

constexpr std::array kKeys{"rms-direct", "rms-cone", "rms-adapter"};
constexpr double kShortRunS = 0.1;
constexpr double kWindowPeriods = 10;

using Three = std::array<double, kKeys.size()>;

// What a drive that is interpolated linearly between samples `step_s` apart has left of its tone:
// the spectrum of the triangle, sinc^2. Its images lie kilohertz away, where nothing moves.
double Interpolated(double frequency_hz, double step_s) {
  const double angle = std::numbers::pi * frequency_hz * step_s;
  const double sinc = angle == 0 ? 1 : std::sin(angle) / angle;
  return sinc * sinc;
}

// the step that leaves `part` of the tone; nothing where none does
std::optional<double> StepThatLeaves(double frequency_hz, double part) {
  if (!(part > 0 && part < 1)) return std::nullopt;
  double low = 0;
  double high = 1 / frequency_hz;  // leaves nothing
  for (int halvings = 0; halvings < 60; ++halvings) {
    const double middle = (low + high) / 2;
    (Interpolated(frequency_hz, middle) > part ? low : high) = middle;
  }
  return low;
}

// the one step that brings all three nearest to what is printed
std::optional<double> CommonStep(double frequency_hz, const Three& exact_m) {
  Three parts{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts[i] = SiValue(ThesisNumberOf(kKeys[i])) / exact_m[i];
  }
  const auto [least, most] = std::ranges::minmax(parts);
  return StepThatLeaves(frequency_hz, (least + most) / 2);
}

// the last ten periods of a tenth of a second from rest
CandidateCause ShortRun(const sim::Scene& scene) {
  const sim::LinearModel linear = sim::AssembleModel(scene);
  const sim::TimeResponse response(linear, scene.drive, sim::Start::kRest);
  const double begin_s = kShortRunS - kWindowPeriods / scene.drive.frequency_hz;
  return {.text = "the last 10 periods of a run of 0.1 s from rest, which has not settled",
          .gives = response.WindowRms(linear.skin(), begin_s, kShortRunS)};
}

ThesisRow RatioRow(const Three& exact_m) {
  const double direct = SiValue(ThesisNumberOf(kKeys[0]));
  const double adapter = SiValue(ThesisNumberOf(kKeys[2]));
  return {.key = "ratio-adapter-direct",
          .ours = exact_m[2] / exact_m[0],
          .remark = fmt::format("the printed pair of Table 2.3 gives {:.3f}", adapter / direct)};
}

std::string RangeRemark(const ThesisModel& model) {
  ThesisModel other = model;
  other.skin_range = sim::SkinRange::kTable;
  return fmt::format("with Ks up to 2000 N/m (text); up to 1200 N/m (Table 2.1) {:.5f} mm",
                     1e3 * sim::SolveSteadyState(WithoutAdapter(other, kCaseAreaM2)).skin_rms_m);
}

}  // namespace

std::vector<ThesisRow> DisplacementRows(const ThesisModel& model) {
  const std::array scenes{WithoutAdapter(model, kCaseAreaM2),
                          WithoutAdapter(model, kSimulatedConeAreaM2),
                          WithAdapter(model, kIa2AreaM2)};
  Three exact_m{};
  std::ranges::transform(scenes, exact_m.begin(), [](const sim::Scene& scene) {
    return sim::SolveSteadyState(scene).skin_rms_m;
  });
  const auto step_s = CommonStep(model.drive.frequency_hz, exact_m);

  std::vector<ThesisRow> rows;
  rows.reserve(scenes.size() + 1);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    ThesisRow row{.key = kKeys[i], .ours = exact_m[i]};
    row.candidates.push_back(ShortRun(scenes[i]));
    if (step_s) {
      row.candidates.push_back(
          {.text = fmt::format("the input interpolated linearly between samples {:.2f} ms apart, "
                               "the one step that brings all three nearest",
                               1e3 * *step_s),
           .gives = exact_m[i] * Interpolated(model.drive.frequency_hz, *step_s)});
    }
    rows.push_back(std::move(row));
  }
  rows.front().remark = RangeRemark(model);
  rows.push_back(RatioRow(exact_m));
  return rows;
}

}  // namespace haptometer::tools
