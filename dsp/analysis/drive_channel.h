#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/band_analysis.h"
#include "dsp/analysis/band_signal.h"
#include "dsp/analysis/window/window_choice.h"
#include "dsp/findings.h"
#include "dsp/spectrum/electrical.h"
#include "trial/row_source.h"

/// What a recorded voltage, current or trigger says of the drive.
namespace haptometer::dsp {

/// The channel that says when the drive is on: a voltage before a current before a trigger.
[[nodiscard]] std::optional<std::size_t> DriveChannel(const trial::Record& head);

/// What a drive channel says beside the vibration of `signal`.
struct ChannelCourse {
  std::vector<TimeWindow> on;       ///< in the record's time
  std::optional<DriveDelay> delay;  ///< of the vibration; nothing where no changes correspond
};

/// The drive channel over `signal` in `band`, by its power and that of the vibration at `tone_hz`,
/// in means of a period w of the lower corner; changes that rise or fall alike within 1 s of each
/// other correspond, and the delay is their median difference.
///
/// Changes are placed by RefinedEdges (dsp/spectrum/power_edges.h): the phase at which a tone of f
/// is switched is unknown, u = 1 / (4 pi f sqrt(2)), and noise adds to it. The same filter delays
/// no change of a voltage or current within the band against the vibration's; those of another
/// channel by (1/d1 + 1/d2) / (4 pi^2) at most, d the tone's distances to the corners. The median
/// of n > 2 has pi / 2 times the variance of a mean; differences that scatter by more than 95 % of
/// chi-squared give their own scatter (Birge). Errors: as RowSource::Read.
[[nodiscard]] Result<ChannelCourse> FollowChannel(const trial::RowSource& source,
                                                  std::size_t channel, const BandSignal& signal,
                                                  const BandPass& band, double tone_hz);

/// Follows the drive channel, where there is one, beside the part that `chosen` is of: sets its
/// delay, and cuts it (where `may_cut`) to the time in which the channel, so much later, is on, if
/// that is half of it or more. Adds to `analysis` a note of a delay beyond 50 ms, and a doubt where
/// the channel is off for more than a period of the lower corner. Errors: as RowSource::Read.
[[nodiscard]] Result<void> FollowDrive(const trial::RowSource& source, bool may_cut,
                                       ChosenPart& chosen, BandAnalysis* analysis);

/// The onset of the part that `chosen` is of, of unfiltered samples (a zero-phase filter rings
/// ahead of it) from at most 1 s of the quiet part before it to at most 1 s of its steady part.
///
/// Nothing where no quiet part lies before it, or FindOnset determines none. Errors: as
/// RowSource::Read. Cost: DemodulateTone of 2 s and what lies between.
[[nodiscard]] Result<std::optional<OnsetNumbers>> FindDriveOnset(const trial::RowSource& source,
                                                                 const ChosenPart& chosen,
                                                                 double tone_hz);

/// What a drive did, or why that is not determined.
struct ElectricalFinding {
  std::optional<ElectricalState> state;
  std::optional<Finding> why_not{};  ///< nothing where `state` is there or nothing was recorded
};

/// The electrical state at `tone_hz` over `rows` rows from `first_row` on, or their middle
/// kMostFitted, where the record has a voltage in V and a current in A. Errors: as RowSource::Read.
[[nodiscard]] Result<ElectricalFinding> MeasureElectrical(const trial::RowSource& source,
                                                          std::size_t first_row, std::size_t rows,
                                                          double rate_hz, double tone_hz);

}  // namespace haptometer::dsp
