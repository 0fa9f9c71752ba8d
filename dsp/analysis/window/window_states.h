#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_question.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/drive_states.h"
#include "dsp/analysis/hum.h"
#include "dsp/findings.h"

/// What the states of a drive (dsp/analysis/drive_states.h) mean for a window: which make one,
/// which are quiet beside it, which of its blocks are bumps, and what else vibrates.
namespace haptometer::dsp {

/// Samples [first, second).
using SampleRanges = std::vector<std::pair<std::size_t, std::size_t>>;

/// A logarithm of a pause that is not known: above all others.
inline constexpr double kUnknownPause = std::numeric_limits<double>::infinity();

/// One signal, its hum, its blocks and their states.
struct Course {
  const BandSignal* signal = nullptr;
  std::vector<SteadyLine> hum;
  BlockCourse blocks;
  std::vector<StateInterval> states;
};

/// A course of each signal, with the hum that is subtracted from it. Errors: as RowSource::Read.
[[nodiscard]] Result<std::vector<Course>> FindHumOf(const std::vector<BandSignal>& all,
                                                    const BandQuestion& question);

/// Blocks and states of every signal, `length` times as long as the shortest blocks, which last
/// `least_s` at least; of a short segment shorter ones, of one shorter than a window none.
[[nodiscard]] Result<void> FindStatesOf(const BandPass& band, double length, double least_s,
                                        std::vector<Course>& courses);

/// Samples of state `k`, without its outer blocks where it changes, that make a window: steady,
/// free of transients, and two periods of the lower corner or more; begin == end: none.
[[nodiscard]] std::pair<std::size_t, std::size_t> WindowOf(const Course& course, std::size_t k,
                                                           double lower_hz);

/// The strongest level of all states that make a window, m.
[[nodiscard]] double StrongestLevel(const std::vector<Course>& courses, double lower_hz);

/// Intervals without `drive`, away from everything else and from bumps: off, a steady tone far
/// below it, or a weaker one of another frequency, which may be there all the time.
[[nodiscard]] std::vector<TimeWindow> QuietOf(const Course& course, const StateInterval& drive,
                                              double lower_hz);

/// Median of the logarithms of the mean square over all blocks without `drive`; kUnknownPause where
/// there are few.
[[nodiscard]] double LogOfPauses(const Course& course, const StateInterval& drive);

/// Bumps: samples within [begin, end) of blocks of which a mean square is far above its median
/// there, or above that of a pause where it is less; of those beside them until it is near the
/// median again, and of one more, to which the filter spreads them. What is far below the drive's
/// level does not count.
[[nodiscard]] SampleRanges BumpsIn(const Course& course, double DriveBlock::* mean_square,
                                   double level_m, std::size_t begin, std::size_t end,
                                   double of_pause = kUnknownPause);

/// Whether most of the time that a window of `drive` stands for is twice as strong, and never
/// steady: then the window is no answer.
[[nodiscard]] bool IsPassedOver(const StateInterval& drive, const std::vector<Course>& courses);

/// Vibration that a window of `drive` in `of` is not of: a doubt where what is stronger lasts eight
/// blocks, or where what goes up and down with the drive lasts longer than it; a note where a
/// steady level below `least_m` does. Nothing else.
[[nodiscard]] std::optional<Finding> OtherVibration(const StateInterval& drive, const Course& of,
                                                    const std::vector<Course>& courses,
                                                    double least_m, double lower_hz);

/// Samples of all ranges.
[[nodiscard]] std::size_t SizeOf(const SampleRanges& ranges);

/// Samples of `window` in `signal`'s count, within what is free of transients; begin == end: none.
[[nodiscard]] std::pair<std::size_t, std::size_t> SettledWithin(const BandSignal& signal,
                                                                const TimeWindow& window);

/// The record's time of sample `sample`.
[[nodiscard]] double TimeOfSample(const BandSignal& signal, std::size_t sample);

}  // namespace haptometer::dsp
