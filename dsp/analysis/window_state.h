#pragma once

#include <optional>

#include "base/error.h"
#include "dsp/analysis/window_choice.h"
#include "dsp/findings.h"
#include "dsp/spectrum/electrical.h"
#include "dsp/spectrum/kinematics.h"
#include "trial/row_source.h"

/// What a window says besides its vibration's size: how fast it moves, and what drives it.
namespace haptometer::dsp {

/// Velocity and acceleration of filtered samples [begin, end), or of the FittedOf(end - begin) in
/// their middle, with the settled samples beside them; `begin` and `end` of the result are rows of
/// the record. Nothing where no differentiator reaches `upper_hz`. Errors: as RowSource::Read.
[[nodiscard]] Result<std::optional<Kinematics>> MeasureKinematics(const BandSignal& signal,
                                                                  std::size_t begin,
                                                                  std::size_t end, double upper_hz);

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
