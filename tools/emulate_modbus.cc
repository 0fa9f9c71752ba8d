#include "tools/emulate_modbus.h"

#include <fmt/core.h>

#include <utility>

#include "acquire/emulator/modbus_unit.h"
#include "acquire/sensor/modbus_profile.h"

namespace haptometer::tools {

Result<ModbusEmulation> EmulateModbus(const std::string& profile, bool over_tcp,
                                      acquire::emulator::MovingHead head,
                                      const acquire::emulator::FaultPlan& faults) {
  auto found = acquire::FindProfile(profile);
  if (!found) return std::unexpected(found.error());
  acquire::emulator::ModbusUnitSetup setup;
  setup.profile = std::move(*found);
  setup.framing = over_tcp ? acquire::ModbusFraming::kTcp : acquire::ModbusFraming::kRtu;
  setup.head = std::move(head);
  setup.head.head = acquire::emulator::HeadOf(setup.profile);
  setup.faults = faults;
  std::string remark = fmt::format(
      "{} as Modbus slave {}, {:g} mm from what moves, sampled every {:g} ms", setup.profile.name,
      setup.profile.wire.slave, 1e3 * setup.standoff_m, 1e3 * setup.head.head.sampling_s);
  if (!over_tcp) {
    remark += fmt::format("; at {} baud at most {:.1f} readings/s", setup.profile.wire.baud,
                          1 / SecondsFromNs(acquire::RtuPeriodNs(setup.profile)));
  }
  return ModbusEmulation{std::make_unique<acquire::emulator::ModbusUnit>(std::move(setup)),
                         std::move(remark)};
}

}  // namespace haptometer::tools
