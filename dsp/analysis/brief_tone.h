#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "base/error.h"
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

/// The tone that stands out of some stretch of a record and is not in what has settled of
/// `reference`, the signal that would be told instead.
///
/// It is sought in the samples before the filter, so that no filter's edge can be taken for it: in
/// tiles of 0.6 s (12 to 48 periods of the lower corner) that overlap by half, rid of what is below
/// the band (dsp/analysis/raw_tile.h), of up to four tones that go on in the reference (mains hum;
/// dsp/analysis/settled_glances.h), and of up to four steps that explain more than any tone.
/// Windows of a tile, of its half, and so on to a 32nd (19 ms), overlapping by half, are asked for
/// a tone of three periods or more (dsp/spectrum/tone.h; with a false alarm of 1e-4 for the whole
/// record). Of several the one with most energy is told that
/// - goes on for 3.5 periods or more, does not swell in its middle and has 0.42 or more of what
///   power its tile has beside noise: else it is a bump, or rings about one;
/// - has 80 times the power that noise near its frequency has in the quietest eighth of up to 31
///   short windows of what has settled;
/// - is there less than 0.3 of its amplitude (and less by four deviations of the noise) within 5 %
///   of its frequency: one that goes on, or wanders, is no brief one;
/// - is in the filtered samples, where there are any, with 0.3 of its amplitude.
/// It is on for as long as it is in the tiles beside that one.
///
/// So not seen is a drive of fewer than four periods; one below 32 Hz in the default band (110 Hz
/// in 80-300 Hz, none in a band as narrow as 380-390 Hz), or so near to a record's end that the
/// polynomial takes it along (40 ms of 140 Hz in 80-300 Hz); one in a tile with a bump of more
/// energy; one that is within 5 % and one over its length of a tone that goes on.
///
/// Of more than 64 tiles of a piece those at the ends are searched, and the eight with the highest
/// power over 8 ms. Errors: as RowSource::Read. Cost: about 5 ms a tile.
[[nodiscard]] Result<std::optional<BriefTone>> FindBriefTone(std::span<const BriefSearch> searches,
                                                             const BandSignal& settled,
                                                             const BandPass& band);

}  // namespace haptometer::dsp
