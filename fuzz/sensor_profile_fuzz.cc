// A profile's text: accepted or refused with a reason, and an accepted one can be asked for and
// emulated.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "acquire/emulator/modbus_unit.h"
#include "acquire/sensor/modbus_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace haptometer;
  using namespace haptometer::acquire;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto profile = ReadProfileText(text, "profile.toml");
  if (!profile) {
    if (profile.error().Text().empty()) std::abort();
    return 0;
  }
  if (!WhatIsWrong(*profile).empty() || !(HighestRateHz(*profile) > 0)) std::abort();

  // an emulated one answers the profile's own request with registers
  emulator::ModbusUnitSetup setup{.profile = *profile, .framing = ModbusFraming::kTcp};
  setup.head.head = emulator::HeadOf(*profile);
  setup.head.displacement = [](double) { return 0.0; };
  emulator::ModbusUnit unit(setup);
  const ReadRequest request = ReadingRequest(*profile);
  std::string asked;
  AppendReadRequest(ModbusFraming::kTcp, request, asked);
  unit.Receive(asked, 0);
  std::string answer;
  unit.Advance(0, answer);
  if (ParseReadReply(ModbusFraming::kTcp, request, answer).registers.empty()) std::abort();
  return 0;
}
