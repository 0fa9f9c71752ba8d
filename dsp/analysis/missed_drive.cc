#include "dsp/analysis/missed_drive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/brief_tone.h"
#include "dsp/analysis/channel_parts.h"
#include "dsp/analysis/drive_part.h"

namespace haptometer::dsp {
namespace {

constexpr double kQuietBlocks = 2.5;  // periods of the lower corner that a filter rings for
// periods of the lower corner, behind a channel's begin and before its end
constexpr double kLeastGuard = 0.25;
constexpr double kLeastInside = 1.02;     // of the shortest window: cells cut at its ends
constexpr double kLeastPiecePeriods = 1;  // of the lower corner, of a piece that is searched
constexpr std::size_t kMostPieces = 64;

// seconds of a window that are free of transients in a signal
double SettledSecondsIn(const BandSignal& signal, const TimeWindow& window) {
  const auto [begin, end] = SettledWithin(signal, window);
  return static_cast<double>(end - begin) / signal.rate_hz();
}

// a drive, in the signal with most of it free of transients
MissedDrive MissedIn(const std::vector<BandSignal>& all, const TimeWindow& on) {
  const BandSignal& signal = *std::ranges::max_element(
      all, {}, [&](const BandSignal& one) { return SettledSecondsIn(one, on); });
  return {&signal, on, false, {}};
}

// of the drive's parts by its channel the one with most free of transients, else the longest
Result<std::optional<MissedDrive>> MissedByChannel(const trial::RowSource& source,
                                                   const std::vector<BandSignal>& all,
                                                   const ChosenPart& chosen, const BandPass& band) {
  const TimeWindow used{TimeOfSample(*chosen.signal, chosen.begin),
                        TimeOfSample(*chosen.signal, chosen.end)};
  const auto parts = FindChannelParts(source, band, used);
  if (!parts) return std::unexpected(parts.error());
  std::optional<MissedDrive> missed;
  // order: seconds free of transients, then length
  const auto size = [](const MissedDrive& one) {
    return std::pair{SettledSecondsIn(*one.signal, one.on), one.on.duration_s()};
  };
  for (const TimeWindow& part : *parts) {
    const MissedDrive one = MissedIn(all, part);
    if (!missed || size(one) > size(*missed)) missed = one;
  }
  if (!missed) return missed;
  missed->from_channel = true;
  missed->what = {.kind = FindingKind::kDriveOn,
                  .numbers = {{"from_s", missed->on.begin_s}, {"to_s", missed->on.end_s}}};
  return missed;
}

// the longest pieces of the record with a sufficient rate, filtered or too short for it
std::vector<BriefSearch> PiecesOf(const Displacement& displacement, const Segments& segments,
                                  const std::vector<BandSignal>& all, const BandPass& band) {
  std::vector<BriefSearch> pieces;
  for (const Segment& segment : segments.parts) {
    const double duration_s = static_cast<double>(segment.size) / segment.rate_hz;
    if (segment.rate_hz < kLeastRatePerUpperCorner * band.upper_hz) continue;
    if (duration_s < kLeastPiecePeriods / band.lower_hz) continue;
    const auto filtered = std::ranges::find(all, segment.first_row, &BandSignal::first_row);
    pieces.push_back({{displacement.source, displacement.channel, segment},
                      filtered == all.end() ? nullptr : &*filtered});
  }
  const std::size_t kept = std::min(kMostPieces, pieces.size());
  std::ranges::partial_sort(pieces, pieces.begin() + static_cast<std::ptrdiff_t>(kept),
                            std::ranges::greater{},
                            [](const BriefSearch& piece) { return piece.samples.size(); });
  pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(kept), pieces.end());
  return pieces;
}

// Away from the drive's begin and end. A channel gives these to a millisecond: a short drive keeps
// as much as a window needs of the part free of transients, and loses more behind its begin, where
// the vibration rises.
TimeWindow InsideOf(const MissedDrive& missed, double block_s) {
  const BandSignal& signal = *missed.signal;
  const TimeWindow& on = missed.on;
  const double least_s = kLeastInside * kLeastWindowPeriods * block_s;
  const double guard_s = (missed.from_channel ? kLeastGuard : 1) * block_s;
  // the begin moves first, then the end, each by at least the guard and at most one block
  const double latest_s = std::min(on.end_s - guard_s, TimeOfSample(signal, signal.settled_end()));
  const double begin_s = on.begin_s + std::clamp(latest_s - least_s - on.begin_s, guard_s, block_s);
  const double earliest_s = std::max(begin_s, TimeOfSample(signal, signal.settled_begin()));
  const double end_s = on.end_s - std::clamp(on.end_s - least_s - earliest_s, guard_s, block_s);
  return {begin_s, std::max(begin_s, end_s)};
}

// parts beside the drive that are free of transients, each at least `least_s` long
std::vector<TimeWindow> QuietBeside(const MissedDrive& missed, double guard_s, double least_s) {
  const BandSignal& signal = *missed.signal;
  const TimeWindow before{TimeOfSample(signal, signal.settled_begin()),
                          missed.on.begin_s - guard_s};
  const TimeWindow after{missed.on.end_s + guard_s, TimeOfSample(signal, signal.settled_end())};
  std::vector<TimeWindow> quiet;
  for (const TimeWindow& part : {before, after}) {
    if (part.duration_s() >= least_s) quiet.push_back(part);
  }
  return quiet;
}

}  // namespace

Result<std::optional<MissedDrive>> FindMissedDrive(const Displacement& displacement,
                                                   const Segments& segments,
                                                   const std::vector<BandSignal>& all,
                                                   const ChosenPart& chosen, const BandPass& band) {
  // the channel decides before the displacement, whose search costs more
  auto by_channel = MissedByChannel(displacement.source, all, chosen, band);
  if (!by_channel || *by_channel) return by_channel;
  const std::vector<BriefSearch> pieces = PiecesOf(displacement, segments, all, band);
  const auto tone = FindBriefTone(pieces, *chosen.signal, band);
  if (!tone) return std::unexpected(tone.error());
  if (!*tone) return std::nullopt;
  MissedDrive missed = MissedIn(all, (*tone)->window);
  missed.what = {.kind = FindingKind::kVibrationStandsOut,
                 .numbers = {{"frequency_hz", (*tone)->frequency_hz},
                             {"rms_m", (*tone)->rms_m},
                             {"from_s", missed.on.begin_s},
                             {"to_s", missed.on.end_s}}};
  return missed;
}

std::optional<ChosenPart> SettledPartOf(const MissedDrive& missed, const BandPass& band) {
  const double block_s = 1 / band.lower_hz;
  const BandSignal& signal = *missed.signal;
  const TimeWindow inside = InsideOf(missed, block_s);
  const auto [begin, end] = SettledWithin(signal, inside);
  const double settled_s = static_cast<double>(end - begin) / signal.rate_hz();
  if (settled_s < kLeastWindowPeriods / band.lower_hz) return std::nullopt;
  ChosenPart chosen{&signal, begin, end, {}};
  OnPart on;
  on.whole = missed.on;
  on.steady = {TimeOfSample(signal, begin), TimeOfSample(signal, end)};
  on.is_steady = true;
  chosen.part.drive = {DriveCourse::kGated, {on}, {}, missed.what};
  chosen.part.drive.quiet = QuietBeside(missed, kQuietBlocks * block_s, block_s);
  chosen.part.from_drive = true;
  chosen.part.from_channel = missed.from_channel;
  chosen.part.why.kind = FindingKind::kSettledOfDrive;
  return chosen;
}

Finding WhyMissed(const MissedDrive& missed, const BandPass& band) {
  using enum FindingKind;
  const auto [begin, end] = SettledWithin(*missed.signal, missed.on);
  const double settled_s = SettledSecondsIn(*missed.signal, missed.on);
  // a window, and the guards that InsideOf removes
  const double guards = missed.from_channel ? 2 * kLeastGuard : 2;
  const double least_s = (kLeastWindowPeriods + guards) / band.lower_hz;
  const bool is_short = missed.on.duration_s() < least_s;
  Finding found = missed.what;
  found.severity = Severity::kRefusal;
  found.kind = missed.from_channel ? (is_short ? kDriveTooShort : kDriveNotSettled)
                                   : (is_short ? kVibrationTooShort : kVibrationNotSettled);
  found.numbers.emplace_back("settled_s", settled_s);
  if (is_short) found.numbers.emplace_back("needed_s", least_s);
  // a window that can be given instead
  if (settled_s >= kLeastWindowPeriods / band.lower_hz) {
    found.numbers.emplace_back("window_from_s", TimeOfSample(*missed.signal, begin));
    found.numbers.emplace_back("window_to_s", TimeOfSample(*missed.signal, end));
  }
  return found;
}

}  // namespace haptometer::dsp
