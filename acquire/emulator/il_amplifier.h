#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "acquire/emulator/moving_head.h"
#include "acquire/protocol/keyence/dl_rs1a.h"
#include "acquire/protocol/value.h"
#include "base/error.h"

namespace haptometer::acquire::emulator {

/// What a data number of an amplifier holds; how it is spelled is the communication unit's matter.
struct IlDatum {
  enum class Kind : std::uint8_t { kValue, kNumber, kText };
  Kind kind = Kind::kNumber;
  Value value{};       ///< kValue
  int number = 0;      ///< kNumber
  int digits = 1;      ///< kNumber: as many as a DL-RS1A sends
  std::string text{};  ///< kText
};

/// How a write ended.
enum class IlWriteOutcome : std::uint8_t { kDone, kNoSuchNumber, kReadOnly, kOutOfRange };

/// An IL amplifier with its head: readings, and the data numbers that describe and set it.
///
/// Data 033, 036-040, 054, 098, 132, 133, 136, 152, 159, 193, 195 and 200 (the product name, which
/// is EMULATED) can be read; 098, 132, 133, 136, 152 and 159 written, and 001 and 002 (zero shift
/// and its reset, at the edge from 0 to 1). Sampling and averages take effect; after a change of
/// 132, 133 or 136 the readings are invalid for two response times. Hold and filter are kept and
/// have no effect. Comparator limits are the ends of the measuring range.
///
/// A head that is none of the IL series is taken for an IL-030.
class IlAmplifier {
 public:
  /// `is_main`: the product code is that of a main amplifier.
  IlAmplifier(MovingHead head, bool is_main);

  /// The head's last reading that is complete at `sampled`; `now` decides whether the amplifier
  /// has settled.
  [[nodiscard]] Value ReadingAt(MonotonicNs sampled, MonotonicNs now) const;
  /// The comparator's outputs for `value`: bit 0 HIGH, 1 LOW, 2 GO, 3 alarm.
  [[nodiscard]] static int Outputs(const Value& value);

  /// Nothing for a number that it does not know. `present` is what the P.V. numbers give.
  [[nodiscard]] std::optional<IlDatum> Read(int number, const Value& present) const;
  [[nodiscard]] IlWriteOutcome Write(int number, int code, MonotonicNs now);

  [[nodiscard]] int decimals() const { return type_.decimals; }

 private:
  void ShiftZero(int number, int code, MonotonicNs now);

  MovingHead head_;
  const dl_rs1a::Head& type_;
  bool is_main_;
  std::map<int, int> codes_;      ///< those that can be written, by data number
  std::map<int, int> requests_;   ///< last written to 001 and 002
  std::int32_t zero_counts_ = 0;  ///< subtracted from readings
  MonotonicNs settled_at_ = 0;
};

/// Errors (Cause::kUsage): a sampling cycle or averaging that an IL-1000 does not have, with those
/// it has.
[[nodiscard]] Result<void> ValidateIlHead(const trial::SensorHead& head);

}  // namespace haptometer::acquire::emulator
