#include "dsp/analysis/missed_drive.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/brief_tone.h"
#include "dsp/analysis/drive_channel.h"
#include "dsp/analysis/drive_part.h"

namespace haptometer::dsp {
namespace {

constexpr double kLeastBriefS = 0.015;
constexpr double kBriefStandsOut = 100;  // in power, of the median
constexpr double kBriefOn = 0.1;         // of the greatest power
constexpr double kQuietBlocks = 2.5;     // periods of the lower corner that a filter rings for

// the stretch about the greatest cell in which power stays above a tenth of it, gaps of `gap_s`
// left in; nothing where it is on for less than half of that, or of kLeastBriefS
std::optional<TimeWindow> BriefOn(const PowerCourse& course, double gap_s) {
  const std::span<const double> power = course.mean_square;
  if (power.empty()) return std::nullopt;
  std::vector<double> sorted(power.begin(), power.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  const auto greatest = static_cast<std::size_t>(std::ranges::max_element(power) - power.begin());
  const double top = power[greatest];
  if (!(top > kBriefStandsOut * *middle)) return std::nullopt;
  const auto gap = static_cast<std::size_t>(gap_s / course.cell_s) + 1;
  std::size_t begin = greatest;
  const auto is_on = [&](double cell) { return cell > kBriefOn * top; };
  for (std::size_t k = greatest; k-- > 0 && begin - k <= gap;) {
    if (is_on(power[k])) begin = k;
  }
  std::size_t end = greatest + 1;
  for (std::size_t k = end; k < power.size() && k - end < gap; ++k) {
    if (is_on(power[k])) end = k + 1;
  }
  // a last digit that flickers is on here and there
  const auto cells =
      static_cast<double>(std::ranges::count_if(power.subspan(begin, end - begin), is_on));
  if (2 * cells < static_cast<double>(end - begin) || cells * course.cell_s < kLeastBriefS)
    return {};
  return TimeWindow{course.start_s + static_cast<double>(begin) * course.cell_s,
                    course.start_s + static_cast<double>(end) * course.cell_s};
}

// what a channel says that the drive did over all of a signal, where it was on for a part of it
Result<std::optional<TimeWindow>> OnByChannel(const trial::RowSource& source,
                                              const BandSignal& signal, const BandPass& band) {
  const auto channel = DriveChannel(source.head());
  if (!channel) return std::nullopt;
  const std::size_t cells = signal.size() / signal.cell_samples();
  const auto drive = DriveCells(source, *channel, signal, 0, cells);
  if (!drive) return std::unexpected(drive.error());
  const double cell_s = static_cast<double>(signal.cell_samples()) / signal.rate_hz();
  const PowerCourse course{*drive, signal.start_s(), cell_s};
  const DriveParts parts =
      FindDriveParts(course, course, {band.lower_hz, band.upper_hz - band.lower_hz});
  if (parts.course == DriveCourse::kGated) return parts.Longest()->whole;
  if (source.head().channels[*channel].role == trial::ChannelRole::kTrigger) return std::nullopt;
  return BriefOn(course, 1 / band.lower_hz);
}

// away from where the drive begins and ends, unless the record does
TimeWindow Within(const MissedDrive& missed, double guard_s) {
  const BandSignal& signal = *missed.signal;
  const double begin_s = signal.start_s();
  const double end_s = TimeOfSample(signal, signal.size());
  TimeWindow inside = missed.on;
  if (inside.begin_s > begin_s + guard_s) inside.begin_s += guard_s;
  if (inside.end_s < end_s - guard_s) inside.end_s -= guard_s;
  inside.end_s = std::max(inside.begin_s, inside.end_s);
  return inside;
}

// settled parts beside the drive, each as long as `least_s`
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

Result<std::optional<MissedDrive>> FindMissedDrive(const trial::RowSource& source,
                                                   const std::vector<BandSignal>& all,
                                                   const BandSignal& used, const BandPass& band) {
  const auto on = OnByChannel(source, used, band);
  if (!on) return std::unexpected(on.error());
  if (*on) {
    return MissedDrive{
        &used, **on, true,
        fmt::format("the drive is on from {:.3f} s to {:.3f} s", (*on)->begin_s, (*on)->end_s)};
  }
  for (const BandSignal& signal : all) {
    const auto tone = FindBriefTone(signal, band);
    if (!tone) return std::unexpected(tone.error());
    if (!*tone) continue;
    return MissedDrive{
        &signal, (*tone)->window, false,
        fmt::format("a vibration of {:.3g} Hz and about {:.2g} um RMS stands out from {:.3f} s to "
                    "{:.3f} s",
                    (*tone)->frequency_hz, (*tone)->rms_m * 1e6, (*tone)->window.begin_s,
                    (*tone)->window.end_s)};
  }
  return std::nullopt;
}

std::optional<ChosenPart> SettledPartOf(const MissedDrive& missed, const BandPass& band) {
  const double block_s = 1 / band.lower_hz;
  const BandSignal& signal = *missed.signal;
  const auto [begin, end] = SettledWithin(signal, Within(missed, block_s));
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
  chosen.part.why = "what has settled of the drive: " + missed.what;
  return chosen;
}

std::string WhyMissed(const MissedDrive& missed, const BandPass& band) {
  const auto [begin, end] = SettledWithin(*missed.signal, missed.on);
  const double settled_s = static_cast<double>(end - begin) / missed.signal->rate_hz();
  const double least_s = (kLeastWindowPeriods + 2) / band.lower_hz;
  std::string text = fmt::format("{}, of which {:.3f} s have settled", missed.what, settled_s);
  text += missed.on.duration_s() < least_s
              ? fmt::format(
                    ", where {:.3g} s are needed: drive longer, or raise the band's lower "
                    "corner; ",
                    least_s)
              : ": drive longer, record longer before and after it, or take a lower --order; ";
  if (settled_s >= kLeastWindowPeriods / band.lower_hz) {
    return text + fmt::format("--window {:.3f}s:{:.3f}s takes what has settled of it",
                              TimeOfSample(*missed.signal, begin),
                              TimeOfSample(*missed.signal, end));
  }
  return text + "--window all takes what has settled beside it";
}

}  // namespace haptometer::dsp
