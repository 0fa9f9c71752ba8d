#pragma once

#include <vector>

#include "base/error.h"
#include "dsp/analysis/time_window.h"
#include "dsp/filter/butterworth.h"
#include "trial/row_source.h"

/// Where a drive channel is on, over all rows: also where the displacement has not settled, or is
/// not there at all.
namespace haptometer::dsp {

/// The parts of the record in which its drive channel is on, to 1 ms; none where it is not off in
/// most of `used` or in most of the record, or where all of `used` lies in one of them.
///
/// The channel's power goes through a moving mean over one period of the lower corner, which holds
/// a whole half wave of any tone in the band. Off is the lower one of its medians over the record
/// and over `used`; a part is on where the mean is eleven times that (the drive there has less than
/// 0.3 of its amplitude, as a tone that pauses in dsp/analysis/drive_part.h) and above the
/// geometric mean of off and top. Its ends are where the sum of (power - a tenth of the top) over
/// the part is most. A voltage or current must be on for 0.3 periods of the lower corner (15 ms at
/// 20 Hz), of which half at least above a tenth of the top: spikes are no drive. A trigger must
/// be on for four periods: it may be a mark of the trial's start. Nothing is found in a channel
/// that is coarse (dsp/analysis/drive_channel.h) and no trigger.
///
/// Errors: as RowSource::Read. Cost: one pass over the channel; at most 2^20 cells in memory, and
/// one for each stretch of the record.
[[nodiscard]] Result<std::vector<TimeWindow>> FindChannelParts(const trial::RowSource& source,
                                                               const BandPass& band,
                                                               const TimeWindow& used);

}  // namespace haptometer::dsp
