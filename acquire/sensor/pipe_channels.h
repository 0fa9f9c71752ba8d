#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/protocol/sample_format.h"
#include "base/error.h"
#include "trial/calibration.h"
#include "trial/trial_format.h"

namespace haptometer::acquire {

/// What the columns of a pipe are.
struct PipeChannels {
  std::vector<trial::ChannelFormat> formats;
  std::vector<trial::RawLimits> limits;       ///< one a channel, of the numbers as they come
  std::map<std::string, std::string> fields;  ///< the calibration, for metadata.fields
};

/// Reads `NAME:UNIT,NAME:UNIT...`, e.g. `displacement:um,voltage:V,trigger`, by the rule for the
/// columns of a CSV (trial/import/csv_header.h: `displacement:um` is its displacement_um).
///
/// `calibration_path`: a calibration file (trial/calibration.h), or empty. A channel that it names
/// comes in volts or amperes, as the file says; its UNIT, if given, is theirs (`displacement:mV`).
/// Counts (SampleFormat::kI16) have no unit, and all but triggers and other channels need it.
/// Errors: Cause::kUsage for the text; the calibration file's.
[[nodiscard]] Result<PipeChannels> ReadPipeChannels(std::string_view text, SampleFormat format,
                                                    const std::string& calibration_path);

}  // namespace haptometer::acquire
