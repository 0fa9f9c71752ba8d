#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/clock.h"
#include "base/error.h"
#include "trial/record.h"

namespace haptometer::acquire::emulator {

/// What a fault does to the bytes of an answer.
enum class Damage : std::uint8_t {
  kNone,
  kMissing,    ///< nothing is sent
  kTruncated,  ///< the first half is sent, without the line's end
  kGarbled,    ///< every byte but the line's end is replaced
  // of Modbus, whose unit knows what a frame holds
  kWrongCrc,
  kWrongSlave,
  kWrongTransaction,
  kSwappedWords,
};

/// One way in which a device fails; a row of the table in fault.cc.
struct Fault {
  std::string_view name;
  std::string_view summary;                               ///< for --help
  trial::SampleStatus status = trial::SampleStatus::kOk;  ///< the reading's, where not kOk
  Damage damage = Damage::kNone;
  bool refuses = false;      ///< a polled unit answers `ER`
  MonotonicNs delay_ns = 0;  ///< a polled unit answers this much later
  MonotonicNs pause_ns = 0;  ///< a polled unit falls silent for so long in the middle of an answer
  bool holds_back = false;   ///< a polled unit keeps the answer and sends it with the next
  bool wrong_id = false;     ///< a polled unit answers for another amplifier, or for one too many
  bool hangs_up = false;     ///< the device drops off the line instead of answering
  bool is_modbus = false;    ///< only a Modbus device fails so
};

/// All faults, in the order of --help.
[[nodiscard]] std::span<const Fault> Faults();

/// Whether only one who is asked can have `fault`: a head that sends by itself cannot.
[[nodiscard]] bool NeedsAQuestion(const Fault& fault);

/// A fault and how often it strikes.
struct FaultPlan {
  const Fault* fault = nullptr;       ///< nullptr: the device is sound
  std::int64_t every = 1;             ///< answers every, 2 every, 3 every, ... are hit
  std::optional<int> error_number{};  ///< of a refusal; empty: what the device takes for such a one

  /// The fault that strikes answer `number` (1 is the first), or nullptr.
  [[nodiscard]] const Fault* At(std::int64_t number) const;
};

/// Reads "NAME", "NAME:EVERY", and for `error` also "error-NUMBER", "error-NUMBER:EVERY". Errors
/// (Cause::kUsage): an unknown name, EVERY not a whole number from 1; both list what is known.
[[nodiscard]] Result<FaultPlan> ParseFaultPlan(std::string_view text);

/// `answer` after `damage`; garbling depends only on `number`, so that a run can be repeated.
[[nodiscard]] std::string Damaged(std::string answer, Damage damage, std::int64_t number);

}  // namespace haptometer::acquire::emulator
