#pragma once

#include <cstddef>
#include <string>

#include "base/error.h"
#include "trial/record.h"
#include "trial/sensor_head.h"

namespace haptometer::tools {

/// A recorded displacement as something that moves.
struct RecordedMotion {
  /// Straight lines between the measured rows; the first row is at 0 s. Before it the first value
  /// holds, after the last row the last one. About log2(rows) steps a call; threads may share it.
  trial::Displacement displacement;
  double duration_s = 0;     ///< from the first measured row to the last
  std::size_t left_out = 0;  ///< rows without a measurement, which the lines bridge
};

/// The displacement channel of `record`, which `where` names in errors. Memory: a time and a value
/// a row. Errors (Cause::kCannotAnswer): no displacement channel, no measured row.
[[nodiscard]] Result<RecordedMotion> MotionOf(const trial::Record& record,
                                              const std::string& where);

}  // namespace haptometer::tools
