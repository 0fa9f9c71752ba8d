#pragma once

#include <string>
#include <vector>

#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "dsp/filter/butterworth.h"
#include "tools/acquire/options/acquire_options.h"
#include "tools/cli/options.h"

namespace haptometer::tools {

/// acquire --check: records `sensor` (started) for 10 s or the asked duration in memory and prints
/// the list of what is ok and what to fix (check_list.h). `words` is the command line, on which the
/// remedies build. Returns the program's exit status: 0 ready, 3 not.
[[nodiscard]] int RunSensorCheck(const cli::Options& options, const AcquireOptions& wanted,
                                 const dsp::BandPass& band, const std::vector<std::string>& words,
                                 acquire::Sensor& sensor, Clock& clock);

}  // namespace haptometer::tools
