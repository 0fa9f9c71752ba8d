#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "base/result.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/segments.h"
#include "dsp/analysis/time_window.h"
#include "dsp/filter/butterworth.h"

/// A tone that is on for a part of a signal only, be it where its filter has not settled.
namespace haptometer::dsp {

/// A piece of a record in which a tone is sought.
struct BriefSearch {
  SegmentSamples samples;
  const BandSignal* signal = nullptr;  ///< the same, filtered; nullptr where it is too short
};

/// Where a tone is on, and what it is there.
struct BriefTone {
  TimeWindow window;  ///< to about two of its periods, in the record's time
  double frequency_hz = 0;
  double rms_m = 0;
  std::size_t search = 0;  ///< the number of the piece
};

/// The tone that stands out of some stretch of `signal` and is not in what has settled.
///
/// It is sought in the samples before the filter, so that no filter's edge can be taken for it: in
/// tiles of 12 periods of the lower corner that overlap by half, rid of what is below the band
/// (dsp/analysis/raw_tile.h), and of up to four steps that explain more than any tone. Windows of a
/// tile, of its half, and so on to a 32nd (19 ms in the default band), overlapping by half, are
/// asked for a tone of three periods or more (dsp/spectrum/tone.h; with a false alarm of 1e-4 for
/// the whole signal). Of several the one with most energy is told that
/// - goes on for 3.5 periods or more, does not swell in its middle and has 0.42 or more of what
///   power its tile has beside noise: else it is a bump, or rings about one;
/// - has 80 times the power that noise near its frequency has in the quietest eighth of up to 31
///   short windows of what has settled;
/// - is there less than 0.3 of its amplitude (and less by four deviations of the noise) within 5 %
///   of its frequency: one that goes on, or wanders, is no brief one.
///
/// So a drive of fewer than four periods, below 31 Hz in the default band, or in a tile with a
/// bump of more energy or a stronger tone that goes on (mains hum), is not seen; nor is any in a
/// tile that has too few samples to be rid of what lies below the band: below some 700 Hz in the
/// default one, and in a narrow band.
///
/// Of more than 64 tiles those at the ends are searched, and the eight with the highest power over
/// 8 ms. Errors: as RowSource::Read. Cost: about 5 ms a tile.
[[nodiscard]] Result<std::optional<BriefTone>> FindBriefTone(std::span<const BriefSearch> searches,
                                                             const BandSignal& settled,
                                                             const BandPass& band);

}  // namespace haptometer::dsp
