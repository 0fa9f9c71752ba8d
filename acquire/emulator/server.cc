#include "acquire/emulator/server.h"

#include <sys/prctl.h>

#include <algorithm>

#include "acquire/emulator/line_writer.h"

namespace haptometer::acquire::emulator {
namespace {

constexpr MonotonicNs kStopPollNs = 50'000'000;

}  // namespace

Result<ServeReport> Serve(Device& device, Endpoint& endpoint, const std::atomic<bool>& stop,
                          std::optional<MonotonicNs> duration_ns,
                          const std::function<void(const std::string&)>& announce) {
  // the system may not round this thread's wake-ups to 50 us, its default
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  ServeReport report;
  LineWriter writer(device.line_end(), LineWriter::kPortRoom, [&](std::string_view bytes) {
    const std::size_t taken = endpoint.Write(bytes);
    report.bytes += taken;
    return taken;
  });
  SystemClock clock;
  std::string incoming;
  std::string outgoing;
  std::string name = endpoint.name();
  const MonotonicNs start = clock.Now();
  announce(name);

  MonotonicNs now = 0;
  bool had_host = false;
  while (!stop.load() && (!duration_ns || now < *duration_ns)) {
    // sleep until something is due or comes in
    MonotonicNs wake = now + kStopPollNs;
    if (const auto due = device.NextDue()) wake = std::min(wake, *due);
    if (duration_ns) wake = std::min(wake, *duration_ns);
    bool has_host = endpoint.Wait(wake - (clock.Now() - start));

    // bytes are stamped after they are read, never before they were written
    incoming.clear();
    if (has_host) has_host = endpoint.Read(incoming);
    now = clock.Now() - start;
    if (!incoming.empty()) device.Receive(incoming, now);

    // what has crossed the wire goes to the host, if there is one
    outgoing.clear();
    device.Advance(now, outgoing);
    if (had_host && !has_host) writer.Abandon();
    if (has_host) writer.Write(outgoing);
    had_host = has_host;

    // a device that drops off the line may come back under another name
    if (device.TakeHangUp() && has_host) {
      if (auto unplugged = endpoint.Unplug(); !unplugged) {
        return std::unexpected(unplugged.error());
      }
      ++report.hang_ups;
      writer.Abandon();
      if (endpoint.name() != name) announce(name = endpoint.name());
    }
  }
  report.dropped_lines = writer.dropped_lines();
  return report;
}

}  // namespace haptometer::acquire::emulator
