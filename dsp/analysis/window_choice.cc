#include "dsp/analysis/window_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "dsp/analysis/drive_states.h"

namespace haptometer::dsp {
namespace {

// blocks of a period of the lower corner, then longer ones for tones below the noise
constexpr std::array<double, 3> kBlockLengths{1, 4, 16};
constexpr double kShortestBlockS = 0.015;
constexpr double kLeastBlocks = 24;  // in a segment, before blocks are made longer
constexpr std::size_t kLeastLongBlocks = 8;
// noise is measured this far from a drive, in periods of the lower corner: the filter rings there
constexpr double kQuietPeriods = 2.5;
// change of the amplitude over the window that is a doubt
constexpr double kUnsteady = 0.02;
// a frequency that changes by more than this part is a sweep
constexpr double kSweep = 0.1;

double DurationS(const BandSignal& signal) {
  return static_cast<double>(signal.size()) / signal.rate_hz();
}

// states of every signal in blocks of one length, in order of time
Result<std::vector<std::vector<StateInterval>>> StatesOf(const std::vector<BandSignal>& all,
                                                         const BandPass& band, double length) {
  std::vector<std::vector<StateInterval>> states;
  for (const BandSignal& signal : all) {
    // short segments have shorter blocks
    const double block_s =
        length *
        std::max(kShortestBlockS, std::min(1 / band.lower_hz, DurationS(signal) / kLeastBlocks));
    if (length > 1 && DurationS(signal) < kLeastLongBlocks * block_s) {
      states.emplace_back();
      continue;
    }
    const auto course = MeasureBlocks(signal, band, block_s, {});
    if (!course) return std::unexpected(course.error());
    states.push_back(FindStates(*course));
  }
  return states;
}

// samples of a state that are free of transients, without its outer blocks where it changes
std::pair<std::size_t, std::size_t> InnerSamples(const BandSignal& signal,
                                                 const std::vector<StateInterval>& states,
                                                 std::size_t k) {
  const StateInterval& state = states[k];
  const double block_s = state.time.duration_s() / static_cast<double>(state.blocks());
  TimeWindow inner = state.time;
  if (k > 0) inner.begin_s += block_s;
  // the last block of a segment is cut: the state lasts to its end
  inner.end_s =
      k + 1 < states.size() ? inner.end_s - block_s : TimeOfSample(signal, signal.settled_end());
  if (inner.end_s <= inner.begin_s) return {0, 0};
  return SettledWithin(signal, inner);
}

// intervals that are off, away from everything else
std::vector<TimeWindow> QuietOf(const BandSignal& signal, const std::vector<StateInterval>& states,
                                double lower_hz) {
  std::vector<TimeWindow> quiet;
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (states[k].state != DriveState::kOff) continue;
    TimeWindow window = states[k].time;
    if (k > 0) window.begin_s += kQuietPeriods / lower_hz;
    window.end_s = k + 1 < states.size() ? window.end_s - kQuietPeriods / lower_hz
                                         : TimeOfSample(signal, signal.settled_end());
    if (window.end_s > window.begin_s) quiet.push_back(window);
  }
  return quiet;
}

// the longest steady state that is on, over all signals
std::optional<ChosenPart> LongestSteady(const std::vector<BandSignal>& all,
                                        const std::vector<std::vector<StateInterval>>& states,
                                        double lower_hz) {
  std::optional<ChosenPart> best;
  for (std::size_t s = 0; s < all.size(); ++s) {
    for (std::size_t k = 0; k < states[s].size(); ++k) {
      if (!states[s][k].is_steady) continue;
      const auto [begin, end] = InnerSamples(all[s], states[s], k);
      const double duration_s = static_cast<double>(end - begin) / all[s].rate_hz();
      if (duration_s < kLeastWindowPeriods / lower_hz) continue;
      if (best && end - begin <= best->end - best->begin) continue;
      best = ChosenPart{&all[s], begin, end, {}};
      best->part.why.kind =
          states[s].size() == 1 ? FindingKind::kOneState : FindingKind::kSteadyDrive;
      best->part.from_drive = true;
      best->part.state = states[s][k];
      best->part.quiet = QuietOf(all[s], states[s], lower_hz);
    }
  }
  return best;
}

ChosenPart AllSettled(const BandSignal& signal) {
  ChosenPart chosen{&signal, signal.settled_begin(), signal.settled_end(), {}};
  chosen.part.why.kind = FindingKind::kAllSettled;
  return chosen;
}

// the part free of transients of a given window, in the signal that holds most of it
std::optional<ChosenPart> ChooseGiven(const std::vector<BandSignal>& all,
                                      const BandQuestion& question, BandAnalysis* analysis) {
  ChosenPart chosen;
  for (const BandSignal& signal : all) {
    const auto [begin, end] = SettledWithin(signal, question.window);
    if (end - begin > chosen.end - chosen.begin) chosen = {&signal, begin, end, {}};
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

// the drive of the longest steady state, else a refusal beside all that is free of transients
Result<ChosenPart> ChooseDriven(const std::vector<BandSignal>& all, const BandQuestion& question,
                                BandAnalysis* analysis) {
  for (const double length : kBlockLengths) {
    auto states = StatesOf(all, question.band, length);
    if (!states) return std::unexpected(states.error());
    auto best = LongestSteady(all, *states, question.band.lower_hz);
    if (!best && length > 1) continue;
    analysis->states.clear();
    for (const auto& one : *states) {
      analysis->states.insert(analysis->states.end(), one.begin(), one.end());
    }
    if (best) return *std::move(best);
  }
  ChosenPart none = AllSettled(LongestSettled(all));
  const bool any_on = std::ranges::any_of(
      analysis->states, [](const StateInterval& state) { return state.state == DriveState::kOn; });
  analysis->findings.Refuse(any_on ? FindingKind::kNothingSteady : FindingKind::kNoDrive);
  return none;
}

// a doubt where the window's amplitude or frequency moves
void RemarkUnsteady(const UsedPart& part, BandAnalysis* analysis) {
  if (!part.from_drive) return;
  const StateInterval& state = part.state;
  if (std::abs(state.drift) > kUnsteady) {
    analysis->findings.Doubt(FindingKind::kDriveUnsteady, {{"drift", state.drift}});
  }
  const auto [least, most] = std::minmax(state.from_hz, state.to_hz);
  if (most > (1 + kSweep) * least) {
    analysis->findings.Doubt(FindingKind::kFrequencyMoves,
                             {{"from_hz", state.from_hz}, {"to_hz", state.to_hz}});
  }
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
  if (auto read = signal.Read(first, samples); !read) return std::unexpected(read.error());
  return samples;
}

Result<std::optional<ChosenPart>> ChoosePart(const std::vector<BandSignal>& all,
                                             const BandQuestion& question, BandAnalysis* analysis) {
  if (question.choice == WindowChoice::kGiven) return ChooseGiven(all, question, analysis);
  if (question.choice == WindowChoice::kAll) return AllSettled(LongestSettled(all));
  auto chosen = ChooseDriven(all, question, analysis);
  if (!chosen) return std::unexpected(chosen.error());
  RemarkUnsteady(chosen->part, analysis);
  return *std::move(chosen);
}

}  // namespace haptometer::dsp
