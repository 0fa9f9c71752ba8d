#pragma once

#include <cstddef>
#include <optional>

#include "fit/impulse_record.h"
#include "fit/poles.h"

namespace haptometer::fit {

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

}  // namespace haptometer::fit
