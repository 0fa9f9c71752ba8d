#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquire/emulator/device.h"
#include "acquire/emulator/fault.h"
#include "acquire/protocol/stream_line.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// How an emulated free-running head is set up.
struct StreamSetup {
  int baud = 921600;
  MovingHead head{};
  StreamFormat format{};
  FaultPlan faults{};  ///< none that NeedsAQuestion(): nobody asks it
};

/// Errors (Cause::kUsage): a line that does not fit between two samples, with the lines a second
/// that the wire allows and what would fit; a fault that only an answer can have.
[[nodiscard]] Result<void> Validate(const StreamSetup& setup);

/// A head that sends one line per raw sample without being asked: line k leaves at k * sampling_s,
/// k = 0, 1, 2, ... None is ever skipped, however late the caller is. Where the format has a line
/// counter, line k carries k, from 0 again after its last number.
///
/// Hands its bytes over in batches of about a millisecond. Cost: one reading per line.
class StreamHead final : public Device {
 public:
  /// `setup` has passed Validate().
  explicit StreamHead(StreamSetup setup);

  /// A real head does not listen. This one answers kIdentityRequest with a line of its own,
  /// kEmulatedIdentity, before the next reading, so that recordings can say what they were made of.
  void Receive(std::string_view bytes, MonotonicNs now) override;
  void Advance(MonotonicNs now, std::string& out) override;
  [[nodiscard]] std::optional<MonotonicNs> NextDue() const override;
  [[nodiscard]] bool TakeHangUp() override;
  [[nodiscard]] char line_end() const override;

 private:
  void PrepareLine();

  StreamSetup setup_;
  SerialLine wire_;
  std::string line_;           ///< line number next_ - 1
  std::size_t sent_ = 0;       ///< of line_
  MonotonicNs departure_ = 0;  ///< when line_[sent_] has crossed the wire
  MonotonicNs advanced_to_ = 0;
  std::int64_t next_ = 0;
  bool is_asked_ = false;
  bool hang_up_ = false;
};

}  // namespace haptometer::acquire::emulator
