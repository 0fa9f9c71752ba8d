#pragma once

#include "tools/document/document.h"

/// Keys that several verbs have; each key of one verb stands where its value is added.
namespace haptometer::document {

inline constexpr Key kSkinRms{"skin_rms_m", "skin displacement (RMS)", kMetre};
inline constexpr Key kMoverPeak{"mover_peak_m", "mover travel to either side", kMetre};
inline constexpr Key kPower{"power_w", "electrical power", kWatt};
inline constexpr Key kSkinForcePeak{"skin_force_peak_n", "force on the skin, amplitude", kNewton};
inline constexpr Key kRise{"rise_s", "rise from 10 % to 90 %", kSecond};
inline constexpr Key kLatency{"latency_s", "latency to 10 %", kSecond};

}  // namespace haptometer::document
