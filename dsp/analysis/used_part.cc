#include "dsp/analysis/used_part.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/frequency_move.h"
#include "dsp/analysis/missed_drive.h"
#include "dsp/spectrum/tone.h"

namespace haptometer::dsp {
namespace {

constexpr double kRingingLeft = 1e-3;  // of an amplitude, where it counts as over
constexpr double kLeastBulge = 2;      // of a transient
// in power, for a channel that is either on or off: least ratio of on to off, as that of a level in
// FindDriveParts
constexpr double kLeastLouder = 1.3;
// of its mean, that three quarters of it are above; of a sine in its quarters of a half wave: 0.29
constexpr double kLeastEven = 0.1;

// whole cells free of transients of one signal, as a course of power
struct SettledCells {
  std::size_t begin = 0;  // cells
  std::size_t end = 0;
  std::vector<double> mean_square;
  PowerCourse course;
};

SettledCells CellsOf(const BandSignal& signal) {
  const std::size_t cell = signal.cell_samples();
  SettledCells cells;
  cells.begin = (signal.settled_begin() + cell - 1) / cell;
  cells.end = std::max(cells.begin, signal.settled_end() / cell);
  cells.mean_square.reserve(cells.end - cells.begin);
  for (std::size_t k = cells.begin; k < cells.end; ++k) {
    // mean squares over cells from the sums of squares that filtering left
    cells.mean_square.push_back(signal.cells()[k].square_sum / static_cast<double>(cell));
  }
  cells.course = {cells.mean_square, TimeOfSample(signal, cells.begin * cell),
                  static_cast<double>(cell) / signal.rate_hz()};
  return cells;
}

// complex amplitude (m) of a tone in each block free of transients
Result<std::vector<std::complex<double>>> ToneBlocks(const BandSignal& signal,
                                                     const SettledCells& cells,
                                                     const DriveSearch& search,
                                                     double frequency_hz) {
  // the same blocks as those of the power, so that both courses agree in time
  const auto size = static_cast<std::size_t>(
      std::lround(DriveBlockSeconds(cells.course, search) * signal.rate_hz()));
  const std::size_t first = cells.begin * signal.cell_samples();
  const std::size_t count = (cells.end - cells.begin) * signal.cell_samples() / size;
  std::vector<double> samples(count * size);
  if (auto read = signal.Read(first, samples); !read) return std::unexpected(read.error());
  std::vector<std::complex<double>> blocks(count);
  const double turn = 2 * std::numbers::pi * frequency_hz / signal.rate_hz();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    // 2 / size times the sum of x exp(-j w t): the tone's amplitude and phase in the block
    blocks[k / size] +=
        std::polar(2 * samples[k] / static_cast<double>(size), -turn * static_cast<double>(k));
  }
  return blocks;
}

// parts by the strongest tone; unchanging where there is none, or too much to hold in memory
Result<DriveParts> ToneParts(const BandSignal& signal, const SettledCells& cells,
                             const BandPass& band, const DriveSearch& search) {
  const std::size_t size = signal.settled_end() - signal.settled_begin();
  if (size > kMostFitted) return DriveParts{};
  const auto samples = ReadMiddle(signal, signal.settled_begin(), signal.settled_end());
  if (!samples) return std::unexpected(samples.error());
  const auto tone = StrongestTone(
      *samples, {signal.rate_hz(), band.lower_hz, band.upper_hz, search.bandwidth_hz});
  if (!tone) return DriveParts{};
  const auto blocks = ToneBlocks(signal, cells, search, tone->frequency_hz);
  if (!blocks) return std::unexpected(blocks.error());
  return FindDriveParts(*blocks, cells.course, search);
}

// how a signal's parts were found
struct FoundParts {
  DriveParts parts;
  bool from_channel = false;
  std::optional<Finding> finding{};  // what the reader must know of it
};

// Excludes parts that are no longer than the filter rings on both sides of an event and whose power
// rises and falls as ringing does: the residue of a switched tone outside of the band.
void LeaveOutTransients(const BandSignal& signal, FoundParts& found) {
  // both passes ring: twice the time in which the slowest pole decays to 1e-3
  const double ringing_s = -2 * std::log(kRingingLeft) / SlowestDecayPerS(signal.design());
  const std::size_t left_out = std::erase_if(found.parts.on, [&](const OnPart& part) {
    return part.whole.duration_s() <= ringing_s && part.bulge >= kLeastBulge;
  });
  if (left_out == 0) return;
  found.finding = {.kind = FindingKind::kTransientsExcluded,
                   .numbers = {{"parts", left_out}, {"ringing_s", ringing_s}}};
  // without any other part the record has no drive
  if (!found.parts.on.empty()) return;
  found.parts.course = DriveCourse::kUnchanging;
  found.parts.quiet.clear();
  found.parts.why = {.kind = FindingKind::kOnlyTransients};
}

// powers of the cells in some windows
std::vector<double> PowersIn(const PowerCourse& response, std::span<const TimeWindow> windows) {
  const auto cell_at = [&](double time_s) {
    const double cell = std::round((time_s - response.start_s) / response.cell_s);
    return static_cast<std::size_t>(
        std::clamp(cell, 0.0, static_cast<double>(response.mean_square.size())));
  };
  std::vector<double> powers;
  for (const TimeWindow& window : windows) {
    const std::size_t end = cell_at(window.end_s);
    for (std::size_t k = cell_at(window.begin_s); k < end; ++k) {
      powers.push_back(response.mean_square[k]);
    }
  }
  return powers;
}

// the lower quartile of some powers
double LowOf(std::vector<double> powers) {
  const auto low = powers.begin() + static_cast<std::ptrdiff_t>(powers.size() / 4);
  std::ranges::nth_element(powers, low);
  return *low;
}

// whether the displacement has more power in nearly all of what a channel states as on than where
// it is off, and not only in a short drive within that part and the ringing about it
bool IsLouderOn(const DriveParts& parts, const PowerCourse& response) {
  const OnPart* on = parts.Longest();
  if (on == nullptr) return false;
  std::vector<double> powers = PowersIn(response, std::span(&on->whole, 1));
  std::vector<double> quiet = PowersIn(response, parts.quiet);
  if (powers.empty() || quiet.empty()) return false;
  const double mean =
      std::accumulate(powers.begin(), powers.end(), 0.0) / static_cast<double>(powers.size());
  const double low = LowOf(std::move(powers));
  return low > kLeastLouder * LowOf(std::move(quiet)) && low > kLeastEven * mean;
}

// by the drive's channel if there is one, else by the tone, else by the power; none in a sweep,
// whose resonance has a course like a drive
Result<FoundParts> PartsOf(const trial::RowSource& source, const BandSignal& signal,
                           const BandPass& band) {
  const SettledCells cells = CellsOf(signal);
  const DriveSearch search{band.lower_hz, band.upper_hz - band.lower_hz};
  // a channel with values decides; one of a few steps counts only if the displacement agrees
  const auto channel = DriveChannel(source.head());
  if (channel && cells.end > cells.begin) {
    const auto drive = DriveCells(source, *channel, signal, cells.begin, cells.end);
    if (!drive) return std::unexpected(drive.error());
    DriveParts parts = FindDriveParts(
        {drive->mean_square, cells.course.start_s, cells.course.cell_s}, cells.course, search);
    const bool is_drive = !drive->is_coarse || IsLouderOn(parts, cells.course);
    if (parts.course == DriveCourse::kGated && is_drive) {
      return FoundParts{std::move(parts), true};
    }
  }
  // a tone's pauses are found far below the noise; its power decides only without them
  auto by_tone = ToneParts(signal, cells, band, search);
  if (!by_tone) return std::unexpected(by_tone.error());
  const bool pauses = by_tone->course == DriveCourse::kGated;
  DriveParts by_power = pauses ? DriveParts{} : FindDriveParts(cells.course, search);
  // a sweep through a resonance rises and falls as a drive does
  if (pauses || by_power.course == DriveCourse::kGated) {
    const auto move = FindFrequencyMove(signal, signal.settled_begin(), signal.settled_end(), band);
    if (!move) return std::unexpected(move.error());
    if (*move) {
      FoundParts none;
      none.parts.why = {.kind = FindingKind::kSweepIsNoDrive};
      return none;
    }
  }
  if (pauses) return FoundParts{std::move(*by_tone), false};
  // the power changes but the tone never pauses: its level changes, the drive is not off
  if (by_power.course == DriveCourse::kGated && by_tone->why) {
    return FoundParts{std::move(*by_tone), false, Finding{.kind = FindingKind::kLevelChanges}};
  }
  FoundParts found{std::move(by_power), false};
  LeaveOutTransients(signal, found);
  return found;
}

// finds the drive beside a window that was given, and adds a doubt where the window holds more
// than its steady part
Result<void> RemarkMixed(const trial::RowSource& source, const BandPass& band, ChosenPart& chosen,
                         BandAnalysis* analysis) {
  const BandSignal& signal = *chosen.signal;
  auto found = PartsOf(source, signal, band);
  if (!found) return std::unexpected(found.error());
  const DriveParts& parts = chosen.part.drive = std::move(found->parts);
  const TimeWindow window{TimeOfSample(signal, chosen.begin), TimeOfSample(signal, chosen.end)};
  const auto shared_s = [&](const TimeWindow& other) {
    return std::max(0.0,
                    std::min(window.end_s, other.end_s) - std::max(window.begin_s, other.begin_s));
  };
  double on_s = 0;
  double steady_s = 0;
  for (const OnPart& part : parts.on) {
    on_s += shared_s(part.whole);
    steady_s += shared_s(part.steady);
  }
  // up to one period of the lower corner outside of the steady part is not a mixture
  const double rest_s = window.duration_s() - steady_s;
  if (parts.on.empty() || rest_s <= 1 / band.lower_hz) return {};
  if (on_s > 0) {
    analysis->findings.Doubt(FindingKind::kWindowMixed,
                             {{"off_s", rest_s}, {"window_s", window.duration_s()}});
  } else {
    analysis->findings.Doubt(FindingKind::kDriveOffInWindow);
  }
  return {};
}

// adds a doubt where the tone of the chosen part moves
Result<void> RemarkMove(const ChosenPart& chosen, const BandPass& band, BandAnalysis* analysis) {
  const auto move = FindFrequencyMove(*chosen.signal, chosen.begin, chosen.end, band);
  if (!move) return std::unexpected(move.error());
  analysis->frequency_move = *move;
  if (!*move) return {};
  analysis->findings.Doubt(FindingKind::kFrequencyMoves,
                           {{"from_hz", (*move)->from_hz}, {"to_hz", (*move)->to_hz}});
  return {};
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

// the longest steady part of a drive over all signals; without one all samples free of transients
Result<ChosenPart> ChooseDriven(const trial::RowSource& source, const std::vector<BandSignal>& all,
                                const BandQuestion& question, BandAnalysis* analysis) {
  ChosenPart undriven = AllSettled(LongestSettled(all));
  std::optional<ChosenPart> best;
  for (const BandSignal& signal : all) {
    auto found = PartsOf(source, signal, question.band);
    if (!found) return std::unexpected(found.error());
    if (found->finding) analysis->findings.Add(*found->finding);
    // parts of the signal that is used without a drive are reported too
    if (&signal == undriven.signal) undriven.part.drive = found->parts;
    const OnPart* on = found->parts.Longest();
    if (on == nullptr) continue;
    const auto [begin, end] = SettledWithin(signal, on->steady);
    if (static_cast<double>(end - begin) / signal.rate_hz() <
        kLeastWindowPeriods / question.band.lower_hz) {
      continue;
    }
    if (best && end - begin <= best->end - best->begin) continue;
    best = ChosenPart{&signal, begin, end, {}};
    best->part.why.kind = FindingKind::kSteadyDrive;
    best->part.from_drive = true;
    best->part.from_channel = found->from_channel;
    best->part.drive = std::move(found->parts);
  }
  return best ? *std::move(best) : std::move(undriven);
}

// The chosen part in which no drive was found, if there is none elsewhere: else the part free of
// transients of that drive, or a refusal and nothing.
Result<std::optional<ChosenPart>> WithoutMissed(const Displacement& displacement,
                                                const Segments& segments,
                                                const std::vector<BandSignal>& all,
                                                ChosenPart chosen, const BandPass& band,
                                                BandAnalysis* analysis) {
  const auto missed = FindMissedDrive(displacement, segments, all, chosen, band);
  if (!missed) return std::unexpected(missed.error());
  if (!*missed) return chosen;
  auto part = SettledPartOf(**missed, band);
  if (!part) analysis->findings.Add(WhyMissed(**missed, band));
  return part;
}

void RemarkUnsteady(const DriveParts& drive, BandAnalysis* analysis) {
  const OnPart& on = *drive.Longest();
  if (on.is_steady) return;
  analysis->findings.Doubt(FindingKind::kDriveUnsteady, {{"drift", on.drift}});
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

Result<std::optional<ChosenPart>> ChoosePart(const Displacement& displacement,
                                             const Segments& segments,
                                             const std::vector<BandSignal>& all,
                                             const BandQuestion& question, BandAnalysis* analysis) {
  std::optional<ChosenPart> chosen;
  if (question.choice == WindowChoice::kGiven) {
    chosen = ChooseGiven(all, question, analysis);
    if (!chosen) return chosen;
  }
  if (question.choice == WindowChoice::kAuto) {
    auto driven = ChooseDriven(displacement.source, all, question, analysis);
    if (!driven) return std::unexpected(driven.error());
    chosen = *std::move(driven);
  }
  // without a given or a driven window
  if (!chosen) chosen = AllSettled(LongestSettled(all));
  if (question.choice != WindowChoice::kAuto) {
    if (auto said = RemarkMixed(displacement.source, question.band, *chosen, analysis); !said) {
      return std::unexpected(said.error());
    }
  }
  if (auto said = RemarkMove(*chosen, question.band, analysis); !said) {
    return std::unexpected(said.error());
  }
  if (analysis->frequency_move && chosen->part.from_drive && !chosen->part.from_channel) {
    // a sweep that leaves the band or its resonance: beside it the drive is not off
    chosen->part = {};
    chosen->part.drive.why = {.kind = FindingKind::kSweepIsNoDrive};
    chosen->part.why.kind = FindingKind::kWhereFrequencyMoves;
  }
  // without a drive in it the chosen part may be a pause of one that is elsewhere
  if (chosen->part.from_drive) {
    RemarkUnsteady(chosen->part.drive, analysis);
  } else if (question.choice == WindowChoice::kAuto && !analysis->frequency_move) {
    return WithoutMissed(displacement, segments, all, *std::move(chosen), question.band, analysis);
  }
  return chosen;
}

}  // namespace haptometer::dsp
