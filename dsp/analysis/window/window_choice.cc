#include "dsp/analysis/window/window_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "base/median.h"
#include "dsp/analysis/decision_limits.h"
#include "dsp/analysis/drive_states.h"
#include "dsp/spectrum/sine_fit.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

// blocks of a period of the lower corner, then longer ones for tones below the noise
constexpr std::array<double, 3> kBlockLengths{1, kLongerBlocks, kLongerBlocks* kLongerBlocks};
constexpr double kUnknown = std::numeric_limits<double>::infinity();

// one signal, its hum, its blocks and their states
struct Course {
  const BandSignal* signal = nullptr;
  std::vector<SteadyLine> hum;
  BlockCourse blocks;
  std::vector<StateInterval> states;
};

Result<std::vector<Course>> FindHumOf(const std::vector<BandSignal>& all,
                                      const BandQuestion& question) {
  std::vector<Course> courses;
  courses.reserve(all.size());
  for (const BandSignal& signal : all) {
    Course& course = courses.emplace_back();
    course.signal = &signal;
    if (question.keep_hum) continue;
    HAPTOMETER_LET(course.hum, FindHum(signal, question.band, question.drive_frequency_hz));
  }
  return courses;
}

// The shortest blocks whose noise, which swings as slowly as the band is wide, has six independent
// values: 2 B of them in a second.
double LeastIndependentS(const BandPass& band) { return 3 / (band.upper_hz - band.lower_hz); }

// blocks and states of every signal, `length` times as long as the shortest blocks, which last
// `least_s` at least
Result<void> FindStatesOf(const BandPass& band, double length, double least_s,
                          std::vector<Course>& courses) {
  for (Course& course : courses) {
    // short segments have shorter blocks
    const double duration_s = SettledSeconds(*course.signal);
    const double usual_s =
        std::max(kShortestBlockS, std::min(1 / band.lower_hz, duration_s / (3.0 * kFewest)));
    const double block_s = length * std::max(usual_s, least_s);
    course.states.clear();
    course.blocks.blocks.clear();
    if (duration_s < kLeastWindowPeriods / band.lower_hz) continue;
    if (length > 1 && duration_s < kFewest * block_s) continue;
    HAPTOMETER_LET(course.blocks, MeasureBlocks(*course.signal, band, block_s, course.hum));
    course.states = FindStates(course.blocks, band.lower_hz);
  }
  return {};
}

// samples of a state that are free of transients, without its outer blocks where it changes
std::pair<std::size_t, std::size_t> InnerSamples(const Course& course, std::size_t k) {
  TimeWindow inner = course.states[k].time;
  if (k > 0) inner.begin_s += course.blocks.block_s;
  // the last block of a segment is cut: the state lasts to its end
  inner.end_s = k + 1 < course.states.size()
                    ? inner.end_s - course.blocks.block_s
                    : TimeOfSample(*course.signal, course.signal->settled_end());
  if (inner.end_s <= inner.begin_s) return {0, 0};
  return SettledWithin(*course.signal, inner);
}

// whether the tones of two states differ by more than what is beside a drive
bool AreApart(const StateInterval& a, const StateInterval& b) {
  const double a_hz = 0.5 * (a.from_hz + a.to_hz);
  const double b_hz = 0.5 * (b.from_hz + b.to_hz);
  return std::abs(a_hz - b_hz) > std::max(kDriveReachHz, kSameWithin * b_hz);
}

// Whether a state is no drive beside `drive`: off, or a steady tone far below it, or weaker and of
// another frequency, which may be there all the time; NoiseOfQuiet asks whether it is.
bool IsQuiet(const StateInterval& state, const StateInterval& drive) {
  if (state.state == DriveState::kOff) return true;
  if (!state.is_steady || state.level_m >= drive.level_m) return false;
  return state.level_m < kMajority * drive.level_m || AreApart(state, drive);
}

// logarithm of a mean square, as far as it counts beside a drive of `level_m`
double LogOf(double mean_square, double level_m) {
  return std::log(mean_square + std::max(1e-300, std::pow(kLevelFloor * level_m, 2)));
}

// median of the logarithms over all blocks without a drive; unknown where there are few
double LogOfPauses(const Course& course, const StateInterval& drive) {
  std::vector<double> logs;
  for (const StateInterval& state : course.states) {
    if (!IsQuiet(state, drive)) continue;
    for (std::size_t k = state.first; k < state.end; ++k) {
      logs.push_back(LogOf(course.blocks.blocks[k].mean_square, drive.level_m));
    }
  }
  if (logs.size() < kFewest) return kUnknown;
  return UpperMedian(std::move(logs));
}

// blocks that are bumps by logarithms of a mean square, against their median, or that of a pause
// where it is less; `expected` is their scatter in noise
SampleRanges BumpBlocks(const std::vector<double>& logs, double expected, double of_pause) {
  if (logs.size() < kFewest) return {};
  std::vector<double> sorted = logs;
  std::ranges::sort(sorted);
  const double median = std::min(of_pause, sorted[sorted.size() / 2]);
  // scatter by the lower quartile, which bumps do not reach
  const double scatter =
      std::max(kDeviationsPerMedian * (median - sorted[sorted.size() / 4]), expected);
  const double limit = median + std::max(kBumpLeast, kFalseAlarmDeviations * scatter);
  SampleRanges bumps;
  for (std::size_t k = 0; k < logs.size(); ++k) {
    if (logs[k] <= limit) continue;
    // until it is near the median again, and a block more
    std::size_t from = k;
    std::size_t to = k + 1;
    while (from > 0 && logs[from - 1] > median + scatter) --from;
    while (to < logs.size() && logs[to] > median + scatter) ++to;
    bumps.emplace_back(from - std::min<std::size_t>(from, 1), to + 1);
    k = to - 1;
  }
  return bumps;
}

// Bumps: samples within [begin, end) of blocks of which a mean square is far above its median
// there, of those beside them until it is near the median again, and of one more, to which the
// filter spreads them. What is far below the drive's level does not count.
SampleRanges BumpsIn(const Course& course, double DriveBlock::* mean_square, double level_m,
                     std::size_t begin, std::size_t end, double of_pause = kUnknown) {
  const double block_samples = course.blocks.block_s * course.signal->rate_hz();
  // blocks count from their own first sample
  const auto base = static_cast<std::size_t>(
      std::lround((course.blocks.start_s - course.signal->start_s()) * course.signal->rate_hz()));
  begin = std::max(begin, base);
  if (end <= begin) return {};
  const auto first = static_cast<std::size_t>(static_cast<double>(begin - base) / block_samples);
  const auto last =
      std::min(course.blocks.blocks.size(),
               static_cast<std::size_t>(static_cast<double>(end - base) / block_samples) + 1);
  std::vector<double> logs;
  for (std::size_t k = first; k < last; ++k) {
    logs.push_back(LogOf(course.blocks.blocks[k].*mean_square, level_m));
  }
  const auto sample_at = [&](std::size_t block) {
    const double sample = static_cast<double>(first + block) * block_samples;
    return std::clamp(base + static_cast<std::size_t>(sample), begin, end);
  };
  SampleRanges bumps;
  for (const auto& [from, to] :
       BumpBlocks(logs, std::sqrt(2 / course.blocks.degrees_of_freedom()), of_pause)) {
    if (!bumps.empty() && sample_at(from) <= bumps.back().second) {
      bumps.back().second = sample_at(to);
    } else {
      bumps.emplace_back(sample_at(from), sample_at(to));
    }
  }
  return bumps;
}

// intervals without `drive`, away from everything else and from bumps
std::vector<TimeWindow> QuietOf(const Course& course, const StateInterval& drive, double lower_hz) {
  const BandSignal& signal = *course.signal;
  const std::vector<StateInterval>& states = course.states;
  std::vector<TimeWindow> quiet;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (!IsQuiet(states[k], drive)) continue;
    // a drive that ends just within a segment, or begins: a line through it and noise crosses zero
    if (k == 0 && states[k].drift < -2) continue;
    if (k + 1 == states.size() && states[k].drift > 2) continue;
    TimeWindow window = states[k].time;
    if (k > 0) window.begin_s += kQuietPeriods / lower_hz;
    window.end_s = k + 1 < states.size() ? window.end_s - kQuietPeriods / lower_hz
                                         : TimeOfSample(signal, signal.settled_end());
    if (window.end_s <= window.begin_s) continue;
    const auto [begin, end] = SettledWithin(signal, window);
    for (const auto& [from, to] :
         BumpsIn(course, &DriveBlock::mean_square, drive.level_m, begin, end)) {
      const double from_s = TimeOfSample(signal, from);
      if (from_s > window.begin_s) quiet.push_back({window.begin_s, from_s});
      window.begin_s = TimeOfSample(signal, to);
    }
    if (window.end_s > window.begin_s) quiet.push_back(window);
  }
  return quiet;
}

std::size_t SizeOf(const SampleRanges& ranges) {
  std::size_t size = 0;
  for (const auto& [begin, end] : ranges) size += end - begin;
  return size;
}

// samples of a steady state that make a window; else none
std::pair<std::size_t, std::size_t> WindowOf(const Course& course, std::size_t k, double lower_hz) {
  if (!course.states[k].is_steady) return {0, 0};
  const auto [begin, end] = InnerSamples(course, k);
  const double duration_s = static_cast<double>(end - begin) / course.signal->rate_hz();
  if (duration_s < kLeastWindowPeriods / lower_hz) return {0, 0};
  return {begin, end};
}

// the strongest level of all states that make a window
double StrongestLevel(const std::vector<Course>& courses, double lower_hz) {
  double strongest_m = 0;
  for (const Course& course : courses) {
    for (std::size_t k = 0; k < course.states.size(); ++k) {
      const auto [begin, end] = WindowOf(course, k, lower_hz);
      if (end > begin) strongest_m = std::max(strongest_m, course.states[k].level_m);
    }
  }
  return strongest_m;
}

// what states outside of a window last together, and their mean RMS
struct Outside {
  double seconds = 0;
  double energy = 0;  // m2 s

  void Add(const StateInterval& state) {
    seconds += state.time.duration_s();
    energy += state.rms_m * state.rms_m * state.time.duration_s();
  }
  [[nodiscard]] Finding As(Severity severity) const {
    return {.severity = severity,
            .kind = FindingKind::kOtherVibration,
            .numbers = {{"other_s", seconds}, {"rms_m", std::sqrt(energy / seconds)}}};
  }
};

// all that is twice as strong as `drive`, steady or not; not the border between two states
Outside StrongerThan(const StateInterval& drive, const std::vector<Course>& courses) {
  Outside stronger;
  for (const Course& course : courses) {
    for (const StateInterval& state : course.states) {
      if (state.blocks() > 1 && kMajority * state.rms_m > drive.rms_m) stronger.Add(state);
    }
  }
  return stronger;
}

// the longest window of a level that is too weak beside the strongest, but no noise
Outside LongestOfWeaker(const std::vector<Course>& courses, double least_m, double lower_hz) {
  Outside longest;
  for (const Course& course : courses) {
    for (std::size_t k = 0; k < course.states.size(); ++k) {
      const StateInterval& state = course.states[k];
      const auto [begin, end] = WindowOf(course, k, lower_hz);
      if (end == begin || state.level_m >= least_m) continue;
      if (state.level_m < kNoticeable * least_m) continue;
      if (state.time.duration_s() < longest.seconds) continue;
      longest = {};
      longest.Add(state);
    }
  }
  return longest;
}

// Nothing where most of the time that a window stands for is stronger and never steady; else the
// finding of a vibration that the window is not of, as long as eight blocks or longer than it.
std::optional<ChosenPart> WithOther(ChosenPart chosen, const Course& of,
                                    const std::vector<Course>& courses, double least_m,
                                    double lower_hz) {
  const StateInterval& drive = chosen.part.state;
  const Outside stronger = StrongerThan(drive, courses);
  if (stronger.seconds > kMajority * drive.time.duration_s()) return std::nullopt;
  const Outside weaker = LongestOfWeaker(courses, least_m, lower_hz);
  if (stronger.seconds > static_cast<double>(kFewest) * of.blocks.block_s) {
    chosen.other = stronger.As(Severity::kDoubt);
  } else if (weaker.seconds > drive.time.duration_s()) {
    chosen.other = weaker.As(Severity::kNote);
  }
  return chosen;
}

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
  best->hum = of->hum;
  const StateInterval& drive = best->part.state;
  best->part.quiet = QuietOf(*of, drive, lower_hz);
  // bumps throughout, beside a pause or beside each other, are none; at an end they shorten the
  // window
  const double most = kMajority * static_cast<double>(best->end - best->begin);
  for (const double of_pause : {LogOfPauses(*of, drive), kUnknown}) {
    best->excluded =
        BumpsIn(*of, &DriveBlock::residual, drive.level_m, best->begin, best->end, of_pause);
    if (static_cast<double>(SizeOf(best->excluded)) <= most) break;
    if (of_pause < kUnknown) best->may_be_bumps = best->excluded;
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
  return WithOther(*std::move(best), *of, courses, least_m, lower_hz);
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
  double least_m = kUnknown;
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

double TimeOfSample(const BandSignal& signal, std::size_t sample) {
  return signal.start_s() + static_cast<double>(sample) / signal.rate_hz();
}

std::pair<std::size_t, std::size_t> SettledWithin(const BandSignal& signal,
                                                  const TimeWindow& window) {
  // the nearest sample, moved inwards to the samples free of transients
  const auto at = [&](double time_s) {
    const double sample = std::round((time_s - signal.start_s()) * signal.rate_hz());
    return static_cast<std::size_t>(std::clamp(sample, static_cast<double>(signal.settled_begin()),
                                               static_cast<double>(signal.settled_end())));
  };
  const std::size_t begin = at(window.begin_s);
  return {begin, std::max(begin, at(window.end_s))};
}

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
