#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/error.h"
#include "dsp/analysis/segments.h"
#include "dsp/findings.h"
#include "trial/row_source.h"

/// The reading step of AnalyzeSweep.
namespace haptometer::dsp {

/// What is measured: a piece of the record without holes.
struct SweepPiece {
  double start_s = 0;
  double rate_hz = 0;
  std::vector<double> displacement_m;
  std::vector<double> drive;      ///< as many samples in the channel's unit, or none
  std::size_t drive_channel = 0;  ///< its number, where `drive` is there
};

/// The longest of `segments`, 2^24 samples at most, and beside it the first voltage channel, or
/// else the first current; where that has holes, both are cut to its longest measured run. A
/// channel that does not move is no drive. Adds to `findings` what was left out. Empty where there
/// is no segment. Errors: as RowSource::Read.
[[nodiscard]] Result<SweepPiece> ReadSweepPiece(const trial::RowSource& source, std::size_t channel,
                                                const Segments& segments, Findings& findings);

}  // namespace haptometer::dsp
