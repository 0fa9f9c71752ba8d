#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/error.h"
#include "fit/drop_test/disturbances.h"
#include "fit/drop_test/impulse_record.h"
#include "fit/drop_test/ring_start.h"
#include "fit/poles.h"

namespace haptometer::fit {

/// A drop ready to be fitted: samples at the converter's rails taken out, the ring-down found, the
/// part of it chosen that later blows and the quantised tail leave.
struct PreparedRecord {
  /// NaN at the rails; no height where the part follows a later blow, where nothing quiet precedes
  /// the blow, or where the blow lasts too long for RingStart to find its length.
  ImpulseRecord record;
  RingStart start;  ///< of the part
  Disturbances part;
  double step_v = 0;  ///< of the converter, before any averaging (ConverterStep)
  /// Of one sample before averaging, from its third differences; 0: the record is not averaged.
  double averaged_noise_v = 0;
};

/// Prepares a record. What was found and done is in `part.found`.
///
/// Where the whole record gives none and no height or current is stated, a fast oscillation that
/// sets in behind something slow (a pull and its release) is tried by itself: `record` is then what
/// follows its onset.
/// Errors (Cause::kCannotAnswer): see FindRingStart; and what is no ring-down (ring_evidence.h).
[[nodiscard]] Result<PreparedRecord> PrepareRecord(const ImpulseRecord& record);

/// The drops of a record that holds several, each with the quiet part before it; else the record.
///
/// A further drop begins where the amplitude at the strongest frequency, fallen below a tenth of
/// its largest for a period, rises beyond three tenths, and by five deviations of the noise above
/// that tenth; slow courses and hum are taken off first (first_look.h). What follows a blow sooner
/// is a second impact of the same drop (disturbances.h). Pieces are named "FILE, drop 2". A stated
/// drop height is that of the first drop: whether the others fell as far, nobody knows. Nothing is
/// split where a piece would hold fewer than 6 periods.
[[nodiscard]] std::vector<ImpulseRecord> SplitDrops(const ImpulseRecord& record);

/// A record as means of blocks of equal length.
struct ThinnedRecord {
  ImpulseRecord record;     ///< its samples stand in the blocks' middles
  std::size_t block = 0;    ///< samples a block
  std::size_t clipped = 0;  ///< samples at the recorder's limits; their blocks are NaN
};

/// Thins a record that is sampled more finely than a fit has use for: of more than 100 000 samples,
/// to 1000 or a little more a period of `poles`. Absent: the record is not so fine.
///
/// A mean over a block leaves the poles as they are and takes (pi/1000)^2/6 = 1.6e-6 of the
/// amplitude, by which Km from a drop height is too small; noise that is white loses nothing.
/// Cost: 1 ns a sample.
[[nodiscard]] std::optional<ThinnedRecord> Thinned(const ImpulseRecord& record,
                                                   const PolePair& poles);

/// A drop that holds no ring-down that can be fitted.
struct LeftOutDrop {
  ImpulseRecord record;
  Error why;
};

/// The drops of a recording, ready to be fitted.
struct PreparedDrops {
  std::vector<ImpulseRecord> records;    ///< as means where they are long
  std::vector<PreparedRecord> prepared;  ///< one of each
  std::vector<LeftOutDrop> left_out;
  std::size_t drops = 0;  ///< in the recording, all together
  Findings findings;      ///< that it was divided, averaged, or not used
};

/// Divides a recording (SplitDrops), prepares each drop, and thins it (Thinned). Where most drops
/// of one recording cannot be fitted, the others are likely none either, and none is used.
[[nodiscard]] PreparedDrops PrepareDrops(const ImpulseRecord& recording);

}  // namespace haptometer::fit
