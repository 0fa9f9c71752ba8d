#include "acquire/transport/virtual_terminal.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <termios.h>

#include <cerrno>
#include <utility>

namespace haptometer::acquire {

VirtualTerminal::VirtualTerminal(OwnedDescriptor descriptor, std::string name)
    : descriptor_(std::move(descriptor)), name_(std::move(name)) {}

Result<std::unique_ptr<Transport>> VirtualTerminal::Open(const std::string& path) {
  OwnedDescriptor descriptor(open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (descriptor.get() < 0) return std::unexpected(PortDoesNotOpen(path, errno));
  if (auto locked = LockPort(descriptor.get(), path); !locked) {
    return std::unexpected(locked.error());
  }
  // raw: no echo, no line editing, no translation of CR, 8 bits
  termios settings{};
  if (tcgetattr(descriptor.get(), &settings) != 0) {
    return std::unexpected(PortDoesNotOpen(path, errno));
  }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  if (tcsetattr(descriptor.get(), TCSANOW, &settings) != 0) {
    return std::unexpected(PortDoesNotOpen(path, errno));
  }
  tcflush(descriptor.get(), TCIOFLUSH);
  return std::unique_ptr<Transport>(new VirtualTerminal(std::move(descriptor), path));
}

ReadOutcome VirtualTerminal::Read(std::span<char> buffer, MonotonicNs deadline) {
  return ReadDescriptor(descriptor_.get(), buffer, deadline);
}

Result<void> VirtualTerminal::Write(std::string_view bytes, MonotonicNs deadline) {
  return WriteDescriptor(descriptor_.get(), bytes, deadline, name_);
}

std::string VirtualTerminal::Source() const {
  return fmt::format("virtual terminal {} (not a hardware port)", name_);
}

}  // namespace haptometer::acquire
