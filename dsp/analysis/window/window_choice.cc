#include "dsp/analysis/window/window_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_states.h"
#include "dsp/analysis/window/window_states.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

// blocks of a period of the lower corner, then longer ones for tones below the noise
constexpr std::array<double, 3> kBlockLengths{1, kLongerBlocks, kLongerBlocks* kLongerBlocks};

// The shortest blocks whose noise, which swings as slowly as the band is wide, has six independent
// values: 2 B of them in a second.
double LeastIndependentS(const BandPass& band) { return 3 / (band.upper_hz - band.lower_hz); }

// the longest steady state that is on, over all signals, without those far below the strongest
std::optional<ChosenPart> LongestSteady(const std::vector<Course>& courses, double lower_hz) {
  const double least_m = kMajority * StrongestLevel(courses, lower_hz);
  std::optional<ChosenPart> best;
  const Course* of = nullptr;
  for (const Course& course : courses) {
    for (std::size_t k = 0; k < course.states.size(); ++k) {
      const auto [begin, end] = WindowOf(course, k, lower_hz);
      if (end == begin || course.states[k].level_m < least_m) continue;
      if (best && end - begin <= best->end - best->begin) continue;
      of = &course;
      best = ChosenPart{course.signal, begin, end};
      best->part.why.kind =
          course.states.size() == 1 ? FindingKind::kOneState : FindingKind::kSteadyDrive;
      best->part.from_drive = true;
      best->part.state = course.states[k];
    }
  }
  if (!best) return best;
  const StateInterval& drive = best->part.state;
  if (IsPassedOver(drive, courses)) return std::nullopt;
  best->hum = of->hum;
  best->part.quiet = QuietOf(*of, drive, lower_hz);
  // bumps throughout, beside a pause or beside each other, are none; at an end they shorten the
  // window
  const double most = kMajority * static_cast<double>(best->end - best->begin);
  for (const double of_pause : {LogOfPauses(*of, drive), kUnknownPause}) {
    best->excluded =
        BumpsIn(*of, &DriveBlock::residual, drive.level_m, best->begin, best->end, of_pause);
    if (static_cast<double>(SizeOf(best->excluded)) <= most) break;
    if (of_pause < kUnknownPause) best->may_be_bumps = best->excluded;
    best->excluded.clear();
  }
  SampleRanges& bumps = best->excluded;
  if (!bumps.empty() && bumps.front().first == best->begin) {
    best->begin = bumps.front().second;
    bumps.erase(bumps.begin());
  }
  if (!bumps.empty() && bumps.back().second == best->end) {
    best->end = bumps.back().first;
    bumps.pop_back();
  }
  best->other = OtherVibration(drive, *of, courses, least_m, lower_hz);
  return best;
}

ChosenPart AllSettled(const BandSignal& signal) {
  ChosenPart chosen{&signal, signal.settled_begin(), signal.settled_end()};
  chosen.part.why.kind = FindingKind::kAllSettled;
  return chosen;
}

// the part free of transients of a given window, in the signal that holds most of it
std::optional<ChosenPart> ChooseGiven(const std::vector<BandSignal>& all,
                                      const BandQuestion& question, BandAnalysis* analysis) {
  ChosenPart chosen;
  for (const BandSignal& signal : all) {
    const auto [begin, end] = SettledWithin(signal, question.window);
    if (end - begin > chosen.end - chosen.begin) chosen = {&signal, begin, end};
  }
  const double found_s = chosen.signal == nullptr ? 0
                                                  : static_cast<double>(chosen.end - chosen.begin) /
                                                        chosen.signal->rate_hz();
  // refusals: no samples there, or fewer than a window needs
  const FindingNumber from{"from_s", question.window.begin_s};
  const FindingNumber to{"to_s", question.window.end_s};
  const double end_s = TimeOfSample(all.back(), all.back().size());
  if (question.window.begin_s >= end_s || question.window.end_s <= all.front().start_s()) {
    analysis->findings.Refuse(
        FindingKind::kWindowOutside,
        {from, to, {"record_from_s", all.front().start_s()}, {"record_to_s", end_s}});
    return std::nullopt;
  }
  if (chosen.signal == nullptr || found_s < kLeastWindowPeriods / question.band.lower_hz) {
    analysis->findings.Refuse(FindingKind::kWindowNotSettled, {from, to, {"settled_s", found_s}});
    return std::nullopt;
  }
  // two samples are lost by rounding the window to samples
  const double missing_s = question.window.duration_s() - found_s;
  if (missing_s > 2 / chosen.signal->rate_hz()) {
    analysis->findings.Note(FindingKind::kWindowShortened, {{"excluded_s", missing_s}, from, to});
  }
  chosen.part.why = {.kind = FindingKind::kWindowAsked, .numbers = {from, to}};
  return chosen;
}

void KeepStates(const std::vector<Course>& courses, BandAnalysis* analysis) {
  analysis->states.clear();
  for (const Course& course : courses) {
    analysis->states.insert(analysis->states.end(), course.states.begin(), course.states.end());
  }
}

// refusal where nothing that is on is steady, or nothing is on
Finding WhyNoDrive(const std::vector<Course>& courses, const BandAnalysis& analysis) {
  double on_s = 0;
  for (const StateInterval& state : analysis.states) {
    if (state.state == DriveState::kOn || state.is_short_at_foot) on_s += state.time.duration_s();
  }
  Finding why{.severity = Severity::kRefusal, .kind = FindingKind::kNoDrive};
  if (on_s > 0) {
    why.kind = FindingKind::kNothingSteady;
    why.numbers = {{"on_s", on_s}};
    return why;
  }
  // a tone of the mains that never pauses may be hum or the drive
  const auto hums =
      std::ranges::find_if(courses, [](const Course& one) { return !one.hum.empty(); });
  if (hums == courses.end()) return why;
  why.kind = FindingKind::kMainsFrequency;
  why.numbers = {{"frequency_hz", hums->hum.front().frequency_hz},
                 {"amplitude_m", hums->hum.front().amplitude_m()}};
  return why;
}

// A tone far below the noise of a block, which stands out of all that is free of transients and is
// there in both halves alike: one state. Not at the band's foot, where tremor has lines.
Result<std::optional<ChosenPart>> FaintTone(const std::vector<Course>& courses,
                                            const BandPass& band, BandAnalysis* analysis) {
  const Course& course = *std::ranges::max_element(
      courses, {}, [](const Course& one) { return SettledSeconds(*one.signal); });
  const BandSignal& signal = *course.signal;
  if (static_cast<double>(signal.size()) < kLeastLineS * signal.rate_hz()) return std::nullopt;
  HAPTOMETER_LET(auto samples, ReadMiddle(signal, signal.settled_begin(), signal.settled_end()));
  const std::size_t size = signal.settled_end() - signal.settled_begin();
  const std::size_t first = signal.settled_begin() + (size - samples.size()) / 2;
  SubtractLines(course.hum, signal.rate_hz(), static_cast<double>(first), samples);
  const double bandwidth_hz = band.upper_hz - band.lower_hz;
  const auto tone = StrongestTone(samples, {signal.rate_hz(), kFootReach * band.lower_hz,
                                            band.upper_hz, bandwidth_hz, kFaintFalseAlarm});
  if (!tone) return std::nullopt;
  const std::span<const double> all = samples;
  const SineFitOptions options{signal.rate_hz(), bandwidth_hz, 0};
  const SineFit begin = FitSineAt(all.first(all.size() / 2), options, tone->frequency_hz);
  const SineFit end = FitSineAt(all.subspan(all.size() / 2), options, tone->frequency_hz);
  const double apart = std::abs(begin.amplitude - end.amplitude);
  if (!begin.converged || !end.converged || apart > kSteadyWithin * tone->amplitude) {
    return std::nullopt;
  }
  StateInterval state;
  state.state = DriveState::kOn;
  state.end = 1;
  state.level_m = tone->amplitude;
  state.from_hz = state.to_hz = tone->frequency_hz;
  state.coherence = 1;
  state.is_steady = true;
  state.time = {TimeOfSample(signal, signal.settled_begin()),
                TimeOfSample(signal, signal.settled_end())};
  state.rms_m = tone->amplitude / std::numbers::sqrt2;
  ChosenPart chosen = AllSettled(signal);
  chosen.hum = course.hum;
  chosen.part.why.kind = FindingKind::kOneState;
  chosen.part.from_drive = true;
  chosen.part.state = state;
  analysis->states = {state};
  return chosen;
}

// Whether a tone at a multiple of the mains may be hum, unless stated as the drive: the shortest
// blocks do not show it, or at 50 or 60 Hz no state falls to half its power, as in a pause.
bool MayBeHum(const ChosenPart& found, const std::vector<StateInterval>& states, bool is_shortest,
              const BandQuestion& question) {
  const StateInterval& on = found.part.state;
  const double frequency_hz = 0.5 * (on.from_hz + on.to_hz);
  const auto stated_hz = question.drive_frequency_hz;
  const double half = kSteadyWithin * on.rms_m * on.rms_m;
  const auto falls = [&](const StateInterval& one) { return one.rms_m * one.rms_m < half; };
  const bool pauses =
      found.part.why.kind == FindingKind::kOneState
          ? is_shortest
          : frequency_hz > kMainsHz.back() + kMainsWithinHz || std::ranges::any_of(states, falls);
  // what the mains may be off, and a tenth of a bin
  const double tolerance_hz =
      kMainsPart * frequency_hz + 1 / (2 * kReachBins * on.time.duration_s());
  return !pauses && IsOfMains(frequency_hz, tolerance_hz) &&
         !(stated_hz && std::abs(*stated_hz - frequency_hz) < kMainsWithinHz);
}

// all that is free of transients, with the refusal of a tone that may be hum
ChosenPart WithoutDrive(const ChosenPart& may_be_hum) {
  ChosenPart none = AllSettled(*may_be_hum.signal);
  const StateInterval& state = may_be_hum.part.state;
  none.refusal = {.severity = Severity::kRefusal,
                  .kind = FindingKind::kMainsFrequency,
                  .numbers = {{"frequency_hz", 0.5 * (state.from_hz + state.to_hz)},
                              {"amplitude_m", state.level_m}}};
  return none;
}

// The longest steady part by blocks of this length. Where those of a narrow band show a drive that
// changes, its noise may do that: longer ones decide.
Result<std::optional<ChosenPart>> SteadiestOf(const BandPass& band, double length,
                                              std::vector<Course>& courses) {
  HAPTOMETER_TRY(FindStatesOf(band, length, 0, courses));
  const double least_s = LeastIndependentS(band);
  const bool may_be_noise = std::ranges::any_of(courses, [&](const Course& course) {
    return course.states.size() > 1 && course.blocks.block_s < length * least_s;
  });
  if (may_be_noise) HAPTOMETER_TRY(FindStatesOf(band, length, least_s, courses));
  return LongestSteady(courses, band.lower_hz);
}

// whether a tone at the band's foot that comes and goes is most of what there is: longer blocks
// would average its pauses
bool PausesAtFoot(const std::vector<StateInterval>& states) {
  double all = 0;
  double at_foot = 0;
  double level_m = 0;
  double least_m = std::numeric_limits<double>::infinity();
  for (const StateInterval& state : states) {
    const double energy = state.rms_m * state.rms_m * state.time.duration_s();
    all += energy;
    if (state.is_short_at_foot) at_foot += energy;
    if (state.is_short_at_foot) level_m = std::max(level_m, state.level_m);
    least_m = std::min(least_m, state.level_m);
  }
  return at_foot > kMajority * all && least_m < kMajority * level_m;
}

// the drive of the longest steady state, else a refusal beside all that is free of transients
Result<ChosenPart> ChooseDriven(std::vector<Course>& courses, const std::vector<BandSignal>& all,
                                const BandQuestion& question, BandAnalysis* analysis) {
  for (const double length : kBlockLengths) {
    HAPTOMETER_LET(auto best, SteadiestOf(question.band, length, courses));
    const bool is_shortest = length == kBlockLengths.front();
    if (best || is_shortest) KeepStates(courses, analysis);
    if (!best && is_shortest && PausesAtFoot(analysis->states)) break;
    if (!best) continue;
    const bool is_hum = MayBeHum(*best, analysis->states, is_shortest, question);
    return is_hum ? WithoutDrive(*best) : *std::move(best);
  }
  if (std::ranges::none_of(analysis->states, [](const StateInterval& state) {
        return state.state == DriveState::kOn || state.is_short_at_foot;
      })) {
    HAPTOMETER_LET(auto faint, FaintTone(courses, question.band, analysis));
    if (faint && MayBeHum(*faint, {}, false, question)) return WithoutDrive(*faint);
    if (faint) return *std::move(faint);
  }
  ChosenPart none = AllSettled(LongestSettled(all));
  none.refusal = WhyNoDrive(courses, *analysis);
  return none;
}

// a given window: its state, where it lies in one that is on; a doubt where it is mixed
void DescribeGiven(const std::vector<Course>& courses, double lower_hz, ChosenPart& chosen,
                   BandAnalysis* analysis) {
  const auto course = std::ranges::find(courses, chosen.signal, &Course::signal);
  const TimeWindow window{TimeOfSample(*chosen.signal, chosen.begin),
                          TimeOfSample(*chosen.signal, chosen.end)};
  double on_s = 0;
  bool any_on = false;
  for (const StateInterval& state : course->states) {
    const double shared_s =
        std::min(window.end_s, state.time.end_s) - std::max(window.begin_s, state.time.begin_s);
    if (state.state != DriveState::kOn) continue;
    any_on = true;
    if (shared_s <= 0) continue;
    on_s += shared_s;
    chosen.part.state = state;
  }
  chosen.hum = course->hum;
  chosen.part.quiet = QuietOf(*course, chosen.part.state, lower_hz);
  // up to a period of the lower corner beside the drive is no mixture
  const double off_s = window.duration_s() - on_s;
  chosen.part.from_drive = on_s > 0 && off_s <= 1 / lower_hz + course->blocks.block_s;
  if (chosen.part.from_drive || !any_on) return;
  if (on_s > 0) {
    analysis->findings.Doubt(FindingKind::kWindowMixed,
                             {{"off_s", off_s}, {"window_s", window.duration_s()}});
  } else {
    analysis->findings.Doubt(FindingKind::kDriveOffInWindow);
  }
}

// a doubt where the window's amplitude or frequency moves
void RemarkUnsteady(const UsedPart& part, BandAnalysis* analysis) {
  if (!part.from_drive) return;
  const StateInterval& state = part.state;
  if (state.Drifts()) {
    analysis->findings.Doubt(FindingKind::kDriveUnsteady, {{"drift", state.drift}});
  }
  const auto [least, most] = std::minmax(state.from_hz, state.to_hz);
  if (most > (1 + kSweep) * least) {
    analysis->findings.Doubt(FindingKind::kFrequencyMoves,
                             {{"from_hz", state.from_hz}, {"to_hz", state.to_hz}});
  } else if (most > (1 + kSameWithin) * least) {
    analysis->findings.Note(FindingKind::kFrequencyDrifts,
                            {{"from_hz", state.from_hz}, {"to_hz", state.to_hz}});
  }
}

void RemarkBumps(const ChosenPart& chosen, BandAnalysis* analysis) {
  if (chosen.excluded.empty()) return;
  analysis->findings.Note(
      FindingKind::kBumpsExcluded,
      {{"count", chosen.excluded.size()},
       {"excluded_s", static_cast<double>(SizeOf(chosen.excluded)) / chosen.signal->rate_hz()},
       {"from_s", TimeOfSample(*chosen.signal, chosen.excluded.front().first)}});
}

}  // namespace

Result<std::vector<double>> ReadMiddle(const BandSignal& signal, std::size_t begin,
                                       std::size_t end) {
  std::vector<double> samples(FittedOf(end - begin));
  const std::size_t first = begin + (end - begin - samples.size()) / 2;
  HAPTOMETER_TRY(signal.Read(first, samples));
  return samples;
}

Result<std::optional<ChosenPart>> ChoosePart(const std::vector<BandSignal>& all,
                                             const BandQuestion& question, BandAnalysis* analysis) {
  HAPTOMETER_LET(auto courses, FindHumOf(all, question));
  if (question.choice == WindowChoice::kAuto) {
    HAPTOMETER_LET(auto chosen, ChooseDriven(courses, all, question, analysis));
    RemarkUnsteady(chosen.part, analysis);
    RemarkBumps(chosen, analysis);
    if (chosen.other) analysis->findings.Add(*chosen.other);
    return chosen;
  }
  auto chosen = question.choice == WindowChoice::kGiven ? ChooseGiven(all, question, analysis)
                                                        : AllSettled(LongestSettled(all));
  if (!chosen) return chosen;
  HAPTOMETER_TRY(FindStatesOf(question.band, 1, 0, courses));
  KeepStates(courses, analysis);
  DescribeGiven(courses, question.band.lower_hz, *chosen, analysis);
  RemarkUnsteady(chosen->part, analysis);
  return chosen;
}

}  // namespace haptometer::dsp
