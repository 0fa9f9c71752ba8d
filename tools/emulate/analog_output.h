#pragma once

#include <memory>
#include <string>

#include "acquire/emulator/device.h"
#include "base/error.h"

namespace haptometer::tools {

/// What a DAQ at the amplifier's analog output samples.
struct AnalogSampling {
  std::string path;        ///< named pipe that the samples are written to, as lines of volts
  double noise_rms_v = 0;  ///< of each sample
  std::uint64_t seed = 1;  ///< of the noise
};

/// The rate of these samples.
inline constexpr double kAnalogRateHz = 1000;

/// `device`, which `head` stands before, with a DAQ at its analog output beside it: text lines of
/// volts (emulator::AnalogVolts and noise), 1000 a second on the device's clock, into a named pipe.
///
/// The pipe is made where it is not there, and then goes with the device. Samples that nobody
/// reads, or not in time, are lost, as of a DAQ that is not asked. Errors (Cause::kFailed): the
/// pipe cannot be made; Cause::kUsage: something else is there.
[[nodiscard]] Result<std::unique_ptr<acquire::emulator::Device>> WithAnalogOutput(
    std::unique_ptr<acquire::emulator::Device> device, acquire::emulator::MovingHead head,
    AnalogSampling sampling);

}  // namespace haptometer::tools
