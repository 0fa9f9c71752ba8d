#include "tools/sweep/answer_columns.h"

#include <array>

namespace haptometer::tools {
namespace {

using Answer = SceneAnswer;
using Number = std::optional<double>;

constexpr auto kColumns = std::to_array<AnswerColumn>({
    {"skin_rms_m", [](const Answer& a) { return Number(a.steady.skin_rms_m); }},
    {"mover_peak_m", [](const Answer& a) { return Number(a.steady.mover_peak_m); }},
    {"case_rms_m", [](const Answer& a) { return Number(a.steady.case_rms_m); }},
    {"current_rms_a", [](const Answer& a) { return Number(a.steady.current_rms_a); }},
    {"power_w", [](const Answer& a) { return Number(a.steady.power_w); }},
    {"phase_rad", [](const Answer& a) { return Number(a.steady.phase_rad); }},
    {"skin_force_peak_n", [](const Answer& a) { return Number(a.steady.skin_force_peak_n); }},
    {"window_rms_m",
     [](const Answer& a) { return a.window ? Number(a.window->skin_rms_m) : std::nullopt; }},
    {"error_estimate", [](const Answer& a) { return Number(a.steady.error_estimate); }},
});

}  // namespace

std::span<const AnswerColumn> AnswerColumns() { return kColumns; }

std::string_view AnswerRemark(const SceneAnswer& answer) {
  const bool is_short = answer.scene.duration_s && !answer.window;
  return is_short ? "the run is shorter than ten periods: no window_rms_m" : "";
}

}  // namespace haptometer::tools
