#include "dsp/analysis/window/window_states.h"

#include <algorithm>
#include <cmath>

#include "base/median.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/decision_limits.h"

namespace haptometer::dsp {

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

namespace {

// samples of a state that are free of transients, without its outer blocks where it changes
std::pair<std::size_t, std::size_t> InnerSamples(const Course& course, std::size_t k,
                                                 double lower_hz) {
  TimeWindow inner = course.states[k].time;
  if (k > 0) inner.begin_s += course.blocks.block_s;
  if (k + 1 < course.states.size()) {
    inner.end_s -= course.blocks.block_s;
  } else {
    // what is left behind the last block belongs to its state, but not a rest that a window fits in
    const double settled_s = TimeOfSample(*course.signal, course.signal->settled_end());
    if (settled_s - inner.end_s <= kBlockPeriods / lower_hz) inner.end_s = settled_s;
  }
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

}  // namespace

double LogOfPauses(const Course& course, const StateInterval& drive) {
  std::vector<double> logs;
  for (const StateInterval& state : course.states) {
    if (!IsQuiet(state, drive)) continue;
    for (std::size_t k = state.first; k < state.end; ++k) {
      logs.push_back(LogOf(course.blocks.blocks[k].mean_square, drive.level_m));
    }
  }
  if (logs.size() < kFewest) return kUnknownPause;
  return UpperMedian(std::move(logs));
}

SampleRanges BumpsIn(const Course& course, double DriveBlock::* mean_square, double level_m,
                     std::size_t begin, std::size_t end, double of_pause) {
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

std::pair<std::size_t, std::size_t> WindowOf(const Course& course, std::size_t k, double lower_hz) {
  if (!course.states[k].is_steady) return {0, 0};
  const auto [begin, end] = InnerSamples(course, k, lower_hz);
  const double duration_s = static_cast<double>(end - begin) / course.signal->rate_hz();
  if (duration_s < kLeastWindowPeriods / lower_hz) return {0, 0};
  return {begin, end};
}

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

namespace {

// what states outside of a window last together, and their mean RMS
struct Outside {
  double seconds = 0;
  double energy = 0;  // m2 s

  void Add(const StateInterval& state) {
    seconds += state.time.duration_s();
    energy += state.rms_m * state.rms_m * state.time.duration_s();
  }
  void Add(const Outside& other) {
    seconds += other.seconds;
    energy += other.energy;
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

// What goes up and down beside `drive`, at its frequency and never steady: from the first fall that
// a rise follows without a pause, all of that run.
Outside SwellingWith(const StateInterval& drive, const Course& course) {
  Outside swelling;
  Outside run;
  bool falls = false;
  bool rises_again = false;
  for (const StateInterval& state : course.states) {
    const bool goes_on = state.state == DriveState::kOn && !AreApart(state, drive);
    if (goes_on && !state.is_steady) run.Add(state);
    if (goes_on && !state.is_steady && state.blocks() > 1) {
      rises_again = rises_again || (falls && state.drift > 0);
      falls = falls || state.drift < 0;
    }
    if (goes_on && &state != &course.states.back()) continue;
    if (rises_again) swelling.Add(run);
    run = {};
    falls = rises_again = false;
  }
  return swelling;
}

}  // namespace

bool IsPassedOver(const StateInterval& drive, const std::vector<Course>& courses) {
  return StrongerThan(drive, courses).seconds > kMajority * drive.time.duration_s();
}

std::optional<Finding> OtherVibration(const StateInterval& drive, const Course& of,
                                      const std::vector<Course>& courses, double least_m,
                                      double lower_hz) {
  const Outside stronger = StrongerThan(drive, courses);
  if (stronger.seconds > static_cast<double>(kFewest) * of.blocks.block_s) {
    return stronger.As(Severity::kDoubt);
  }
  const Outside swelling = SwellingWith(drive, of);
  if (swelling.seconds > drive.time.duration_s()) return swelling.As(Severity::kDoubt);
  const Outside weaker = LongestOfWeaker(courses, least_m, lower_hz);
  if (weaker.seconds > drive.time.duration_s()) return weaker.As(Severity::kNote);
  return std::nullopt;
}

std::size_t SizeOf(const SampleRanges& ranges) {
  std::size_t size = 0;
  for (const auto& [begin, end] : ranges) size += end - begin;
  return size;
}

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

}  // namespace haptometer::dsp
