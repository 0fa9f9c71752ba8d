#include "sim/effect_choice.h"

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

// stops and contact are distinguished by the names of their events
bool Happened(const SceneRun& run, std::initializer_list<std::string_view> names) {
  return std::ranges::any_of(run.events, [&](const EventCount& event) {
    return std::ranges::find(names, event.name) != names.end();
  });
}

bool Reached(Effect effect, const SceneRun& run) {
  if (effect == Effect::kContactLoss) return Happened(run, {"take-off"});
  return Happened(run, {"impact up", "impact down", "stop up", "stop down"});
}

Finding Refused(FindingKind why, std::vector<FindingNumber> numbers = {}) {
  return {Severity::kRefusal, why, std::move(numbers)};
}

Finding WhyNotPlayed(const SceneRun& run) {
  if (!run.stalled_at_s) return Refused(FindingKind::kBeyondDoubles);
  return Refused(*run.stall_reason, {{"at_s", *run.stalled_at_s}});
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

  std::expected<EffectChoice, Finding> Decide() {
    choice_.on = all_;
    // the reference of all comparisons: everything that is on or "auto"
    PlayedScene everything = Play(all_);
    if (!everything.answered) return std::unexpected(*everything.refusal);
    // an exact motion's error cannot be reduced further, that of averages is their uncertainty
    const double asked = everything.run.solver_tolerance > 0
                             ? scene_.tolerance
                             : std::max(scene_.tolerance, kLargestPredictedError);
    if (!everything.chaotic && !(everything.run.error_estimate <= asked)) {
      return std::unexpected(TooCoarse(everything.run));
    }
    everything_ = everything.run;
    Take(std::move(everything));
    // first what is proved without a further run, then comparisons by runs
    LeaveOutWhatIsNeverReached();
    LeaveOutGravity();
    LeaveOutByComparison();
    choice_.change = Deviation(scene_.quantity, choice_.run, everything_);
    // omitted effects may change other quantities than the one asked for
    const double left_out = LargestDeviation(choice_.run, everything_);
    if (left_out > 0) choice_.run.error_estimate += left_out + everything_.error_estimate;
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
    choice_.chaotic = std::move(played.chaotic);
    choice_.end = played.end;
  }
  bool Asked(Effect effect) const { return scene_.effects[effect] == Wish::kAuto; }
  EffectVerdict& VerdictOf(Effect effect) { return choice_.verdicts[PlaceOf(effect)]; }

  void LeaveOut(Effect effect, Ground ground) {
    choice_.on.reset(PlaceOf(effect));
    VerdictOf(effect).on = false;
    VerdictOf(effect).ground = ground;
  }

  // Where several effects limit the motion or make it nonlinear, more than one steady motion may
  // exist, of which the transient selected one.
  bool MaySettleElsewhere() const {
    if (scene_.duration_s && StartOf(scene_) != Start::kSteady) return false;
    if (all_[PlaceOf(Effect::kStiffening)] || all_[PlaceOf(Effect::kCoilHeating)]) return true;
    const bool both = all_[PlaceOf(Effect::kTravelStops)] && all_[PlaceOf(Effect::kContactLoss)];
    return both && (scene_.duration_s || choice_.periodic || choice_.chaotic);
  }

  void LeaveOutWhatIsNeverReached() {
    for (const Effect effect : {Effect::kTravelStops, Effect::kContactLoss}) {
      if (!Asked(effect)) continue;
      // a mover that rests on a stop is held by it without an event
      const bool rests = effect == Effect::kTravelStops && RestsOnStop(WithEffects(scene_, all_));
      if (rests || MaySettleElsewhere() || Reached(effect, everything_)) {
        VerdictOf(effect).ground = Ground::kCompared;
      } else {
        LeaveOut(effect, Ground::kNeverReached);
      }
    }
  }

  Finding TooCoarse(const SceneRun& run) const {
    if (run.solver_tolerance == 0) {
      return Refused(FindingKind::kBeyondPrediction,
                     {{"tolerance", scene_.tolerance},
                      {"known_until_s", run.known_until_s.value_or(run.begin_s)}});
    }
    if (std::isinf(run.error_estimate)) return Refused(FindingKind::kErrorUnbounded);
    return Refused(FindingKind::kErrorTooLarge, {{"relative_error", run.error_estimate},
                                                 {"tolerance", scene_.tolerance},
                                                 {"least_tolerance", 2 * run.error_estimate}});
  }

  // without gravity a remaining stop might be reached, and a stiffening spring is softer
  void LeaveOutGravity() {
    if (!Asked(Effect::kGravity)) return;
    bool felt = false;
    for (const Effect effect : {Effect::kTravelStops, Effect::kContactLoss, Effect::kStiffening}) {
      felt = felt || choice_.on[PlaceOf(effect)];
    }
    // nothing depends on where the bodies rest: gravity shifts the motion only
    if (!felt) LeaveOut(Effect::kGravity, Ground::kSuperposed);
  }

  void LeaveOutByComparison() {
    std::vector<Effect> open;
    std::array<double, kEffectNames.size()> at_most{};
    for (std::size_t k = 0; k < kEffectNames.size(); ++k) {
      const auto effect = static_cast<Effect>(k);
      if (Asked(effect) && choice_.on[k]) open.push_back(effect);
    }
    // each effect off alone, to find its change
    for (const Effect effect : open) {
      EffectVerdict& verdict = VerdictOf(effect);
      verdict.ground = Ground::kCompared;
      EffectSet without = choice_.on;
      const PlayedScene played = Play(without.reset(PlaceOf(effect)));
      verdict.change = DeviationOf(played);
      at_most[PlaceOf(effect)] = DeviationAtMost(played);
    }
    // least change first; each is tested again together with those omitted before
    std::ranges::sort(open, {}, [&](Effect effect) { return at_most[PlaceOf(effect)]; });
    for (const Effect effect : open) {
      if (at_most[PlaceOf(effect)] <= scene_.tolerance) TryWithout(effect);
    }
  }

  void TryWithout(Effect effect) {
    EffectSet without = choice_.on;
    PlayedScene played = Play(without.reset(PlaceOf(effect)));
    if (!(DeviationAtMost(played) <= scene_.tolerance)) return;
    LeaveOut(effect, Ground::kCompared);
    Take(std::move(played));
  }

  // a run without an answer deviates without bound
  double DeviationOf(const PlayedScene& played) const {
    return played.answered ? Deviation(scene_.quantity, played.run, everything_) : HUGE_VAL;
  }
  // with the errors of both runs, on the safe side
  double DeviationAtMost(const PlayedScene& played) const {
    return DeviationOf(played) + played.run.error_estimate + everything_.error_estimate;
  }

  const Scene& scene_;
  EffectSet all_;
  SceneRun everything_;
  EffectChoice choice_;
  std::size_t runs_ = 0;
};

}  // namespace

namespace {

// Whether the end of a run repeats, and the run again over a window of whole periods of its own
// where ten periods of the drive are not.
void LookAtEnd(EffectiveScene scene, const PiecewiseStart& start, double temperature_rise_k,
               PlayedScene& played) {
  constexpr int kTenPeriods = 10;
  // a linear motion repeats after one period of the sine: nothing to find
  const bool limited = !played.run.events.empty() || !scene.IsLinear();
  const double lasts = *scene.scene.duration_s * scene.scene.drive.frequency_hz;
  if (!limited || scene.scene.drive.kind != DriveKind::kSine || lasts < kTenPeriods) return;
  played.end = RunEnd{.drive_periods = PeriodAtEnd(played.run),
                      .window_uncertainty = std::nullopt,
                      .ten_periods_rms_m = played.run.skin_rms_m};
  if (!played.end->drive_periods) {
    played.end->window_uncertainty = WindowUncertainty(played.run, kTenPeriods);
    return;
  }
  const int k = *played.end->drive_periods;
  if (kTenPeriods % k == 0) return;
  // the largest multiple of k periods that the run contains
  const int most = static_cast<int>(std::min(lasts * (1 + 1e-12), 1e6)) / k * k;
  scene.window_periods = std::min((kTenPeriods + k - 1) / k * k, most);
  const double error = played.run.error_estimate;
  played.run = RunScene(scene, *scene.scene.duration_s, start, temperature_rise_k);
  played.run.error_estimate = std::max(played.run.error_estimate, error);
}

}  // namespace

PlayedScene PlayWith(const Scene& scene, EffectSet on) {
  const EffectiveScene effective = WithEffects(scene, on);
  PlayedScene played;
  // a preload that is too small, or a skin that carries nothing
  if (!CanRest(effective)) {
    played.refusal = Refused(FindingKind::kNothingHolds);
    return played;
  }
  SteadyRun steady;
  if (!scene.duration_s || StartOf(scene) == Start::kSteady) {
    steady = PlaySteady(effective);
    if (!steady.run) {
      played.refusal = std::move(steady.refusal);
      return played;
    }
  } else {
    steady.start = StartIn(effective);
  }
  if (scene.duration_s) {
    // of a chaotic motion the run begins at one of its points, which is exact
    const double start_error = steady.run && !steady.chaotic ? steady.run->error_estimate : 0;
    played.run = RunScene(effective, *scene.duration_s, steady.start, steady.temperature_rise_k);
    if (!played.run.stalled_at_s) {
      LookAtEnd(effective, steady.start, steady.temperature_rise_k, played);
    }
    played.run.error_estimate += start_error;
  } else {
    played.run = std::move(*steady.run);
    played.periodic = std::move(steady.periodic);
    played.chaotic = std::move(steady.chaotic);
  }
  played.answered = !played.run.stalled_at_s && played.run.IsFinite();
  if (!played.answered) played.refusal = WhyNotPlayed(played.run);
  return played;
}

std::expected<EffectChoice, Finding> ChooseEffects(const Scene& scene) {
  return Decision(scene).Decide();
}

}  // namespace haptometer::sim
