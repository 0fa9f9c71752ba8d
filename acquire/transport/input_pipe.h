#pragma once

#include <memory>
#include <string>

#include "acquire/transport/descriptor.h"
#include "acquire/transport/transport.h"

namespace haptometer::acquire {

/// Bytes that another program writes: standard input, a named pipe, or a file. Nothing can be sent.
///
/// The kernel is asked to keep 1 MiB for a pipe, so that a writer is not held up while we are.
class InputPipe final : public Transport {
 public:
  /// `path`: empty or "-" is standard input. Errors (Cause::kCannotAnswer): a terminal, of which no
  /// samples come; absent, no permission, a directory.
  [[nodiscard]] static Result<std::unique_ptr<Transport>> Open(const std::string& path);

  /// kGone at the end of the input.
  [[nodiscard]] ReadOutcome Read(std::span<char> buffer, MonotonicNs deadline) override;
  /// Always an error.
  [[nodiscard]] Result<void> Write(std::string_view bytes, MonotonicNs deadline) override;
  [[nodiscard]] std::string Source() const override;
  [[nodiscard]] bool IsHardware() const override { return false; }
  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  InputPipe(OwnedDescriptor descriptor, std::string name);

  OwnedDescriptor descriptor_;
  std::string name_;
};

}  // namespace haptometer::acquire
