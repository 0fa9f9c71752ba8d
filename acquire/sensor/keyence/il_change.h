#pragma once

#include <span>
#include <string>
#include <vector>

#include "acquire/protocol/keyence/il_setting.h"
#include "acquire/sensor/keyence/il_unit.h"
#include "base/clock.h"
#include "base/error.h"

namespace haptometer::acquire {

/// Something in an amplifier that was changed because the user asked for it.
struct IlChange {
  int unit = 0;     ///< identification number of the amplifier
  std::string key;  ///< "sampling", "zero"
  std::string before;
  std::string after;  ///< as read back

  /// "amplifier 00: sampling 1ms -> 0.33ms"
  [[nodiscard]] std::string Text() const;
};

/// Writes each of `writes` to each of `units` and reads it back. What holds the code already is not
/// written, and is no change.
///
/// Data are written with as many digits as they are read. Errors (Cause::kCannotAnswer): a write
/// was refused (a locked unit: with the remedy) or did not take; what had been changed by then is
/// named, and stays.
[[nodiscard]] Result<std::vector<IlChange>> WriteSettings(
    IlTalk& talk, std::span<const int> units, std::span<const il_setting::Write> writes);

/// Shifts the zero of each of `units` to where its target is now: data 001 is written 0, 1 and 0
/// again (some models act on the edge, some on the level). The change is the P.V. as sent.
///
/// The shift is lost when the amplifier is switched off, unless its data 152 says otherwise. Errors
/// (Cause::kCannotAnswer): as WriteSettings; the amplifier says that it failed (data 054).
[[nodiscard]] Result<std::vector<IlChange>> ShiftZeros(IlTalk& talk, std::span<const int> units,
                                                       Clock& clock);

/// Waits until no amplifier shows -99.998, as it does after a setting was written, at most
/// `longest_ns`. Returns whether that came about: without a target it never does.
[[nodiscard]] Result<bool> WaitUntilValid(IlTalk& talk, MonotonicNs refresh_ns,
                                          MonotonicNs longest_ns, Clock& clock);

}  // namespace haptometer::acquire
