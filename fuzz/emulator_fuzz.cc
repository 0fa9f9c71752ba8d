// Any bytes at any times sent to an emulated unit that is asked: it answers in whole lines, and the
// same whether it is asked often or once.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/lkg_unit.h"
#include "base/error.h"

namespace {

using haptometer::MonotonicNs;
namespace emulator = haptometer::acquire::emulator;

std::unique_ptr<emulator::Device> DeviceOf(std::uint8_t choice) {
  emulator::MovingHead head{.head = haptometer::trial::Il030(),
                            .displacement = [](double t_s) { return t_s; }};
  head.head.averages = 1;
  switch (choice % 3) {
    case 0: {
      emulator::DlRs1aSetup setup{.head = head};
      setup.expansions = {head};
      setup.is_writable = true;
      return std::make_unique<emulator::DlRs1aUnit>(setup);
    }
    case 1:
      return std::make_unique<emulator::DlEn1Unit>(
          emulator::DlEn1Setup{.heads = {head, head}, .is_writable = true});
    default:
      return std::make_unique<emulator::LkgUnit>(emulator::LkgSetup{.heads = {head}});
  }
}

// the first byte of a pair says how long to wait, the second is sent
std::string Answers(const std::uint8_t* data, std::size_t size, bool often) {
  const auto unit = DeviceOf(data[0]);
  std::string out;
  MonotonicNs now = 0;
  for (std::size_t i = 1; i + 1 < size; i += 2) {
    const MonotonicNs until = now + MonotonicNs{data[i]} * 100'000;
    for (; often && now < until; now += 250'000) unit->Advance(now, out);
    now = until;
    const char byte = static_cast<char>(data[i + 1]);
    unit->Receive({&byte, 1}, now);
  }
  // the receive buffer, at 9600 baud, is empty after that
  unit->Advance(now + 20 * haptometer::kNsPerS, out);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string once = Answers(data, size, false);
  const std::string often = Answers(data, size, true);
  HAPTOMETER_CHECK(once == often, "{} and {} bytes", once.size(), often.size());
  HAPTOMETER_CHECK(once.empty() || once.ends_with(DeviceOf(data[0])->line_end()), "{} bytes",
                   once.size());
  return 0;
}
