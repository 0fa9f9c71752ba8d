#include "acquire/transport/port_list.h"

#include <fmt/core.h>
#include <libserialport.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>

#include "acquire/transport/descriptor.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kNsPerMs = 1'000'000;

// place of the latency timer below SYSFS, for a port that is called ttyUSB0
std::string TimerPath(const std::string& path) {
  return fmt::format("/bus/usb-serial/devices/{}/latency_timer",
                     std::filesystem::path(path).filename().string());
}

}  // namespace

std::optional<MonotonicNs> LatencyTimerNs(const std::string& path, const std::string& sysfs) {
  constexpr int kMostMs = 255;  // the timer has 8 bits
  int ms = 0;
  if (!(std::ifstream(sysfs + TimerPath(path)) >> ms) || ms < 0 || ms > kMostMs) {
    return std::nullopt;
  }
  return ms * kNsPerMs;
}

void AddLatencyTimer(std::optional<MonotonicNs> latency_ns, trial::Metadata& metadata) {
  // in s, as all times of the metadata
  if (!latency_ns) return;
  metadata.fields[std::string(kLatencyTimerField)] =
      fmt::format("{:g}", SecondsFromNs(*latency_ns));
}

std::string LatencyWords(std::optional<MonotonicNs> latency_ns, bool is_low) {
  if (latency_ns) return fmt::format(", latency timer {} ms", *latency_ns / kNsPerMs);
  return is_low ? ", low latency" : "";
}

// polls per second: the adapter keeps each reply for the timer's time
double PolledRateHz(MonotonicNs period_ns, MonotonicNs latency_ns) {
  return 1 / SecondsFromNs(period_ns + latency_ns);
}

Findings LatencyCostOf(const std::string& path, MonotonicNs latency_ns, MonotonicNs period_ns) {
  Findings found;
  // a timer of 1 ms is no reason for a doubt
  if (latency_ns <= kNsPerMs) return found;
  found.Doubt(FindingKind::kLatencyTimer,
              {{"port", std::filesystem::path(path).filename().string()},
               {"latency_s", SecondsFromNs(latency_ns)},
               {"rate_hz", PolledRateHz(period_ns, latency_ns)},
               {"rate_at_1_ms_hz", PolledRateHz(period_ns, kNsPerMs)}});
  return found;
}

namespace {

namespace fs = std::filesystem;

std::string TextOf(const char* text) { return text == nullptr ? "" : text; }

// properties of a port by libserialport
PortInfo Describe(sp_port* port) {
  PortInfo info{.path = TextOf(sp_get_port_name(port)),
                .description = TextOf(sp_get_port_description(port))};
  // vendor, product and serial number exist only for USB
  if (sp_get_port_transport(port) != SP_TRANSPORT_USB) return info;
  int vendor = 0;
  int product = 0;
  if (sp_get_port_usb_vid_pid(port, &vendor, &product) == SP_OK) {
    info.usb_vendor = vendor;
    info.usb_product = product;
  }
  info.usb_serial = TextOf(sp_get_port_usb_serial(port));
  return info;
}

// the link in `directory` that leads to a device of this name
std::string LinkTo(const fs::path& directory, const fs::path& name) {
  std::error_code error;
  for (auto entry = fs::directory_iterator(directory, error);
       !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code unreadable;
    if (fs::read_symlink(entry->path(), unreadable).filename() == name) return entry->path();
  }
  return {};
}

}  // namespace

void AddDeviceTree(const DeviceRoots& roots, PortInfo* port) {
  const fs::path name = fs::path(port->path).filename();
  // a name that remains when the port's number changes
  port->by_id = LinkTo(fs::path(roots.devices) / "serial" / "by-id", name);
  std::error_code error;
  const fs::path driver =
      fs::read_symlink(fs::path(roots.sysfs) / "class" / "tty" / name / "device" / "driver", error);
  port->driver = driver.filename();
  port->latency_ns = LatencyTimerNs(port->path, roots.sysfs);
}

Result<std::vector<PortInfo>> ListPorts(const DeviceRoots& roots) {
  sp_port** found = nullptr;
  if (sp_list_ports(&found) != SP_OK) {
    return Failed("", "the serial ports cannot be listed",
                  "look for them with: ls /dev/serial/by-id/");
  }
  const std::unique_ptr<sp_port*, decltype(&sp_free_port_list)> list(found, &sp_free_port_list);
  std::vector<PortInfo> ports;
  for (sp_port** port = found; *port != nullptr; ++port) {
    PortInfo info = Describe(*port);
    AddDeviceTree(roots, &info);
    info.held_by = PortHolder(info.path);
    ports.push_back(std::move(info));
  }
  std::ranges::sort(ports, {}, &PortInfo::path);
  return ports;
}

}  // namespace haptometer::acquire
