#pragma once

#include <memory>
#include <string>

#include "acquire/emulator/device.h"
#include "acquire/emulator/fault.h"
#include "base/error.h"

namespace haptometer::tools {

/// An emulated device, and what to say of it once it is ready.
struct ModbusEmulation {
  std::unique_ptr<acquire::emulator::Device> device;
  std::string remark;
};

/// The Modbus sensor of `profile` (a built-in name or a file) before what `head` sees, whose
/// settings are replaced by the profile's. Errors: those of the profile.
[[nodiscard]] Result<ModbusEmulation> EmulateModbus(const std::string& profile, bool over_tcp,
                                                    acquire::emulator::MovingHead head,
                                                    const acquire::emulator::FaultPlan& faults);

}  // namespace haptometer::tools
