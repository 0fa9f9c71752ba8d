#pragma once

#include <memory>
#include <string>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/transport.h"

namespace haptometer::acquire {

/// A TCP connection, as to a serial-to-network adapter or an emulator. Small packets leave at once
/// (TCP_NODELAY).
class TcpStream final : public Transport {
 public:
  /// Connects to `host`:`service` before `timeout_ns` has passed; each address of the host is
  /// tried. Errors (Cause::kCannotAnswer): unknown host, refused, no answer in time.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Connect(const std::string& host,
                                                                  const std::string& service,
                                                                  MonotonicNs timeout_ns);

  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] bool IsHardware() const override { return false; }
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  TcpStream(OwnedDescriptor descriptor, std::string name);

  OwnedDescriptor descriptor_;
  std::string name_;
};

}  // namespace haptometer::acquire
