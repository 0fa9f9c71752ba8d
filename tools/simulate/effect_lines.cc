#include "tools/simulate/effect_lines.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>

#include "sim/effective_scene.h"
#include "sim/scene_run.h"

namespace haptometer::tools {
namespace {

constexpr int kTimedRuns = 3;

std::string_view NameOf(sim::Effect effect) { return sim::kEffectNames[sim::PlaceOf(effect)]; }

bool HasConstants(const sim::Scene& scene, sim::Effect effect) {
  switch (effect) {
    case sim::Effect::kInductance:
      return scene.actuator.inductance_h > 0;
    case sim::Effect::kGravity:
      return scene.effects[effect] != sim::Wish::kOff;
    case sim::Effect::kTravelStops:
      return scene.effects.travel_stops.has_value();
    case sim::Effect::kContactLoss:
      return scene.effects.contact_loss.has_value();
    case sim::Effect::kStiffening:
      return scene.effects.stiffening.has_value();
    case sim::Effect::kTremor:
      return !scene.finger.tones.empty();
    case sim::Effect::kCoilHeating:
      return scene.effects.coil_heating.has_value();
  }
  return false;
}

struct TimedRun {
  sim::PlayedScene played;
  double seconds = HUGE_VAL;
};

TimedRun BestRun(const sim::Scene& scene, sim::EffectSet on) {
  TimedRun timed;
  for (int k = 0; k < kTimedRuns; ++k) {
    const auto begin = std::chrono::steady_clock::now();
    timed.played = sim::PlayWith(scene, on);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    timed.seconds = std::min(timed.seconds, taken.count());
  }
  return timed;
}

std::string ChangeText(double change) {
  if (std::isinf(change)) return "unknown";
  return change == 0 ? "none" : fmt::format("{:.2g}", change);
}

}  // namespace

std::vector<EffectTrial> TryEffects(const sim::Scene& scene, const sim::EffectChoice& choice) {
  std::vector<EffectTrial> trials;
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    const auto effect = static_cast<sim::Effect>(k);
    if (!HasConstants(scene, effect)) continue;
    sim::EffectSet on = choice.on;
    // what the scene does not call for may be impossible in it
    if (!sim::CanRest(sim::WithEffects(scene, on.set(k)))) continue;
    if (!sim::CanRest(sim::WithEffects(scene, on.reset(k)))) continue;
    const TimedRun with = BestRun(scene, on.set(k));
    const TimedRun without = BestRun(scene, on.reset(k));
    const bool known = with.played.answered && without.played.answered;
    trials.push_back(
        {.effect = effect,
         .change =
             known ? sim::Deviation(scene.quantity, without.played.run, with.played.run) : HUGE_VAL,
         .with_s = with.seconds,
         .without_s = without.seconds});
  }
  return trials;
}

std::string VerdictText(const sim::EffectVerdict& verdict) {
  switch (verdict.ground) {
    case sim::Ground::kNotNamed:
      return "off: the scene does not call for it";
    case sim::Ground::kNamed:
      return "on: the scene calls for it";
    case sim::Ground::kNeverReached:
      return "off: never reached, proved between samples too; the same motion without it";
    case sim::Ground::kSuperposed:
      return "off: nothing limits or bends the motion, so weight moves its centre alone";
    case sim::Ground::kCompared:
      if (verdict.change == 0) return "off: without it the answer is the same";
      return fmt::format("{}: without it the answer changes by {}", verdict.on ? "on" : "off",
                         ChangeText(verdict.change));
  }
  return {};
}

std::vector<std::string> EffectLines(const sim::Scene& scene, const sim::EffectChoice& choice) {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    const bool told = scene.effects.wishes[k] != sim::Effects{}.wishes[k];
    if (!told) continue;
    lines.push_back(fmt::format("{} {}", sim::kEffectNames[k], VerdictText(choice.verdicts[k])));
  }
  return lines;
}

std::string ExplainText(const sim::Scene& scene, const sim::EffectChoice& choice,
                        const std::vector<EffectTrial>& trials) {
  std::string text = fmt::format(
      "  effects, by what they do to {} (tolerance {:g}; runs to decide: {}):\n"
      "  {:<13} {:>9} {:>12} {:>12}  {}\n",
      sim::kAskedQuantityNames[static_cast<std::size_t>(scene.quantity)], scene.tolerance,
      choice.runs, "effect", "change", "with", "without", "decision");
  for (std::size_t k = 0; k < sim::kEffectNames.size(); ++k) {
    const auto trial = std::ranges::find(trials, static_cast<sim::Effect>(k), &EffectTrial::effect);
    const bool tried = trial != trials.end();
    fmt::format_to(std::back_inserter(text), "  {:<13} {:>9} {:>9} us {:>9} us  {}\n",
                   NameOf(static_cast<sim::Effect>(k)), tried ? ChangeText(trial->change) : "-",
                   tried ? fmt::format("{:.0f}", trial->with_s * 1e6) : "-",
                   tried ? fmt::format("{:.0f}", trial->without_s * 1e6) : "-",
                   VerdictText(choice.verdicts[k]));
  }
  return text;
}

}  // namespace haptometer::tools
