#pragma once

#include <cstdint>
#include <string>

#include "base/error.h"
#include "sim/sweep/sweep_points.h"

namespace haptometer::tools {

/// Whether ranges are a grid or are sampled.
enum class RangesAre : std::uint8_t { kGrid, kSampled };

/// Reads what --vary says of one key: "drive.frequency_hz=100Hz:400Hz:301", "KEY=log:1:1000:4", or
/// a list, "skin.stiffness_n_per_m=600,1200", "sensor.target=skin,case", "effects.inductance=true".
///
/// A number's unit is that of the key's name ("_hz"); other numbers are plain. A grid's range has a
/// count, one that is sampled has none. Errors (Cause::kUsage), naming --vary and the key: no '=',
/// values of another unit or with an uncertainty, an empty value, equal ends, a count below 2, a
/// logarithm of what is not above 0.
[[nodiscard]] Result<sim::SweepAxis> ReadVaryWord(const std::string& word, RangesAre ranges);

}  // namespace haptometer::tools
