#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/clock.h"
#include "base/result.h"
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
  bool hangs_up = false;     ///< the device drops off the line instead of answering
  MonotonicNs pause_ns = 0;  ///< Modbus: the answer's second half comes this much later
  bool is_modbus = false;    ///< only a Modbus device fails so
};

/// All faults: silent, late, truncate, garbage, error, invalid, over, disconnect; of Modbus alone:
/// byte-gap, crc, slave, transaction, word-order.
[[nodiscard]] std::span<const Fault> Faults();

/// A fault and how often it strikes.
struct FaultPlan {
  const Fault* fault = nullptr;  ///< nullptr: the device is sound
  std::int64_t every = 1;        ///< answers every, 2 every, 3 every, ... are hit

  /// The fault that strikes answer `number` (1 is the first), or nullptr.
  [[nodiscard]] const Fault* At(std::int64_t number) const;
};

/// Reads "NAME" or "NAME:EVERY". Errors (Cause::kUsage): an unknown name, EVERY not a whole number
/// from 1; both list what is known.
[[nodiscard]] Result<FaultPlan> ParseFaultPlan(std::string_view text);

/// `answer` after `damage`; garbling depends only on `number`, so that a run can be repeated.
[[nodiscard]] std::string Damaged(std::string answer, Damage damage, std::int64_t number);

}  // namespace haptometer::acquire::emulator
