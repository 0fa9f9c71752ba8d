#include "tools/sweep/answer_columns.h"

#include <array>

namespace haptometer::tools {
namespace {

using Number = std::optional<double>;

// of the steady motion, where that is known
template <double sim::SteadyState::* kMember>
Number Steady(const SceneAnswer& answer) {
  return answer.steady ? Number((*answer.steady).*kMember) : std::nullopt;
}

// the same, also of tones
template <double sim::SteadyState::* kMember, double sim::SteadyTones::* kOfTones>
Number SteadyOrTones(const SceneAnswer& answer) {
  return answer.tones ? Number((*answer.tones).*kOfTones) : Steady<kMember>(answer);
}

// the same, or of the motion that a limited scene settles to
template <double sim::SteadyState::* kMember, double sim::SteadyTones::* kOfTones,
          double sim::SceneRun::* kSettled>
Number Settled(const SceneAnswer& answer) {
  const sim::SceneRun* settled = SettledRun(answer);
  return settled != nullptr ? Number(settled->*kSettled) : SteadyOrTones<kMember, kOfTones>(answer);
}

// of the run of a scene with effects, or under a drive that is no sine
template <double sim::SceneRun::* kMember>
Number OfRun(const SceneAnswer& answer) {
  const sim::SceneRun* run = RunOf(answer);
  return run != nullptr ? Number(run->*kMember) : std::nullopt;
}

Number EventsOf(const SceneAnswer& answer) {
  const sim::SceneRun* run = RunOf(answer);
  if (run == nullptr) return std::nullopt;
  std::size_t events = 0;
  for (const sim::EventCount& event : run->events) events += event.count;
  return static_cast<double>(events);
}

constexpr auto kColumns = std::to_array<AnswerColumn>({
    {"skin_rms_m", Settled<&sim::SteadyState::skin_rms_m, &sim::SteadyTones::skin_rms_m,
                           &sim::SceneRun::skin_rms_m>},
    {"mover_peak_m", Settled<&sim::SteadyState::mover_peak_m, &sim::SteadyTones::mover_peak_m,
                             &sim::SceneRun::mover_peak_m>},
    {"case_rms_m", Settled<&sim::SteadyState::case_rms_m, &sim::SteadyTones::case_rms_m,
                           &sim::SceneRun::case_rms_m>},
    {"current_rms_a", Settled<&sim::SteadyState::current_rms_a, &sim::SteadyTones::current_rms_a,
                              &sim::SceneRun::current_rms_a>},
    {"power_w",
     Settled<&sim::SteadyState::power_w, &sim::SteadyTones::power_w, &sim::SceneRun::power_w>},
    {"phase_rad", Steady<&sim::SteadyState::phase_rad>},
    {"skin_force_peak_n",
     SteadyOrTones<&sim::SteadyState::skin_force_peak_n, &sim::SteadyTones::skin_force_peak_n>},
    {"window_rms_m",
     [](const SceneAnswer& a) { return a.window ? Number(a.window->skin_rms_m) : std::nullopt; }},
    {"error_estimate",
     SteadyOrTones<&sim::SteadyState::error_estimate, &sim::SteadyTones::error_estimate>},
    {"run_skin_rms_m", OfRun<&sim::SceneRun::skin_rms_m>},
    {"run_case_rms_m", OfRun<&sim::SceneRun::case_rms_m>},
    {"run_current_rms_a", OfRun<&sim::SceneRun::current_rms_a>},
    {"run_power_w", OfRun<&sim::SceneRun::power_w>},
    {"run_mover_peak_m", OfRun<&sim::SceneRun::mover_peak_m>},
    {"run_mover_peak_of_run_m", OfRun<&sim::SceneRun::mover_peak_of_run_m>},
    {"run_events", EventsOf},
    {"run_energy_imbalance",
     [](const SceneAnswer& a) {
       const sim::SceneRun* run = RunOf(a);
       return run != nullptr ? Number(run->ledger.Imbalance()) : std::nullopt;
     }},
});

}  // namespace

std::span<const AnswerColumn> AnswerColumns() { return kColumns; }

std::string AnswerRemark(const SceneAnswer& answer) {
  if (answer.tones) return "";
  if (answer.scene.drive.kind != sim::DriveKind::kSine)
    return "the drive is no sine: its numbers are those of run_";
  if (!answer.steady && SettledRun(answer) == nullptr)
    return "stops or lost contact limit the motion: its numbers are those of run_";
  const bool is_short = answer.scene.duration_s && !answer.window;
  return is_short ? "the run is shorter than ten periods: no window_rms_m" : "";
}

}  // namespace haptometer::tools
