#include "acquire/transport/open_port.h"

#include <fmt/core.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <utility>

#include "acquire/protocol/digits.h"
#include "acquire/transport/descriptor.h"
#include "acquire/transport/serial_port.h"
#include "acquire/transport/tcp_stream.h"
#include "acquire/transport/virtual_terminal.h"

namespace haptometer::acquire {
namespace {

constexpr MonotonicNs kConnectTimeoutNs = 5 * kNsPerS;

// "host:64000" and "[::1]:64000", but no path
bool IsNetworkName(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  if (colon == std::string::npos || colon == 0 || name.find('/') != std::string::npos) return false;
  const std::string port = name.substr(colon + 1);
  return !port.empty() && std::ranges::all_of(port, [](char c) { return c >= '0' && c <= '9'; });
}

constexpr int kMostPort = 65'535;

// the slaves of pseudo-terminals have the device numbers 136 to 143 (Linux,
// admin-guide/devices.txt)
bool IsPseudoTerminal(dev_t device) { return major(device) >= 136 && major(device) <= 143; }

}  // namespace

NetworkName SplitNetworkName(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  std::string host = name.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return {std::move(host), name.substr(colon + 1)};
}

std::optional<int> TcpPort(std::string_view text) {
  const std::optional<std::int32_t> port = ParseDigits(text);
  return port.value_or(0) <= kMostPort ? port : std::nullopt;
}

Result<PortKind> KindOfPort(const std::string& name) {
  if (IsNetworkName(name)) {
    const std::string port = SplitNetworkName(name).service;
    if (TcpPort(port).value_or(0) > 0) return PortKind::kNetwork;
    return Usage(name, fmt::format("{} is no TCP port", port),
                 fmt::format("give HOST:PORT with a port from 1 to {}", kMostPort));
  }
  struct stat status{};
  if (stat(name.c_str(), &status) != 0) return std::unexpected(PortDoesNotOpen(name, errno));
  if (!S_ISCHR(status.st_mode)) {
    return CannotAnswer(name, "is not a port", "give a serial port such as /dev/ttyUSB0");
  }
  return IsPseudoTerminal(status.st_rdev) ? PortKind::kVirtualTerminal : PortKind::kSerial;
}

Result<std::unique_ptr<Transport>> OpenPort(const std::string& name, int baud) {
  const auto kind = KindOfPort(name);
  if (!kind) return std::unexpected(kind.error());
  if (*kind == PortKind::kNetwork) {
    const NetworkName parts = SplitNetworkName(name);
    return TcpStream::Connect(parts.host, parts.service, kConnectTimeoutNs);
  }
  if (*kind == PortKind::kVirtualTerminal) return VirtualTerminal::Open(name);
  // libserialport knows ports by the kernel's names only, so links are followed first
  const std::unique_ptr<char, decltype(&std::free)> path(realpath(name.c_str(), nullptr),
                                                         &std::free);
  return SerialPort::Open(path ? path.get() : name, name, baud);
}

}  // namespace haptometer::acquire
