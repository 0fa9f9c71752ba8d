#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "acquire/recorder/recorder.h"
#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "trial/record.h"

namespace haptometer::tools {

/// What a trial recording of some seconds says of a sensor; what it cannot say is empty.
struct CheckFindings {
  acquire::RecordingSummary summary{};
  std::size_t measured = 0;  ///< rows with a measurement of the first displacement channel
  double duration_s = 0;
  double fresh_rate_hz = 0;         ///< new readings a second: without those handed out again
  std::optional<double> level_m{};  ///< mean
  std::optional<double> least_m{};
  std::optional<double> greatest_m{};
  double resolution_m = 0;          ///< one step; 0 where unknown
  std::size_t longest_hold = 0;     ///< most measurements in a row with one value
  double time_uncertainty_s = 0;    ///< of a reading; the largest of all stretches
  std::optional<double> noise_m{};  ///< RMS in the band without its strongest tone
  std::optional<double> tone_hz{};  ///< the strongest in the band, where one stands out
  std::optional<double> tone_rms_m{};
  std::string no_noise_because{};  ///< why noise_m is empty
};

/// Works them out. `record` has a displacement channel in metres. Cost: that of AnalyzeBand.
[[nodiscard]] CheckFindings FindingsOf(const trial::Record& record,
                                       const acquire::RecordingSummary& summary,
                                       const dsp::BandPass& band);

}  // namespace haptometer::tools
