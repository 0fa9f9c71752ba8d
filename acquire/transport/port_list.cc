#include "acquire/transport/port_list.h"

#include <libserialport.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "acquire/transport/latency_timer.h"
#include "acquire/transport/port_holder.h"

namespace haptometer::acquire {
namespace {

namespace fs = std::filesystem;

std::string TextOf(const char* text) { return text == nullptr ? "" : text; }

// what libserialport knows of a port
PortInfo Describe(sp_port* port) {
  PortInfo info{.path = TextOf(sp_get_port_name(port)),
                .description = TextOf(sp_get_port_description(port))};
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
