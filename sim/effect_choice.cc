#include "sim/effect_choice.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/effective_scene.h"
#include "sim/steady_run.h"

namespace haptometer::sim {

namespace {

double Relative(double value, double reference) {
  if (value == reference) return 0;
  return std::abs(value - reference) / std::abs(reference);
}

// stops and contact are told apart by the names of their events
bool Happened(const SceneRun& run, std::initializer_list<std::string_view> names) {
  return std::ranges::any_of(run.events, [&](const EventCount& event) {
    return std::ranges::find(names, event.name) != names.end();
  });
}

bool Reached(Effect effect, const SceneRun& run) {
  if (effect == Effect::kContactLoss) return Happened(run, {"take-off"});
  return Happened(run, {"impact up", "impact down", "stop up", "stop down"});
}

// Decides for one scene.
class Decision {
 public:
  explicit Decision(const Scene& scene) : scene_(scene) {
    for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
      all_[k] = scene.effects.wishes[k] != Wish::kOff;
      choice_.verdicts[k] = {.on = all_[k], .ground = all_[k] ? Ground::kNamed : Ground::kNotNamed};
    }
  }

  Result<EffectChoice> Decide(const std::string& where) {
    choice_.on = all_;
    PlayedScene everything = Play(all_);
    if (!everything.answered) {
      return CannotAnswer(where, everything.problem,
                          "give a duration, or leave out effects that are on");
    }
    everything_ = everything.run;
    Take(std::move(everything));
    LeaveOutWhatIsNeverReached();
    LeaveOutGravity();
    LeaveOutByComparison();
    choice_.change = Deviation(scene_.quantity, choice_.run, everything_);
    choice_.runs = runs_;
    return std::move(choice_);
  }

 private:
  PlayedScene Play(EffectSet on) {
    ++runs_;
    return PlayWith(scene_, on);
  }
  void Take(PlayedScene played) {
    choice_.run = std::move(played.run);
    choice_.periodic = std::move(played.periodic);
  }
  bool Asked(Effect effect) const { return scene_.effects[effect] == Wish::kAuto; }
  EffectVerdict& VerdictOf(Effect effect) { return choice_.verdicts[PlaceOf(effect)]; }

  void LeaveOut(Effect effect, Ground ground) {
    choice_.on.reset(PlaceOf(effect));
    VerdictOf(effect).on = false;
    VerdictOf(effect).ground = ground;
  }

  void LeaveOutWhatIsNeverReached() {
    for (const Effect effect : {Effect::kTravelStops, Effect::kContactLoss}) {
      if (!Asked(effect)) continue;
      if (Reached(effect, everything_)) {
        VerdictOf(effect).ground = Ground::kCompared;
      } else {
        LeaveOut(effect, Ground::kNeverReached);
      }
    }
  }

  // without gravity a stop that stays in the scene might be reached
  void LeaveOutGravity() {
    if (!Asked(Effect::kGravity)) return;
    const bool limited =
        choice_.on[PlaceOf(Effect::kTravelStops)] || choice_.on[PlaceOf(Effect::kContactLoss)];
    if (!limited) LeaveOut(Effect::kGravity, Ground::kSuperposed);
  }

  void LeaveOutByComparison() {
    std::vector<Effect> open;
    for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
      const auto effect = static_cast<Effect>(k);
      if (Asked(effect) && choice_.on[k]) open.push_back(effect);
    }
    for (const Effect effect : open) {
      EffectVerdict& verdict = VerdictOf(effect);
      verdict.ground = Ground::kCompared;
      EffectSet without = choice_.on;
      verdict.change = DeviationOf(Play(without.reset(PlaceOf(effect))));
    }
    std::ranges::sort(open, {}, [&](Effect effect) { return VerdictOf(effect).change; });
    for (const Effect effect : open) TryWithout(effect);
  }

  void TryWithout(Effect effect) {
    if (!(VerdictOf(effect).change <= scene_.tolerance)) return;
    EffectSet without = choice_.on;
    PlayedScene played = Play(without.reset(PlaceOf(effect)));
    if (!(DeviationOf(played) <= scene_.tolerance)) return;
    LeaveOut(effect, Ground::kCompared);
    Take(std::move(played));
  }

  // what is not known deviates from everything
  double DeviationOf(const PlayedScene& played) const {
    return played.answered ? Deviation(scene_.quantity, played.run, everything_) : HUGE_VAL;
  }

  const Scene& scene_;
  EffectSet all_;
  SceneRun everything_;
  EffectChoice choice_;
  std::size_t runs_ = 0;
};

}  // namespace

double Deviation(AskedQuantity quantity, const SceneRun& run, const SceneRun& reference) {
  switch (quantity) {
    case AskedQuantity::kSkinRms:
      return Relative(run.skin_rms_m, reference.skin_rms_m);
    case AskedQuantity::kMoverPeak:
      return Relative(run.mover_peak_m, reference.mover_peak_m);
    case AskedQuantity::kCurrentRms:
      return Relative(run.current_rms_a, reference.current_rms_a);
    case AskedQuantity::kSkinWaveform:
      break;
  }
  const double peak_m = reference.skin_m.cwiseAbs().maxCoeff();
  const double apart_m = (run.skin_m - reference.skin_m).cwiseAbs().maxCoeff();
  return apart_m == 0 ? 0 : apart_m / peak_m;
}

PlayedScene PlayWith(const Scene& scene, EffectSet on) {
  const EffectiveScene effective = WithEffects(scene, on);
  PlayedScene played;
  PiecewiseStart start = {};
  if (!scene.duration_s || StartOf(scene) == Start::kSteady) {
    SteadyRun steady = PlaySteady(effective);
    played.problem = std::move(steady.tried);
    played.answered = steady.run.has_value();
    if (steady.run) played.run = std::move(*steady.run);
    played.periodic = std::move(steady.periodic);
    if (!scene.duration_s || !played.answered) return played;
    played.periodic.reset();
    start = std::move(steady.start);
  } else {
    start = PiecewiseStartOf(effective.scene);
  }
  played.run = RunScene(effective, *scene.duration_s, std::move(start));
  played.answered = !played.run.stalled_at_s;
  if (!played.answered) {
    played.problem = fmt::format("events without end at {:.9g} s", *played.run.stalled_at_s);
  }
  return played;
}

Result<EffectChoice> ChooseEffects(const Scene& scene, const std::string& where) {
  return Decision(scene).Decide(where);
}

}  // namespace haptometer::sim
