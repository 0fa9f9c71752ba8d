// Any bytes at any times sent to an emulated DL-RS1A: it answers in whole lines, and the same
// whether it is asked often or once.
#include <cstddef>
#include <cstdint>
#include <string>

#include "acquire/emulator/dl_rs1a_unit.h"
#include "base/check.h"

namespace {

using haptometer::MonotonicNs;
namespace emulator = haptometer::acquire::emulator;

// the first byte of a pair says how long to wait, the second is sent
std::string Answers(const std::uint8_t* data, std::size_t size, bool often) {
  emulator::DlRs1aSetup setup;
  setup.head = {.head = haptometer::trial::Il030(), .displacement = [](double t_s) { return t_s; }};
  setup.head.head.averages = 1;
  emulator::DlRs1aUnit unit(setup);
  std::string out;
  MonotonicNs now = 0;
  for (std::size_t i = 0; i + 1 < size; i += 2) {
    const MonotonicNs until = now + MonotonicNs{data[i]} * 100'000;
    for (; often && now < until; now += 250'000) unit.Advance(now, out);
    now = until;
    const char byte = static_cast<char>(data[i + 1]);
    unit.Receive({&byte, 1}, now);
  }
  // the receive buffer, at 9600 baud, is empty after that
  unit.Advance(now + 10 * haptometer::kNsPerS, out);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string once = Answers(data, size, false);
  const std::string often = Answers(data, size, true);
  HAPTOMETER_CHECK(once == often, "{} and {} bytes", once.size(), often.size());
  HAPTOMETER_CHECK(once.empty() || once.ends_with("\r\n"), "{} bytes", once.size());
  return 0;
}
