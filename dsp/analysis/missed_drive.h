#pragma once

#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_filtering.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/segments.h"
#include "dsp/analysis/time_window.h"
#include "dsp/analysis/used_part.h"
#include "dsp/filter/butterworth.h"
#include "dsp/findings.h"

/// The guard against numbers of a pause: a drive that lies where nothing has settled, or is short.
namespace haptometer::dsp {

/// A drive that is on for a part of the record.
struct MissedDrive {
  const BandSignal* signal = nullptr;  ///< in which most of it has settled
  TimeWindow on;
  bool from_channel = false;
  Finding what{};  ///< kDriveOn or kVibrationStandsOut
};

/// Seeks a drive where no steady part of one was found and `chosen` is all that has settled of a
/// signal.
///
/// By the drive's channel over all rows, where it is off in `chosen`
/// (dsp/analysis/channel_parts.h). By the displacement itself, in the 64 longest segments of a
/// period of the lower corner and more, where a tone stands out that is not in what has settled of
/// the chosen signal (dsp/analysis/brief_tone.h). `all` is not empty. Errors: as RowSource::Read.
[[nodiscard]] Result<std::optional<MissedDrive>> FindMissedDrive(const Displacement& displacement,
                                                                 const Segments& segments,
                                                                 const std::vector<BandSignal>& all,
                                                                 const ChosenPart& chosen,
                                                                 const BandPass& band);

/// What has settled of it, one period of the lower corner away from where it begins and ends (also
/// at the record's ends, where it may begin and end at once), if that is as long as a window must
/// be. By a channel, which tells these times to a millisecond, down to a quarter of a period where
/// the drive is short. Quiet is what has settled two and a half periods away.
[[nodiscard]] std::optional<ChosenPart> SettledPartOf(const MissedDrive& missed,
                                                      const BandPass& band);

/// Why what has settled beside it is no answer, and what would help.
[[nodiscard]] Finding WhyMissed(const MissedDrive& missed, const BandPass& band);

}  // namespace haptometer::dsp
