#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "acquire/recorder/recorder.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "dsp/filter/butterworth.h"
#include "tools/acquire/check_list.h"
#include "tools/acquire/recording.h"
#include "tools/document/document.h"
#include "trial/record.h"
#include "trial/trial_format.h"

namespace haptometer::tools {

/// acquire --check: records `sensor` (started) for 10 s or the asked duration in memory and prints
/// the list of what is ok and what to fix (check_list.h), with remedies that build on the command
/// line. Returns the program's exit status: 0 ready, 3 not.
[[nodiscard]] int RunSensorCheck(const AcquireOptions& wanted, const dsp::BandPass& band, int argc,
                                 const char* const* argv, acquire::Sensor& sensor, Clock& clock);

/// A recording that was never on a disk.
struct MemoryTrial {
  acquire::RecordingSummary summary;
  trial::Record record;
};

/// Runs `sensor` (started) into a trial in memory and reads it back as any trial is read, so that
/// its time base is that of a recording. Memory: some 20 bytes a reading, twice.
[[nodiscard]] Result<MemoryTrial> RecordInMemory(acquire::Sensor& sensor, Clock& clock,
                                                 const std::atomic<bool>& stop,
                                                 const acquire::RecordingLimits& limits);

/// The list with what it is made from.
[[nodiscard]] document::Document CheckDocument(const trial::TrialHeader& header,
                                               const CheckFindings& findings,
                                               const CheckQuestion& question,
                                               const std::vector<CheckItem>& items);

/// The mean of the first displacement channel over the second before the recording, in m; values
/// that are no measurements do not count. The counts of a recording are not touched by it.
///
/// `sensor` is started and has not begun; it is left where Sensor::Begin may be called again, with
/// nothing outstanding. Of a uniform source the second is its own (rate_hz rows, whenever they
/// come, waited for up to 3 s each), of others the clock's, and 3 s where measurements are missing.
/// Returns early when `stop` is set. `name` stands in errors (Cause::kCannotAnswer: no such
/// channel, no measurement came, the source ended or fell silent; Cause::kFailed: the connection
/// was lost, whether or not it would be waited for in a recording).
[[nodiscard]] Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock,
                                         const std::atomic<bool>& stop, const std::string& name);

}  // namespace haptometer::tools
