#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

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
  std::optional<MonotonicNs> latency_ns{};  ///< transport/latency_timer.h
  std::string held_by{};                    ///< the process that has it open (PortHolder)
};

/// All serial ports that libserialport finds, by path. Errors (Cause::kFailed): the kernel's list
/// cannot be read.
[[nodiscard]] Result<std::vector<PortInfo>> ListPorts(const DeviceRoots& roots = {});

/// Fills in what sysfs and /dev tell of the port at `port.path`: by_id, driver, latency_ns.
void AddDeviceTree(const DeviceRoots& roots, PortInfo* port);

}  // namespace haptometer::acquire
