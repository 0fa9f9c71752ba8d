#include "acquire/transport/serial_port.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <libserialport.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <utility>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/latency_timer.h"

namespace haptometer::acquire {
namespace {

// 8N1 without flow control
sp_return Configure(sp_port* port, int baud) {
  for (const sp_return done :
       {sp_set_baudrate(port, baud), sp_set_bits(port, 8), sp_set_parity(port, SP_PARITY_NONE),
        sp_set_stopbits(port, 1), sp_set_flowcontrol(port, SP_FLOWCONTROL_NONE),
        sp_flush(port, SP_BUF_BOTH)}) {
    if (done != SP_OK) return done;
  }
  return SP_OK;
}

}  // namespace

struct SerialPort::Handle {
  OwnedDescriptor lock{-1};  // held before libserialport opens the port, and as long as we have it
  sp_port* port = nullptr;
  bool open = false;

  Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (open) sp_close(port);
    sp_free_port(port);
  }
};

SerialPort::SerialPort(std::unique_ptr<Handle> handle, std::string name, int baud)
    : handle_(std::move(handle)), name_(std::move(name)), baud_(baud) {}

SerialPort::~SerialPort() {
  if (descriptor_ >= 0) ioctl(descriptor_, TIOCNXCL);
}

Result<std::unique_ptr<Transport>> SerialPort::Open(const std::string& path,
                                                    const std::string& name, int baud) {
  // open
  auto handle = std::make_unique<Handle>();
  if (sp_get_port_by_name(path.c_str(), &handle->port) != SP_OK) {
    return CannotAnswer(name, "is not a serial port",
                        "look for the sensor's port with: ls /dev/serial/by-id/");
  }
  // take it for us alone before anything is set: sp_open() changes settings, also another user's
  handle->lock = OwnedDescriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (handle->lock.get() < 0) return std::unexpected(PortDoesNotOpen(name, errno));
  if (auto locked = LockPort(handle->lock.get(), name); !locked) {
    return std::unexpected(locked.error());
  }
  if (sp_open(handle->port, SP_MODE_READ_WRITE) != SP_OK) {
    return std::unexpected(PortDoesNotOpen(name, sp_last_error_code()));
  }
  handle->open = true;
  int descriptor = -1;
  sp_get_port_handle(handle->port, &descriptor);
  ioctl(descriptor, TIOCEXCL);
  std::unique_ptr<SerialPort> opened(new SerialPort(std::move(handle), name, baud));
  opened->descriptor_ = descriptor;

  // settings
  if (Configure(opened->handle_->port, baud) != SP_OK) {
    return CannotAnswer(name, fmt::format("cannot be set to {} baud 8N1", baud),
                        "give a --baud that the port and the sensor have");
  }
  opened->low_latency_ = AskForLowLatency(descriptor);
  opened->path_ = path;
  opened->latency_ns_ = LatencyTimerNs(path);
  return opened;
}

ReadOutcome SerialPort::Read(std::span<char> buffer, MonotonicNs deadline) {
  return ReadDescriptor(descriptor_, buffer, deadline);
}

Result<void> SerialPort::Write(std::string_view bytes, MonotonicNs deadline) {
  return WriteDescriptor(descriptor_, bytes, deadline, name_);
}

std::string SerialPort::Source() const {
  return fmt::format("device: serial port {}, {} baud 8N1{}", name_, baud_,
                     LatencyWords(latency_ns_, low_latency_));
}

std::string SerialPort::LatencyCost(MonotonicNs period_ns) const {
  return latency_ns_ ? LatencyRemark(path_, *latency_ns_, period_ns) : "";
}

}  // namespace haptometer::acquire
