#include "sim/effect_choice.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/effect_bound.h"
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
      choice_.on[k] = scene.effects.wishes[k] != Wish::kOff;
      choice_.verdicts[k] = {.on = choice_.on[k], .ground = GroundOf(scene.effects.wishes[k])};
    }
  }

  std::expected<EffectChoice, Finding> Decide() {
    LeaveOutByBound();
    // an answer that the bounds needed is not played again
    if (!base_ || choice_.on != base_on_) {
      Scene rest = scene_;
      rest.tolerance -= choice_.change;
      base_ = Play(rest, choice_.on);
    }
    if (!base_->answered) return std::unexpected(*base_->refusal);
    Take(*std::move(base_));
    // an exact motion's error cannot be reduced further, that of averages is their uncertainty
    const double asked = choice_.run.solver_tolerance > 0
                             ? scene_.tolerance
                             : std::max(scene_.tolerance, kLargestPredictedError);
    choice_.run.error_estimate += choice_.change;
    if (!choice_.chaotic && !(choice_.run.error_estimate <= asked)) {
      return std::unexpected(TooCoarse(choice_.run));
    }
    // both runs of the solver have the same drive: their difference does not show its error
    if (choice_.run.solver_tolerance > 0) choice_.run.error_estimate += DriveError(scene_);
    LeaveOutWhatIsNeverReached();
    LeaveOutGravity();
    return std::move(choice_);
  }

 private:
  static Ground GroundOf(Wish wish) {
    if (wish == Wish::kOff) return Ground::kNotNamed;
    return wish == Wish::kOn ? Ground::kNamed : Ground::kKept;
  }

  PlayedScene Play(const Scene& scene, EffectSet on) {
    ++choice_.runs;
    return PlayWith(scene, on);
  }
  void Take(PlayedScene played) {
    choice_.run = std::move(played.run);
    choice_.periodic = std::move(played.periodic);
    choice_.chaotic = std::move(played.chaotic);
    choice_.end = played.end;
  }
  bool Asked(Effect effect) const { return scene_.effects[effect] == Wish::kAuto; }

  void LeaveOut(Effect effect, Ground ground, double change = 0) {
    choice_.on.reset(PlaceOf(effect));
    choice_.verdicts[PlaceOf(effect)] = {.on = false, .ground = ground, .change = change};
    choice_.change += change;
  }

  // a motion that nothing limits or bends is one, wherever it began
  static bool IsLinear(const PlayedScene& played) {
    return played.answered && !played.periodic && !played.chaotic && played.run.events.empty();
  }

  // what disturbs the linear motion, least change first
  void LeaveOutByBound() {
    constexpr double kShareOfTolerance = 0.5;
    if (std::ranges::none_of(kDisturbances, [&](Effect effect) { return Asked(effect); })) return;
    base_on_ = WithoutDisturbances(choice_.on);
    base_ = Play(scene_, base_on_);
    if (!IsLinear(*base_)) return;
    const EffectBounds bounds = BoundEffects(scene_, choice_.on, base_->run);
    auto open = kDisturbances;
    std::ranges::sort(open, {}, [&](Effect effect) { return bounds[PlaceOf(effect)]; });
    for (const Effect effect : open) {
      const double change = bounds[PlaceOf(effect)];
      if (!Asked(effect)) continue;
      if (!(choice_.change + change <= kShareOfTolerance * scene_.tolerance)) return;
      LeaveOut(effect, Ground::kBounded, change);
    }
  }

  // Where several effects limit the motion or make it nonlinear, more than one steady motion may
  // exist, of which the transient selected one.
  bool MaySettleElsewhere() const {
    if (scene_.duration_s && StartOf(scene_) != Start::kSteady) return false;
    const EffectSet& on = choice_.on;
    if (on[PlaceOf(Effect::kStiffening)] || on[PlaceOf(Effect::kCoilHeating)]) return true;
    const bool both = on[PlaceOf(Effect::kTravelStops)] && on[PlaceOf(Effect::kContactLoss)];
    return both && (scene_.duration_s || choice_.periodic || choice_.chaotic);
  }

  void LeaveOutWhatIsNeverReached() {
    // a mover that rests on a stop is held by it without an event
    const bool rests = RestsOnStop(WithEffects(scene_, choice_.on));
    const bool elsewhere = MaySettleElsewhere();
    for (const Effect effect : {Effect::kTravelStops, Effect::kContactLoss}) {
      const bool held = rests && effect == Effect::kTravelStops;
      if (!Asked(effect) || held || elsewhere || Reached(effect, choice_.run)) continue;
      LeaveOut(effect, Ground::kNeverReached);
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

  const Scene& scene_;
  EffectSet base_on_;  // of the motion that the bounds begin with
  std::optional<PlayedScene> base_;
  EffectChoice choice_;
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
  // in periods; a run of exactly ten may miss them by a rounding
  const double lasts = *scene.scene.duration_s * scene.scene.drive.frequency_hz * (1 + 1e-12);
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
  const int most = static_cast<int>(std::min(lasts, 1e6)) / k * k;
  scene.window_periods = std::min((kTenPeriods + k - 1) / k * k, most);
  const double error = played.run.error_estimate;
  played.run = RunScene(scene, *scene.scene.duration_s, start, temperature_rise_k);
  played.run.error_estimate = std::max(played.run.error_estimate, error);
}

}  // namespace

void NoteUnused(const Scene& scene, Findings& findings) {
  for (std::size_t place = 0; place < kEffectNames.size(); ++place) {
    if (!scene.effects.stated[place] || scene.effects.wishes[place] != Wish::kOff) continue;
    const std::string name(kEffectNames[place]);
    const bool of_skin = place == PlaceOf(Effect::kContactLoss);
    findings.Note(FindingKind::kEffectOff,
                  {{"constants", of_skin ? "preload_n" : name}, {"effect", name}});
  }
  // with effects the transient from the start selects the motion that a scene settles to
  const bool is_steady = !scene.duration_s && IsLasting(scene.drive) && !scene.effects.Asked();
  if (is_steady && scene.initial.Any()) findings.Note(FindingKind::kStartUnused);
}

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
