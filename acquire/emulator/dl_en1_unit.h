#pragma once

#include <vector>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/fault.h"
#include "acquire/emulator/moving_head.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// How an emulated DL-EN1 is set up. How long it takes for an answer is not in the manual.
struct DlEn1Setup {
  std::vector<MovingHead> heads{};  ///< of the amplifiers 01, 02, ...; at least one
  MonotonicNs processing_ns = 1'000'000;
  MonotonicNs refresh_ns = 7'800'000;  ///< the maker's for one amplifier (dl_en1::RefreshNs)
  bool is_writable = false;
  FaultPlan faults{};
};

/// Errors (Cause::kUsage): as of DlRs1aSetup.
[[nodiscard]] Result<void> Validate(const DlEn1Setup& setup);

/// A Keyence DL-EN1 with IL amplifiers from number 01: M0, MS, SR, SW and FR, values without a
/// point. Bytes cross its wire as fast as 100 Mbit/s carry them.
///
/// Source: Keyence, DL-EN1 User's Manual (633GB), chapters 5 and 6. How SR carries the codes of
/// settings is not quite clear there: here as sign and nine digits, like all numbers; a product
/// name as text.
class DlEn1Unit final : public DlUnit {
 public:
  /// `setup` has passed Validate().
  explicit DlEn1Unit(DlEn1Setup setup);
};

}  // namespace haptometer::acquire::emulator
