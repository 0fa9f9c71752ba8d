#pragma once

#include <string>

#include "base/error.h"

namespace haptometer::cli {

/// A band of frequencies, as said on the command line.
struct Band {
  double lower_hz = 0;
  double upper_hz = 0;
};

/// Reads "20-500Hz", "20Hz-0.5kHz": a lower corner without a unit takes that of the upper one.
/// Whether the two make a band is not asked. Errors (Cause::kUsage), naming --band.
[[nodiscard]] Result<Band> ParseBand(const std::string& text);

}  // namespace haptometer::cli
