#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/findings.h"
#include "base/clock.h"
#include "base/error.h"
#include "trial/trial_format.h"

/// An FTDI adapter keeps a short reply until its latency timer runs out: 16 ms unless told
/// otherwise, which costs a polled sensor more than the wire does.
namespace haptometer::acquire {

/// The latency timer of a serial port, in ns, as the kernel's driver shows it; empty where the
/// adapter has none. `path` is the port's device file (/dev/ttyUSB0), `sysfs` where sysfs is.
[[nodiscard]] std::optional<MonotonicNs> LatencyTimerNs(const std::string& path,
                                                        const std::string& sysfs = "/sys");

/// The field of a trial's metadata that holds a serial adapter's latency timer, in s.
inline constexpr std::string_view kLatencyTimerField = "latency_timer_s";

/// Writes that field, where the port has a timer.
void AddLatencyTimer(std::optional<MonotonicNs> latency_ns, trial::Metadata& metadata);

/// What a serial port's Source() says of its latency: the timer where it was read back, else
/// whether the driver took the low-latency setting; ", latency timer 1 ms", or "".
[[nodiscard]] std::string LatencyWords(std::optional<MonotonicNs> latency_ns, bool is_low);

/// Exchanges a second where one takes `period_ns` and its reply waits for the timer: 1 / (period_ns
/// + latency_ns).
[[nodiscard]] double PolledRateHz(MonotonicNs period_ns, MonotonicNs latency_ns);

/// What a latency timer above 1 ms costs a sensor that is polled every `period_ns` at best; nothing
/// where it is not above that.
[[nodiscard]] Findings LatencyCostOf(const std::string& path, MonotonicNs latency_ns,
                                     MonotonicNs period_ns);

/// Where the kernel shows its devices; elsewhere in tests.
struct DeviceRoots {
  std::string sysfs = "/sys";
  std::string devices = "/dev";
};

/// A serial port of the computer; what is not known is empty.
struct PortInfo {
  std::string path{};   ///< "/dev/ttyUSB0"
  std::string by_id{};  ///< the name that stays with the adapter: "/dev/serial/by-id/usb-FTDI_..."
  std::string description{};
  std::string driver{};                     ///< "ftdi_sio"
  std::optional<int> usb_vendor{};          ///< 0x0403
  std::optional<int> usb_product{};         ///< 0x6001
  std::string usb_serial{};                 ///< the adapter's own number
  std::optional<MonotonicNs> latency_ns{};  ///< of the adapter's timer
  std::string held_by{};                    ///< the process that has it open (PortHolder)
};

/// All serial ports that libserialport finds, by path. Errors (Cause::kFailed): the kernel's list
/// cannot be read.
[[nodiscard]] Result<std::vector<PortInfo>> ListPorts(const DeviceRoots& roots = {});

/// Fills in what sysfs and /dev tell of the port at `port.path`: by_id, driver, latency_ns.
void AddDeviceTree(const DeviceRoots& roots, PortInfo* port);

}  // namespace haptometer::acquire
