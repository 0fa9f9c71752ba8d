#include "tools/acquire/tare.h"

#include <fmt/core.h>

#include "tools/acquire/displacement_channel.h"

namespace haptometer::tools {

using acquire::Outcome;

Result<double> MeasureTare(acquire::Sensor& sensor, Clock& clock, const std::atomic<bool>& stop,
                           const std::string& name) {
  constexpr MonotonicNs kLongestNs = 3 * kNsPerS;
  const auto channel = DisplacementChannel(sensor.header());
  if (!channel) return CannotAnswer(name, "has no displacement to tare", "leave --tare out");
  const trial::ChannelFormat format = sensor.header().channels[*channel];
  acquire::Reading reading;
  double mean = 0;
  std::size_t count = 0;
  (void)sensor.Begin();
  const MonotonicNs start_ns = clock.Now();
  while (!stop.load() && clock.Now() - start_ns < kLongestNs) {
    const Outcome outcome = sensor.Next(reading);
    if (outcome == Outcome::kGone || outcome == Outcome::kEnd) {
      return Failed(name, "the connection was lost during --tare", "check cable and power");
    }
    if (outcome != Outcome::kReading) continue;
    const trial::Sample& sample = reading.samples[*channel];
    if (!IsMeasurement(sample.status)) continue;
    ++count;
    mean += (ValueOf(format, sample) - mean) / static_cast<double>(count);
    // behind an answer nothing is outstanding that a new beginning could mistake for its own
    if (clock.Now() - start_ns >= kNsPerS) break;
  }
  if (stop.load()) return Failed(name, "was not recorded: interrupted during --tare");
  if (count == 0) {
    return CannotAnswer(name, "gave no measurement to tare by",
                        "check that the laser is on and meets its target within the range");
  }
  return mean;
}

}  // namespace haptometer::tools
