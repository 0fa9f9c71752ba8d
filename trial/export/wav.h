#pragma once

#include <string>

#include "base/error.h"
#include "trial/export/piece_sink.h"
#include "trial/record.h"

namespace haptometer::trial {

/// Writes `record` as a WAV of 64-bit floats (WAVE_FORMAT_IEEE_FLOAT) in SI units, one track a
/// channel, and returns in words what the numbers leave out; the same words stand in the file as
/// its comment (LIST INFO ICMT).
///
/// Each channel's mean is taken off, because a standing distance of 30 mm would bury micrometres of
/// vibration in any player; the comment gives it in full, so that sample + offset is the value
/// again within one rounding. Not kept: times, statuses, metadata.
///
/// Errors (Cause::kCannotAnswer), because a WAV has no place for what is missing and nothing is
/// invented: gaps; values that are no measurement; a rate that is no whole number of hertz to
/// within 100 ppm (what is within is stated); more than 8191 channels or 4 GiB. Those of `sink`.
/// Cost: two passes.
[[nodiscard]] Result<std::string> WriteWav(const Record& record, const PieceSink& sink);

}  // namespace haptometer::trial
