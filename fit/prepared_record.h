#pragma once

#include "base/error.h"
#include "fit/disturbances.h"
#include "fit/impulse_record.h"
#include "fit/ring_start.h"

namespace haptometer::fit {

/// A drop ready to be fitted: samples at the converter's rails taken out, the ring-down found, the
/// part of it chosen that later blows and the quantised tail leave.
struct PreparedRecord {
  ImpulseRecord record;  ///< NaN at the rails; no height where the part follows a later blow
  RingStart start;       ///< of the part
  Disturbances part;
};

/// Prepares a record. What was found and done is in `part.found`.
///
/// Where the whole record gives none and no height or current is stated, a fast oscillation that
/// sets in behind something slow (a pull and its release) is tried by itself: `record` is then what
/// follows its onset.
/// Errors (Cause::kCannotAnswer): see FindRingStart; and what is no ring-down (ring_evidence.h).
[[nodiscard]] Result<PreparedRecord> PrepareRecord(const ImpulseRecord& record);

}  // namespace haptometer::fit
