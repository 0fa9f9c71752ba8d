#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "acquire/emulator/device.h"
#include "acquire/emulator/endpoint.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// What a run of Serve() came to.
struct ServeReport {
  std::uint64_t bytes = 0;          ///< handed to hosts
  std::uint64_t dropped_lines = 0;  ///< lost because the host did not read and there was no room
                                    ///< left (line_writer.h)
  std::uint64_t hang_ups = 0;       ///< times the device dropped off the line
};

/// Runs `device` at `endpoint` in real time, from its own time 0, until `stop` is true (looked at
/// every 50 ms, and after a signal) or `duration_ns` is over.
///
/// Bytes are handed over when they have crossed the emulated wire: never earlier, and later only by
/// what the system takes to wake the thread, which never adds up. While no host is there they are
/// lost, as on a wire. `announce` gets the endpoint's name at the start, when a host may come, and
/// again when a terminal's name has changed. One thread; costs one wake-up per due time.
/// Errors (Cause::kFailed): no new terminal after a hang-up.
[[nodiscard]] Result<ServeReport> Serve(Device& device, Endpoint& endpoint,
                                        const std::atomic<bool>& stop,
                                        std::optional<MonotonicNs> duration_ns,
                                        const std::function<void(const std::string&)>& announce);

}  // namespace haptometer::acquire::emulator
