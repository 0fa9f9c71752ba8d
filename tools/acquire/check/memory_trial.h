#pragma once

#include <atomic>

#include "acquire/recorder/recorder.h"
#include "acquire/sensor/sensor.h"
#include "base/clock.h"
#include "base/error.h"
#include "trial/record.h"

namespace haptometer::tools {

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

}  // namespace haptometer::tools
