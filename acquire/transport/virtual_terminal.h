#pragma once

#include <memory>
#include <string>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/transport.h"

namespace haptometer::acquire {

/// A pseudo-terminal, such as the emulator or socat gives: raw, 8N1, no hardware behind it.
///
/// Plain termios, because libserialport refuses pseudo-terminals. Always 8N1: a pseudo-terminal
/// carries no parity, and setting one fails. There is no baud rate; the wire is as fast as its
/// other end. Taken with flock, not TIOCEXCL, which would outlive us as long as the other end is
/// open.
class VirtualTerminal final : public Transport {
 public:
  /// Errors (Cause::kCannotAnswer): absent, no permission, busy, not a terminal.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Open(const std::string& path);

  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] bool IsHardware() const override { return false; }
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  VirtualTerminal(OwnedDescriptor descriptor, std::string name);

  OwnedDescriptor descriptor_;
  std::string name_;
};

}  // namespace haptometer::acquire
