#pragma once

#include <cmath>
#include <span>

#include "trial/record.h"

namespace haptometer::dsp {

/// Whether a row holds a measurement: its status says so and its value is a finite number.
[[nodiscard]] inline bool IsMeasured(double value, trial::SampleStatus status) {
  return trial::IsMeasurement(status) && std::isfinite(value);
}

/// Whether every status is kOk: the rule in a record, and told in a fraction of the time that a
/// look at each row takes.
[[nodiscard]] bool AllOk(std::span<const trial::SampleStatus> statuses);

/// Whether every value is a finite number.
[[nodiscard]] bool AllFinite(std::span<const double> values);

}  // namespace haptometer::dsp
