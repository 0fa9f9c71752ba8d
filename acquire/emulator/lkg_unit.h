#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "acquire/emulator/device.h"
#include "acquire/emulator/fault.h"
#include "acquire/protocol/keyence/lkg.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// How an emulated LK-G3001 is set up. How long it takes for an answer is not in the pages at hand;
/// its relative LS-7000 takes the sampling period and 3 ms.
struct LkgSetup {
  int baud = 9600;
  std::vector<MovingHead> heads{};  ///< OUT1, OUT2; an output without a head shows no value
  int decimals = 4;                 ///< of a value in mm, as the display is set; 0 to 5
  MonotonicNs processing_ns = 3'000'000;
  bool in_communication_mode = false;  ///< somebody left it there (Q0)
  FaultPlan faults{};
};

/// Errors (Cause::kUsage): no head or more than two, no baud rate.
[[nodiscard]] Result<void> Validate(const LkgSetup& setup);

/// A Keyence LK-G3001: M0, M1, M2, Q0 and R0. In communication mode it measures nothing and refuses
/// M with 01.
class LkgUnit final : public AskedUnit {
 public:
  /// `setup` has passed Validate().
  explicit LkgUnit(LkgSetup setup);

 private:
  [[nodiscard]] MonotonicNs ProcessingNs(std::string_view line) const override;
  [[nodiscard]] std::string AnswerTo(std::string_view line, MonotonicNs now,
                                     const Fault* fault) override;
  [[nodiscard]] std::string AnswerToOverlong(std::string_view line) const override;
  [[nodiscard]] Value ValueOf(std::size_t out, MonotonicNs now, const Fault* fault) const;

  LkgSetup setup_;
};

}  // namespace haptometer::acquire::emulator
