#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/time_window.h"
#include "dsp/analysis/used_part.h"
#include "dsp/filter/butterworth.h"
#include "trial/row_source.h"

/// The guard against numbers of a pause: a drive that lies where nothing has settled, or is short.
namespace haptometer::dsp {

/// A drive that is on for a part of the record.
struct MissedDrive {
  const BandSignal* signal = nullptr;  ///< of which it is a part
  TimeWindow on;
  bool from_channel = false;
  std::string what;  ///< "the drive is on from 0.000 s to 0.300 s"
};

/// Seeks a drive where no steady part of one was found in what has settled of `used`.
///
/// By the drive's channel, where it is on for a part of the record (dsp/analysis/drive_part.h), a
/// voltage or a current also where it is on for 15 ms or more and stands out ten times in RMS of
/// what it is for most of the time; a trigger may be a mark of the trial's start. By the
/// displacement itself, of all signals, where a tone stands out of a part
/// (dsp/analysis/brief_tone.h). Errors: as RowSource::Read.
[[nodiscard]] Result<std::optional<MissedDrive>> FindMissedDrive(const trial::RowSource& source,
                                                                 const std::vector<BandSignal>& all,
                                                                 const BandSignal& used,
                                                                 const BandPass& band);

/// What has settled of it, one period of the lower corner away from where it begins and ends, if
/// that is as long as a window must be. Quiet is what has settled two and a half periods away.
[[nodiscard]] std::optional<ChosenPart> SettledPartOf(const MissedDrive& missed,
                                                      const BandPass& band);

/// Why what has settled beside it is no answer, and what would help.
[[nodiscard]] std::string WhyMissed(const MissedDrive& missed, const BandPass& band);

}  // namespace haptometer::dsp
