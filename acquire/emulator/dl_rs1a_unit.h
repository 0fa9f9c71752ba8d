#pragma once

#include <vector>

#include "acquire/emulator/dl_unit.h"
#include "acquire/emulator/fault.h"
#include "acquire/emulator/moving_head.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// How an emulated DL-RS1A is set up. The times are the maker's maxima for one amplifier; the
/// refresh of the IL series is not printed, its siblings (IB, GT-70A) say 7 ms.
struct DlRs1aSetup {
  int baud = dl_rs1a::kBauds.front();
  MovingHead head{};                                   ///< an IL-030 (trial::Il030())
  MonotonicNs processing_ns = dl_rs1a::kProcessingNs;  ///< T4 of M0 and MS
  MonotonicNs direct_processing_ns = 13'000'000;       ///< T4 of SR; SW takes 14 ms
  MonotonicNs refresh_ns = dl_rs1a::kRefreshNs;  ///< T2: the buffer is refilled at k * refresh
  FaultPlan faults{};
  std::vector<MovingHead> expansions{};  ///< of the amplifiers 01, 02, ...
  bool is_writable = false;              ///< the R/W switch stands on W
};

/// Errors (Cause::kUsage): a rate, sampling cycle or averaging that the unit or the IL-1000
/// amplifier does not have, with the ones they have; more than 15 amplifiers.
[[nodiscard]] Result<void> Validate(const DlRs1aSetup& setup);

/// A Keyence DL-RS1A with an IL-1000 amplifier (number 00) and its expansions.
///
/// Understands M0, MS, SR, SW and AW. With its R/W switch on R (the default) SW and AW are refused
/// with 67. Data: emulator/il_amplifier.h; others are refused with 22.
///
/// Source: Keyence, DL-RS1A User's Manual (IL Edition), p. 6-15.
class DlRs1aUnit final : public DlUnit {
 public:
  /// `setup` has passed Validate().
  explicit DlRs1aUnit(const DlRs1aSetup& setup);
};

}  // namespace haptometer::acquire::emulator
