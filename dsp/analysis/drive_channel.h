#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/result.h"
#include "dsp/analysis/band_signal.h"
#include "trial/record.h"
#include "trial/row_source.h"

/// What a recorded voltage, current or trigger says of the drive.
namespace haptometer::dsp {

/// The channel that says when the drive is on: a voltage, else a current, else a trigger.
[[nodiscard]] std::optional<std::size_t> DriveChannel(const trial::Record& head);

/// Mean squares of the drive in the cells [begin, end) of `signal`; a trigger counts from its
/// least. Errors: as RowSource::Read.
[[nodiscard]] Result<std::vector<double>> DriveCells(const trial::RowSource& source,
                                                     std::size_t channel, const BandSignal& signal,
                                                     std::size_t begin, std::size_t end);

}  // namespace haptometer::dsp
